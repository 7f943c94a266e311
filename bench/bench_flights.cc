// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_flights.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "base/statistics.h"
#include "bench/pad_scene.h"
#include "geometry/tait_bryan.h"
#include "vision/landmark/pad_tracker.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::bench {
namespace {

// The share of the pad that the camera can truly see in a frame: inside the image and not under the occluder,
// which covers the pad from its +x end.
double InView(const records::LogRow& row, const flight::LoadedScenario& loaded) {
  const sim::OcclusionParameters& o = loaded.simulator.occlusion;
  const bool hidden = row.exposure.t_s >= o.from_s && row.exposure.t_s < o.until_s;
  const Eigen::Vector2d size = loaded.simulator.scene.pad.size_m;
  const double x0 = -size.x() / 2, x1 = size.x() * (0.5 - (hidden ? o.share : 0)), y = size.y() / 2;
  const vision::Pinhole& camera = std::get<vision::Pinhole>(loaded.simulator.camera);
  const Pose X_CT =
      (row.exposure.X_NT.Inverse() * row.exposure.X_NB * vision::MountPose(loaded.simulator.mount)).Inverse();
  const Eigen::Matrix3d H = vision::HomographyFromPose(X_CT, camera), H_inverse = H.inverse();
  std::vector<cv::Point2f> open, seen, on_pad;
  const auto add = [](std::vector<cv::Point2f>& to, const Eigen::Vector2d& p) {
    to.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  };
  for (const auto& corner :
       {Eigen::Vector2d(x0, -y), Eigen::Vector2d(x1, -y), Eigen::Vector2d(x1, y), Eigen::Vector2d(x0, y)}) {
    add(open, vision::Transfer(H, corner));
  }
  const float w = static_cast<float>(camera.width_px), h = static_cast<float>(camera.height_px);
  const std::vector<cv::Point2f> image = {{0, 0}, {w, 0}, {w, h}, {0, h}};
  if (!(cv::intersectConvexConvex(open, image, seen) > 0)) return 0;
  for (const cv::Point2f& p : seen) add(on_pad, vision::Transfer(H_inverse, {p.x, p.y}));
  return cv::contourArea(on_pad) / size.prod();
}

// Errors of the fixes against the truth, over all flights together.
struct FixErrors {
  double x = 0, y = 0, z = 0, yaw = 0;  // sums of squares, then roots of their means
  int fixes = 0, frames = 0;
  double Level() const { return std::hypot(x, y); }
  double Share() const { return static_cast<double>(fixes) / std::max(frames, 1); }
};

// Of the frames from a time on in which between least and most of the pad is in view.
FixErrors ErrorsOf(const std::vector<flight::FlownScenario>& flights, double from_s = 0, double least = 0,
                   double most = 1) {
  FixErrors e;
  for (const flight::FlownScenario& flight : flights) {
    for (const records::LogRow& row : flight.rows) {
      if (row.exposure.t_s < from_s) continue;
      const double in_view = InView(row, flight.loaded);
      if (in_view < least || in_view > most + 1e-6) continue;
      ++e.frames;
      if (!row.decision.fix) continue;
      ++e.fixes;
      const Pose X_TB = row.exposure.X_NT.Inverse() * row.exposure.X_NB;
      const Eigen::Vector3d d = row.decision.fix->p_TB - X_TB.p;
      e.x += d.x() * d.x(), e.y += d.y() * d.y(), e.z += d.z() * d.z();
      e.yaw += std::pow(Degrees(WrapAngle(row.decision.fix->yaw_TB - YawOf(X_TB.R))), 2);
    }
  }
  // Without a fix nothing is met.
  for (double* sum : {&e.x, &e.y, &e.z, &e.yaw}) {
    *sum = e.fixes > 0 ? std::sqrt(*sum / e.fixes) : std::numeric_limits<double>::infinity();
  }
  return e;
}

// What a pose flight reached, beside its targets.
void AddPose(const std::string& name, const FixErrors& e, double level, double height, double yaw,
             const char* thesis, std::vector<records::Figure>& table) {
  table.push_back({name + ", x RMSE", e.x, "m", level, false, thesis});
  table.push_back({name + ", y RMSE", e.y, "m", level, false, thesis});
  table.push_back({name + ", z RMSE", e.z, "m", height, false, thesis});
  table.push_back({name + ", yaw RMSE", e.yaw, "deg", yaw, false, thesis});
}

// What thesis 4.4.2 measured: the fix less the autopilot's own estimate, which errs too.
void AddLessAutopilot(const std::string& name, const std::vector<flight::FlownScenario>& flights,
                      const std::array<const char*, 4>& thesis, std::vector<records::Figure>& table) {
  const std::array<std::array<const char*, 3>, 4> axes = {{{"x", "fix_autopilot_x_rms_m", "m"},
                                                           {"y", "fix_autopilot_y_rms_m", "m"},
                                                           {"z", "fix_autopilot_z_rms_m", "m"},
                                                           {"yaw", "fix_autopilot_yaw_rms_deg", "deg"}}};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto& [axis, metric, unit] = axes[i];
    std::vector<double> squares = flight::Values(flights, metric);
    for (double& value : squares) value *= value;
    table.push_back({name + ", fix less the autopilot's estimate, " + axis + " RMS",
                     std::sqrt(Mean(squares)),
                     unit,
                     {},
                     false,
                     thesis[i]});
  }
}

// What landings reached, beside the targets that hold for any camera.
void AddLandings(const std::string& name, const std::vector<flight::FlownScenario>& flights,
                 std::vector<records::Figure>& table) {
  const auto landed = std::count_if(flights.begin(), flights.end(), [](const flight::FlownScenario& f) {
    return f.summary.outcome == "landed" && f.summary.metrics.contains("rest_error_m");
  });
  const std::vector<double> error = flight::Values(flights, "touchdown_error_m");
  table.push_back({name + ", share that landed",
                   static_cast<double>(landed) / static_cast<double>(flights.size()), "", 1, true, ""});
  table.push_back({name + ", touch-down error, median", Quantile(error, 0.5), "m", 0.05, false, "not given"});
  table.push_back(
      {name + ", touch-down error, 95th percentile", Quantile(error, 0.95), "m", 0.12, false, "not given"});
  table.push_back({name + ", maximum sink rate", Largest(flight::Values(flights, "touchdown_sink_m_s")),
                   "m/s", 0.4, false, "0.2"});
  table.push_back(
      {name + ", maximum tilt", Largest(flight::Values(flights, "touchdown_tilt_deg")), "deg", 8, false, ""});
}

}  // namespace

void BenchFlights(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  constexpr double kHalf = 0.5;    // in view: enough to ask for a fix in every frame
  constexpr double kLeast = 0.25;  // 70 % hidden leaves 30 %, less what hangs over the image's edge
  constexpr double kHiddenFrom_s = 10;
  {
    const auto open = flight::FlyAll("pose", {}, seeds, jobs, "pose at 4.2 m");
    AddPose("pose 4.2 m", ErrorsOf(open), 0.05, 0.04, 0.5, "", table);
    AddLessAutopilot("pose 4.2 m", open, {"0.42", "0.16", "0.16", "2"}, table);
    table.push_back({"pose 4.2 m, frames tracked with half of the pad in view",
                     ErrorsOf(open, 0, kHalf).Share(), "share", 0.98, true, ""});
    const auto hidden =
        flight::FlyAll("pose", {"occlusion.share=0.7", fmt::format("occlusion.from_s={}", kHiddenFrom_s)},
                       seeds, jobs, "pose, 70 % of the pad hidden");
    const FixErrors before = ErrorsOf(open, kHiddenFrom_s), after = ErrorsOf(hidden, kHiddenFrom_s, kLeast);
    AddPose("70 % hidden, within twice the open targets", after, 0.10, 0.08, 1.0, "tracked", table);
    table.push_back({"70 % hidden, frames tracked with 25 % of the pad in view", after.Share(), "share", 0.95,
                     true, "tracked"});
    table.push_back({"70 % hidden, horizontal RMSE over our own in the open", after.Level() / before.Level(),
                     "times", 2, false, ""});
    table.push_back(
        {"70 % hidden, z RMSE over our own in the open", after.z / before.z, "times", 2, false, ""});
    table.push_back(
        {"70 % hidden, yaw RMSE over our own in the open", after.yaw / before.yaw, "times", 2, false, ""});
  }
  {
    const auto flights = flight::FlyAll("pose_high", {}, seeds, jobs, "pose at 10 m");
    AddPose("pose 10 m", ErrorsOf(flights), 0.15, 0.10, 1, "", table);
    AddLessAutopilot("pose 10 m", flights, {"", "", "0.85", "4"}, table);
    table.push_back({"pose 10 m, frames tracked with half of the pad in view",
                     ErrorsOf(flights, 0, kHalf).Share(), "share", 0.98, true, ""});
  }
  {
    const auto flights = flight::FlyAll("hover", {}, seeds, jobs, "hover at 3 m");
    table.push_back({"hover 3 m, horizontal RMSE", Rms(flight::Values(flights, "hold_horizontal_rmse_m")),
                     "m", 0.08, false, "not given"});
    table.push_back({"hover 3 m, vertical RMSE", Rms(flight::Values(flights, "hold_vertical_rmse_m")), "m",
                     0.05, false, "not given"});
    table.push_back(
        {"hover 3 m, latest settling", Largest(flight::Values(flights, "settle_s")), "s", 15, false, ""});
  }
  AddLandings("landing", flight::FlyAll("landing", {}, seeds, jobs, "landing"), table);
}

void BenchFisheye(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  AddLandings("fisheye landing",
              flight::FlyAll("landing_fisheye", {}, seeds, jobs, "landing with the fisheye"), table);
}

void BenchDrift(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  const auto errors = [&](bool registration) {
    return ErrorsOf(
        flight::FlyAll("pose", {fmt::format("pilot.tracker.registration={}", registration), "duration_s=60"},
                       seeds, jobs, registration ? "registered" : "chained"),
        30);
  };
  const FixErrors chained = errors(false), registered = errors(true);
  const auto all = [](const FixErrors& e) { return std::sqrt(e.x * e.x + e.y * e.y + e.z * e.z); };
  table.push_back(
      {"chain of homographies alone, position RMSE after 30 to 60 s", all(chained), "m", {}, false, ""});
  table.push_back(
      {"registered to the reference, position RMSE after 30 to 60 s", all(registered), "m", {}, false, ""});
  table.push_back({"gain of the registration", all(chained) / all(registered), "times", 1, true, ""});
}

// The tracker alone, on images drawn along a path that goes from 3 m to each height and stays there, swaying.
void BenchHeights(flight::SeedRange seeds, std::vector<records::Figure>& table) {
  PadScene scene;
  for (const double height : {0.3, 0.5, 1.0, 2.0, 6.0, 9.0, 12.0, 15.0}) {
    int frames = 0, seen = 0;
    double square = 0;
    for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
      const PadSway sway(seed, "path");
      vision::PadTracker tracker(scene.loaded().pad,
                                 std::get<vision::Pinhole>(scene.loaded().simulator.camera),
                                 scene.loaded().scenario.pilot.tracker);
      const sim::ImageSensor sensor = scene.Sensor(seed);
      constexpr int kTravel = 80, kStay = 40;
      for (int k = 0; k < kTravel + kStay; ++k) {
        const double h = 3 * std::pow(height / 3, std::min(1.0, static_cast<double>(k) / kTravel));
        const Pose X_TC = sway.X_TC(h, k / 20.0);
        const auto observation = tracker.Track(sensor.Expose(scene.Render(X_TC), k), std::nullopt);
        if (k < kTravel) continue;
        ++frames;
        if (!observation || !observation->registered) continue;
        ++seen;
        square += (observation->X_CT.Inverse().p - X_TC.p).squaredNorm();
      }
    }
    table.push_back({fmt::format("{:g} m, frames tracked", height), static_cast<double>(seen) / frames,
                     "share", 0.95, true, height < 0.5 || height > 12 ? "-" : "tracked"});
    table.push_back({fmt::format("{:g} m, position RMSE, vision alone", height),
                     std::sqrt(square / std::max(seen, 1)),
                     "m",
                     {},
                     false,
                     ""});
  }
}

void BenchSpeed(flight::SeedRange seeds, std::vector<records::Figure>& table) {
  seeds.last = std::min(seeds.last, seeds.first + 4);
  std::vector<double> vision, factor;
  for (const flight::FlownScenario& flight :
       flight::FlyAll("landing", {}, seeds, 1, "landing, one at a time")) {
    vision.push_back(flight.summary.stages.at("vision").mean_ms);
    factor.push_back(flight.summary.sim_s / flight.summary.wall_s);
    const records::Summary& s = flight.summary;
    fmt::print("seed {}: {:.1f} x real time; ms a frame, mean and 99th percentile:", s.seed,
               s.sim_s / s.wall_s);
    for (const auto& [stage, time] : s.stages)
      fmt::print("  {} {:.2f} {:.2f}", stage, time.mean_ms, time.p99_ms);
    fmt::print("\n");
  }
  table.push_back({"vision, one core, mean a frame", Quantile(vision, 0.5), "ms", 8, false, "83"});
  table.push_back(
      {"whole loop, 640x480, 20 frames/s, no video", Quantile(factor, 0.5), "x real time", 10, true, "1"});
}

}  // namespace kestrel::bench
