// SPDX-License-Identifier: Apache-2.0
#include "flight/hardware/pre_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "base/stopwatch.h"
#include "geometry/tait_bryan.h"

namespace kestrel::flight {
namespace {

// What a camera gave while it was watched.
struct Watched {
  int images = 0;
  double first_s = 0, last_s = 0;
  std::optional<vision::Frame> frame;

  double RateHz() const { return images > 1 ? (images - 1) / (last_s - first_s) : 0; }
};

constexpr double kSlice_s = 0.05;  // in which an interrupt is looked for

bool Interrupted(const PreFlightOptions& o) { return o.interrupted && *o.interrupted; }

void Wait(const PreFlightOptions& o, const char* what, const std::string& why, double since_s) {
  if (o.waits) o.waits(fmt::format("{}{}{}", what, why.empty() ? "" : ": ", why), MonotonicNow_s() - since_s);
}

Watched Watch(vision::LiveCamera& camera, const char* first, const PreFlightOptions& o) {
  Watched watched;
  const double begun_s = MonotonicNow_s();
  double until_s = begun_s + o.wait_s;
  while (!Interrupted(o)) {
    const double left_s = until_s - MonotonicNow_s();
    if (left_s <= 0) break;
    const auto frame = camera.Next(std::min(left_s, kSlice_s));
    if (!frame) {
      const vision::LiveCameraHealth health = camera.Health();
      if (health.state == vision::LiveCameraState::kEnded) break;
      if (watched.images == 0) Wait(o, first, health.error, begun_s);
      continue;
    }
    if (watched.images++ == 0) watched.first_s = frame->t_s, until_s = MonotonicNow_s() + o.watch_s;
    watched.last_s = frame->t_s;
    watched.frame = frame;
  }
  return watched;
}

CheckItem RateItem(double rate_hz, double wanted_hz, const PreFlightOptions& o) {
  CheckItem item{"camera rate", fmt::format("{:.1f} images/s of {:g}", rate_hz, wanted_hz), true};
  if (!(rate_hz >= o.min_rate * wanted_hz)) {
    item.ok = false;
  } else if (rate_hz > o.max_rate * wanted_hz) {
    item.ok = false;
    item.found += fmt::format(
        ": more than {:g} times as many; give the camera the flight's rate (--camera ...?rate={:g}) or the "
        "flight the camera's (--set image.rate_hz={:.0f})",
        o.max_rate, wanted_hz, rate_hz);
  }
  return item;
}

// Why no image came that can be flown by.
std::string NoImageText(const vision::LiveCamera& camera, double waited_s) {
  const vision::LiveCameraHealth health = camera.Health();
  return health.error.empty()
             ? fmt::format("no image in {:.0f} s: {}", waited_s, vision::NameOf(health.state))
             : fmt::format("none in {:.0f} s that can be flown by: {}", waited_s, health.error);
}

// Of the second camera: whether it gives images that its mission can use, by the clock of this computer.
CheckItem GroundItem(const LoadedPlan& plan, vision::LiveCamera& camera, const PreFlightOptions& o) {
  constexpr double kFewest_hz = 5, kOldest_s = 1.5;
  const double begun_s = MonotonicNow_s();
  const Watched watched = Watch(camera, "the ground camera's first image", o);
  const double now_s = MonotonicNow_s();
  CheckItem item{"ground camera", "", false};
  if (watched.images == 0 || !plan.parts.ground) {
    item.found = NoImageText(camera, now_s - begun_s);
    return item;
  }
  const cv::Mat& image = watched.frame->image;
  const vision::CameraModel& model = plan.parts.ground->camera;
  const double age_s = now_s - watched.last_s;
  const bool of_size = image.cols == vision::WidthPx(model) && image.rows == vision::HeightPx(model);
  item.ok =
      watched.RateHz() >= kFewest_hz && of_size && image.channels() == 3 && age_s > 0 && age_s < kOldest_s;
  item.found =
      fmt::format("{:.1f} images/s, {} x {} px, {}, stamped {:.0f} ms before they came", watched.RateHz(),
                  image.cols, image.rows, image.channels() == 3 ? "colour" : "grey", 1e3 * age_s);
  if (item.ok) return item;
  item.found += fmt::format("; it is to give {:g} and more, {} x {} px, colour, stamped up to {:g} s before",
                            kFewest_hz, vision::WidthPx(model), vision::HeightPx(model), kOldest_s);
  return item;
}

double TiltOf(const control::VehicleState& state) {
  return std::acos(std::clamp((state.R_NB * Eigen::Vector3d::UnitZ()).z(), -1.0, 1.0));
}

CheckItem StateItem(const control::VehicleState& s, const PreFlightOptions& o) {
  CheckItem item{"state", "", false};
  if (!control::Finite(s)) {
    item.found = "not finite";
  } else if (std::abs(s.R_NB.norm() - 1) > 0.01) {
    item.found = "the attitude is no rotation";
  } else if (TiltOf(s) > Radians(o.sane_tilt_deg)) {
    item.found = fmt::format("tilted by {:.0f} deg", Degrees(TiltOf(s)));
  } else if (s.v_N.norm() > o.sane_speed_m_s) {
    item.found = fmt::format("moving at {:.1f} m/s", s.v_N.norm());
  } else {
    item.ok = true;
    item.found = fmt::format("{}, {:.1f} m high, tilt {:.1f} deg, {:.1f} m/s", control::NameOf(s.mode),
                             -s.p_NB.z(), Degrees(TiltOf(s)), s.v_N.norm());
  }
  return item;
}

// What is heard of the autopilot; of one that is there and tells no state, both.
std::string LinkText(const control::LinkHealth& health, double waited_s) {
  if (health.state_age_s)
    return health.error.empty() ? fmt::format("state {:.0f} ms old", 1e3 * *health.state_age_s)
                                : health.error;
  return fmt::format("no state in {:.0f} s{}: {}", waited_s,
                     health.open ? " of the autopilot that is heard" : "",
                     health.error.empty() ? "nothing came" : health.error);
}

}  // namespace

std::vector<CheckItem> PreFlight(const LoadedPlan& plan, vision::LiveCamera& camera,
                                 const control::AutopilotLink& link, const PreFlightOptions& o) {
  std::vector<CheckItem> items;
  const auto add = [&](const char* name, bool ok, std::string found) {
    items.push_back({name, std::move(found), ok});
  };
  const double begun_s = MonotonicNow_s();
  const Watched watched = Watch(camera, "the camera's first image", o);
  const double wanted_hz = plan.plan.image.rate_hz;
  if (watched.images == 0) {
    add("camera", false, NoImageText(camera, MonotonicNow_s() - begun_s));
  } else {
    items.push_back(RateItem(watched.RateHz(), wanted_hz, o));
    const cv::Mat& image = watched.frame->image;
    const vision::CameraModel& model = plan.parts.camera;
    add("image against calibration",
        image.cols == vision::WidthPx(model) && image.rows == vision::HeightPx(model),
        fmt::format("{} x {} px, '{}' is of {} x {}", image.cols, image.rows, plan.plan.camera,
                    vision::WidthPx(model), vision::HeightPx(model)));
    const bool colour = image.channels() == 3;
    add("colour", colour == plan.plan.image.colour,
        fmt::format("{}, the flight wants {}", colour ? "colour" : "grey",
                    plan.plan.image.colour ? "colour" : "grey"));
  }
  if (o.ground) items.push_back(GroundItem(plan, *o.ground, o));
  control::LinkHealth health = link.Health();
  const auto alive = [&] { return health.state_age_s && *health.state_age_s < 0.5; };
  const double link_s = watched.images > 0 ? MonotonicNow_s() : begun_s;
  while (!alive() && !Interrupted(o) && MonotonicNow_s() - link_s < o.wait_s) {
    Wait(o, "the autopilot's state", health.error, link_s);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    health = link.Health();
  }
  add("link", alive() && health.error.empty(), LinkText(health, MonotonicNow_s() - link_s));
  if (health.state_age_s) items.push_back(StateItem(link.State(), o));
  if (!health.pilot_allows && (!alive() || !health.open)) {  // whatever it would tell, it tells nothing
    add("pilot's switch", false,
        health.open ? "not known: no state comes" : "not known: the autopilot is not heard");
    return items;
  }
  add("pilot's switch", health.pilot_allows.value_or(o.pilot_untold),
      health.pilot_allows ? *health.pilot_allows ? "on" : "off"
      : o.pilot_untold    ? "not told by this autopilot; taken as on (--pilot-untold)"
                          : "not told by this autopilot; with --pilot-untold it counts as on");
  return items;
}

bool AllOk(const std::vector<CheckItem>& items) {
  return std::all_of(items.begin(), items.end(), [](const CheckItem& item) { return item.ok; });
}

}  // namespace kestrel::flight
