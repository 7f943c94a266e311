// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/check/check_ground.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/file/model_files.h"
#include "geometry/tait_bryan.h"

namespace kestrel::flight {
namespace {

constexpr double kAircraft_m = 0.3;  // half of it, which must be in the image too
constexpr double kFewest_px = 1.8;   // diameter of a light

// Where a flight may begin, in T: the middle and the rim of the disc.
std::vector<Eigen::Vector3d> Starts(const sim::StartParameters& start, double pad_yaw_deg) {
  const Eigen::Rotation2Dd R_TN(-Radians(pad_yaw_deg));
  const double height = start.on_ground ? 0.15 : start.height_m;
  std::vector<Eigen::Vector3d> all;
  const auto add = [&](const Eigen::Vector2d& p_N) {
    const Eigen::Vector2d p_T = R_TN * p_N;
    all.emplace_back(p_T.x(), p_T.y(), -height);
  };
  add(start.offset_m);
  constexpr int kRim = 8;
  for (int i = 0; i < kRim && start.scatter_m > 0; ++i) {
    const double angle = 2 * std::numbers::pi * i / kRim;
    add(start.offset_m + start.scatter_m * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return all;
}

bool InImage(const vision::CameraModel& camera, const Eigen::Vector3d& p_C) {
  const auto uv = vision::Project(camera, p_C);
  return uv && uv->x() > 0 && uv->y() > 0 && uv->x() < vision::WidthPx(camera) - 1 &&
         uv->y() < vision::HeightPx(camera) - 1;
}

// Whether the aircraft there is wholly in the image, with the head at rest or turned to it.
bool Sees(const sim::GroundCameraParameters& ground, const Pose& X_TG, const Eigen::Vector3d& p_T) {
  vision::PanTilt at;
  if (const auto& head = ground.view.head) {
    at = vision::LookAt(X_TG, p_T, {});
    at.pan = std::clamp(at.pan, Radians(head->pan_min_deg), Radians(head->pan_max_deg));
    at.tilt = std::clamp(at.tilt, Radians(head->tilt_min_deg), Radians(head->tilt_max_deg));
  }
  const Pose X_CT = vision::CameraPose(X_TG, at).Inverse();
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-kAircraft_m, kAircraft_m})
      if (!InImage(ground.camera, X_CT * (p_T + side * Eigen::Vector3d::Unit(axis)))) return false;
  return true;
}

}  // namespace

void CheckGround(const sim::GroundCameraParameters& ground, const sim::StartParameters& start,
                 double pad_yaw_deg, const Config& config, const Place& file, Mistakes& mistakes) {
  const Place where = WhereOf(config, "ground_camera", file), view = WhereOf(config, "ground_view", file);
  if (!ground.view.image.colour)
    mistakes.Add(view, "ground_view.image.colour", "false, but the lights are told by their colours",
                 "valid: true");
  for (const sim::BlockedTime& blocked : ground.view.blocked)
    if (blocked.until_s <= blocked.from_s)
      mistakes.Add(view, "ground_view.blocked",
                   fmt::format("from {:g} s until {:g} s", blocked.from_s, blocked.until_s),
                   "valid: until_s after from_s");
  const Pose X_TG = vision::MastPose(ground.view.place.value_or(ground.place));
  const std::vector<Eigen::Vector3d> starts = Starts(start, pad_yaw_deg);
  const auto unseen = std::find_if(starts.begin(), starts.end(),
                                   [&](const Eigen::Vector3d& p_T) { return !Sees(ground, X_TG, p_T); });
  if (unseen != starts.end())
    mistakes.Add(
        ground.view.place ? view : where, ground.view.place ? "ground_view.place" : "ground_camera.place",
        fmt::format("the camera does not see the start at ({:.3g}, {:.3g}) m, {:.3g} m above the pad",
                    unseen->x(), unseen->y(), -unseen->z()),
        "valid: a place, yaw_deg and pitch_deg from which it does, a wider lens, or a "
        "ground_view.head that reaches it");
  double farthest_m = 0;
  for (const Eigen::Vector3d& p_T : starts) farthest_m = std::max(farthest_m, (p_T - X_TG.p).norm());
  const double size_px = ground.lights.diameter_m * vision::Parameters(ground.camera)[0] / farthest_m;
  if (size_px < kFewest_px)
    mistakes.Add(where, "ground_camera.lights.diameter_m",
                 fmt::format("{:g} is {:.2g} px at the start, {:.3g} m from the camera",
                             ground.lights.diameter_m, size_px, farthest_m),
                 fmt::format("valid: from {:.2g} on, a nearer place, or a longer lens",
                             ground.lights.diameter_m * kFewest_px / size_px));
}

}  // namespace kestrel::flight
