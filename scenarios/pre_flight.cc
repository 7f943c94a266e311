// SPDX-License-Identifier: Apache-2.0
#include "scenarios/pre_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "config/stopwatch.h"
#include "geometry/tait_bryan.h"

namespace kestrel {
namespace {

// What a camera gave while it was watched.
struct Watched {
  int images = 0;
  double first_s = 0, last_s = 0;
  std::optional<Frame> frame;

  double RateHz() const { return images > 1 ? (images - 1) / (last_s - first_s) : 0; }
};

Watched Watch(LiveCamera& camera, const PreFlightOptions& o) {
  Watched watched;
  auto frame = camera.Next(o.connect_s);
  const double until_s = MonotonicNow_s() + o.watch_s;
  for (; frame; frame = camera.Next(std::max(0.0, until_s - MonotonicNow_s()))) {
    if (watched.images++ == 0) watched.first_s = frame->t_s;
    watched.last_s = frame->t_s;
    watched.frame = frame;
    if (MonotonicNow_s() >= until_s) break;
  }
  return watched;
}

double TiltOf(const VehicleState& state) {
  return std::acos(std::clamp((state.R_NB * Eigen::Vector3d::UnitZ()).z(), -1.0, 1.0));
}

CheckItem StateItem(const VehicleState& s, const PreFlightOptions& o) {
  CheckItem item{"state", "", false};
  if (!Finite(s)) {
    item.found = "not finite";
  } else if (std::abs(s.R_NB.norm() - 1) > 0.01) {
    item.found = "the attitude is no rotation";
  } else if (TiltOf(s) > Radians(o.sane_tilt_deg)) {
    item.found = fmt::format("tilted by {:.0f} deg", Degrees(TiltOf(s)));
  } else if (s.v_N.norm() > o.sane_speed_m_s) {
    item.found = fmt::format("moving at {:.1f} m/s", s.v_N.norm());
  } else {
    item.ok = true;
    item.found = fmt::format("{}, {:.1f} m high, tilt {:.1f} deg, {:.1f} m/s", NameOf(s.mode), -s.p_NB.z(),
                             Degrees(TiltOf(s)), s.v_N.norm());
  }
  return item;
}

}  // namespace

std::vector<CheckItem> PreFlight(const LoadedPlan& plan, LiveCamera& camera, const AutopilotLink& link,
                                 const PreFlightOptions& o) {
  std::vector<CheckItem> items;
  const auto add = [&](const char* name, bool ok, std::string found) {
    items.push_back({name, std::move(found), ok});
  };
  const double begun_s = MonotonicNow_s();
  const Watched watched = Watch(camera, o);
  const double wanted_hz = plan.plan.image.rate_hz;
  if (watched.images == 0) {
    const LiveCameraHealth health = camera.Health();
    add("camera", false,
        fmt::format("no image in {:.0f} s: {}", o.connect_s,
                    health.trouble.empty() ? NameOf(health.state) : health.trouble));
  } else {
    add("camera rate", watched.RateHz() >= o.least_rate * wanted_hz,
        fmt::format("{:.1f} images/s of {:g}", watched.RateHz(), wanted_hz));
    const cv::Mat& image = watched.frame->image;
    const CameraModel& model = plan.parts.camera;
    add("image against calibration", image.cols == WidthPx(model) && image.rows == HeightPx(model),
        fmt::format("{} x {} px, '{}' is of {} x {}", image.cols, image.rows, plan.plan.camera,
                    WidthPx(model), HeightPx(model)));
    const bool colour = image.channels() == 3;
    add("colour", colour == plan.plan.image.colour,
        fmt::format("{}, the flight wants {}", colour ? "colour" : "grey",
                    plan.plan.image.colour ? "colour" : "grey"));
  }
  LinkHealth health = link.Health();
  const auto alive = [&] { return health.state_age_s && *health.state_age_s < 0.5; };
  while (!alive() && MonotonicNow_s() - begun_s < o.connect_s) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    health = link.Health();
  }
  add("link", alive() && health.trouble.empty(),
      !health.state_age_s       ? "no state was heard" + (health.trouble.empty() ? "" : ": " + health.trouble)
      : !health.trouble.empty() ? health.trouble
                                : fmt::format("state {:.0f} ms old", 1e3 * *health.state_age_s));
  if (health.state_age_s) items.push_back(StateItem(link.State(), o));
  add("pilot's switch", health.pilot_allows.value_or(o.pilot_untold),
      health.pilot_allows ? *health.pilot_allows ? "on" : "off"
      : o.pilot_untold    ? "not told by this autopilot; taken as on (--pilot-untold)"
                          : "not told by this autopilot; with --pilot-untold it counts as on");
  return items;
}

bool AllOk(const std::vector<CheckItem>& items) {
  return std::all_of(items.begin(), items.end(), [](const CheckItem& item) { return item.ok; });
}

}  // namespace kestrel
