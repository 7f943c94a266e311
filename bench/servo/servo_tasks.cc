// SPDX-License-Identifier: Apache-2.0
#include "bench/servo/servo_tasks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "control/law/bearing_servo.h"
#include "control/law/pbvs.h"
#include "control/law/point_servo.h"
#include "geometry/tait_bryan.h"

namespace kestrel::bench {
namespace {

using Eigen::Vector3d;

constexpr double kGoal_m = 2;
constexpr double kConverged_px = 1;

std::array<Vector3d, 4> Square(double half_m) {
  return {Vector3d(-half_m, -half_m, 0), {half_m, -half_m, 0}, {half_m, half_m, 0}, {-half_m, half_m, 0}};
}

Pose Before(double distance_m) { return {Eigen::Quaterniond::Identity(), {0, 0, -distance_m}}; }
Pose Turn(const Vector3d& axis, double angle_deg) {
  return {ExpRotation(Radians(angle_deg) * axis), {0, 0, 0}};
}

// Where a frame is after moving with a constant twist, exactly.
Pose Displacement(const control::Twist& twist, double t_s) {
  const Vector3d turn = twist.w * t_s, way = twist.v * t_s;
  const double a = turn.norm();
  // by their series where the quotients would lose digits
  const double k1 = a < 1e-4 ? 0.5 - a * a / 24 : (1 - std::cos(a)) / (a * a);
  const double k2 = a < 1e-4 ? 1.0 / 6 - a * a / 120 : (a - std::sin(a)) / (a * a * a);
  return {ExpRotation(turn), way + k1 * turn.cross(way) + k2 * turn.cross(turn.cross(way))};
}

// The points as a camera sees them; none if one is not before it.
std::optional<std::array<control::ImagePoint, 4>> See(const Pose& X_TC,
                                                      const std::array<Vector3d, 4>& target) {
  std::array<control::ImagePoint, 4> points;
  const Pose X_CT = X_TC.Inverse();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d p = X_CT * target[i];
    if (!(p.z() > 0)) return std::nullopt;
    points[i] = {p.head<2>() / p.z(), p.z()};
  }
  return points;
}

std::array<control::BearingPoint, 4> Bearings(const std::array<control::ImagePoint, 4>& points) {
  std::array<control::BearingPoint, 4> bearings;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d p = points[i].Z * points[i].s.homogeneous();
    bearings[i] = {p.normalized(), p.norm()};
  }
  return bearings;
}

control::Twist Answer(ServoLaw law, const std::array<control::ImagePoint, 4>& now,
                      const std::array<control::ImagePoint, 4>& wanted, const Pose& X_TC, const Pose& X_TD,
                      double lambda_per_s) {
  switch (law) {
    case ServoLaw::kPointsCurrent:
      return control::TwistOf(
          control::PointServo(now, wanted, control::InteractionChoice::kCurrent, lambda_per_s));
    case ServoLaw::kPointsDesired:
      return control::TwistOf(
          control::PointServo(now, wanted, control::InteractionChoice::kDesired, lambda_per_s));
    case ServoLaw::kPointsMean:
      return control::TwistOf(
          control::PointServo(now, wanted, control::InteractionChoice::kMean, lambda_per_s));
    case ServoLaw::kBearingsCurrent:
      return control::TwistOf(control::BearingServo(Bearings(now), Bearings(wanted),
                                                    control::InteractionChoice::kCurrent, lambda_per_s));
    case ServoLaw::kPoseTarget:
      return control::PbvsTargetTwist(X_TC.Inverse(), X_TD.Inverse(), lambda_per_s);
    case ServoLaw::kPose:
      return control::PbvsTwist(X_TD.Inverse() * X_TC, lambda_per_s);
  }
  return {};
}

}  // namespace

std::vector<ServoTask> ServoTasks() {
  const Pose goal = Before(kGoal_m);
  const Vector3d z = Vector3d::UnitZ(), x = Vector3d::UnitX();
  std::vector<ServoTask> tasks;
  for (const double angle_deg : {30.0, 60.0, 90.0, 120.0, 150.0, 175.0, 180.0}) {
    tasks.push_back({fmt::format("about the axis, {:g} deg", angle_deg), goal * Turn(z, angle_deg), goal});
  }
  for (const double distance_m : {1.2, 6.0}) {
    tasks.push_back(
        {fmt::format("along the axis, {:g} to {:g} m", distance_m, kGoal_m), Before(distance_m), goal});
  }
  for (const double angle_deg : {30.0, 60.0, 75.0}) {
    tasks.push_back(
        {fmt::format("about a line in the plane, {:g} deg", angle_deg), Turn(x, angle_deg) * goal, goal});
  }
  // Turned about the target, then aside, back and about all axes, so that all points are in view.
  tasks.push_back({"general, 45 deg about the axis",
                   Turn(Vector3d(1, -1, 0).normalized(), 40) * Before(3.5) *
                       Pose{ExpRotation({0.08, -0.1, Radians(45)}), {0.3, -0.2, 0}},
                   goal});
  tasks.push_back({"general, 110 deg about the axis",
                   Turn(Vector3d(1, 0.5, 0).normalized(), 35) * Before(3) *
                       Pose{ExpRotation({0, 0, Radians(110)}), {-0.2, 0.3, 0}},
                   goal});
  return tasks;
}

std::vector<ServoLaw> ServoLaws() {
  return {ServoLaw::kPointsCurrent,   ServoLaw::kPointsDesired, ServoLaw::kPointsMean,
          ServoLaw::kBearingsCurrent, ServoLaw::kPoseTarget,    ServoLaw::kPose};
}

const char* NameOf(ServoLaw law) {
  switch (law) {
    case ServoLaw::kPointsCurrent:
      return "points, current";
    case ServoLaw::kPointsDesired:
      return "points, desired";
    case ServoLaw::kPointsMean:
      return "points, mean";
    case ServoLaw::kBearingsCurrent:
      return "bearings, current";
    case ServoLaw::kPoseTarget:
      return "pose, target's place";
    case ServoLaw::kPose:
      return "pose, camera's place";
  }
  return "";
}

const char* NameOf(ServoEnd end) {
  switch (end) {
    case ServoEnd::kConverged:
      return "converged";
    case ServoEnd::kRetreated:
      return "retreated";
    case ServoEnd::kCrossed:
      return "crossed";
    case ServoEnd::kStalled:
      return "stalled";
    case ServoEnd::kTimeOut:
      return "time out";
  }
  return "";
}

ServoTrial FlyServoTask(const ServoTask& task, ServoLaw law, const ServoTrialOptions& options) {
  const std::array<Vector3d, 4> target = Square(options.half_side_m);
  const vision::Pinhole& camera = options.camera;
  const Pose X_DT = task.X_TC_goal.Inverse();
  const auto wanted = See(task.X_TC_goal, target);
  ServoTrial trial;
  if (!wanted) return trial.end = ServoEnd::kCrossed, trial;

  const auto depth_behind = [&](const Pose& X_TC) { return -(X_DT * X_TC.p).z(); };
  const double behind_at_first = std::max(0.0, depth_behind(task.X_TC_start));
  const double far = 100 * std::max(task.X_TC_start.p.norm(), task.X_TC_goal.p.norm());
  int within_since = -1;  // period; none
  Pose X_TC = task.X_TC_start;
  const int periods = static_cast<int>(std::lround(options.limit_s / options.period_s));
  for (int k = 0; k <= periods; ++k) {
    trial.retreat_m = std::max(trial.retreat_m, depth_behind(X_TC) - behind_at_first);
    if (X_TC.p.norm() > far) return trial.end = ServoEnd::kRetreated, trial;
    const auto now = See(X_TC, target);
    if (!now) return trial.end = ServoEnd::kCrossed, trial;

    double max_px = 0, square = 0;
    for (std::size_t i = 0; i < now->size(); ++i) {
      const Eigen::Vector2d from_centre = Eigen::Vector2d(camera.fx, camera.fy).cwiseProduct((*now)[i].s);
      const Eigen::Vector2d error =
          Eigen::Vector2d(camera.fx, camera.fy).cwiseProduct((*now)[i].s - (*wanted)[i].s);
      max_px = std::max(max_px, error.norm());
      square += error.squaredNorm();
      trial.excursion_px = std::max(trial.excursion_px, from_centre.norm());
      const Eigen::Vector2d uv = from_centre + Eigen::Vector2d(camera.cx, camera.cy);
      trial.in_view = trial.in_view && (uv.array() >= -0.5).all() && uv.x() < camera.width_px - 0.5 &&
                      uv.y() < camera.height_px - 0.5;
    }
    trial.final_px = std::sqrt(square / static_cast<double>(now->size()));
    if (max_px > kConverged_px) {
      within_since = -1;
    } else if (within_since < 0) {
      within_since = k;
    }

    const control::Twist twist = Answer(law, *now, *wanted, X_TC, task.X_TC_goal, options.lambda_per_s);
    // By the size of the scene: what would take a million times the time of the law.
    const double speed = twist.v.norm() / kGoal_m + twist.w.norm();
    if (within_since < 0 && speed < 1e-6 * options.lambda_per_s) return trial.end = ServoEnd::kStalled, trial;
    X_TC = X_TC * Displacement(twist, options.period_s);
    X_TC.R.normalize();
  }
  if (within_since >= 0) {
    trial.end = ServoEnd::kConverged;
    trial.converged_s = within_since * options.period_s;
  }
  return trial;
}

}  // namespace kestrel::bench
