// SPDX-License-Identifier: Apache-2.0
#include "mission/servo/servo_sight.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "control/law/level_camera.h"
#include "geometry/tait_bryan.h"
#include "vision/drawn_colours.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::mission {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

control::ImagePoint At(const Pose& X_VT, const Vector3d& p_T) {
  const Vector3d p = X_VT * p_T;
  return {p.head<2>() / p.z(), p.z()};
}

}  // namespace

ServoSight::ServoSight(const MissionParts& parts, const ServoGoal& goal)
    : camera_(parts.camera),
      X_BC_(parts.X_BC),
      goal_(goal),
      outline_(parts.pad.Outline()),
      depth_({.depth_m = goal.height_m}) {
  const Eigen::Quaterniond R_TN(RotationFromTaitBryan({0, goal.pad_tilt_rad, 0}).transpose());
  const Pose X_TB{R_TN * HeadingRotation(goal.yaw_rad), R_TN * Vector3d(0, 0, -goal.height_m)};
  goal_T_ = X_TB.p, goal_yaw_TB_ = YawOf(X_TB.R);
  view_.X_DT = (X_TB * X_BC_).Inverse();
  view_.corners_wanted = Corners(view_.X_DT);
  view_.centre_wanted = At(view_.X_DT, Vector3d::Zero());
  view_.down_V = control::LevelDown(X_BC_.R);
}

std::vector<control::ImagePoint> ServoSight::Corners(const Pose& X_VT) const {
  std::vector<control::ImagePoint> corners;
  for (const Vector2d& corner : outline_) corners.push_back(At(X_VT, {corner.x(), corner.y(), 0}));
  return corners;
}

const ServoView& ServoSight::Look(const vision::PadObservation& seen, const vision::Pinhole& view,
                                  double exposed_s, const control::VehicleState& now) {
  then_ = history_.At(exposed_s).value_or(now);
  const TaitBryan angles = TaitBryanFromRotation(then_.R_NB.toRotationMatrix());
  R_VC_ = goal_.level_camera ? control::LevelRotation(angles.roll, angles.pitch, X_BC_.R)
                             : Eigen::Quaterniond::Identity();
  view_.X_VT = Pose{R_VC_, Vector3d::Zero()} * seen.X_CT;
  // The points are the image's own, by the homography; the pose has but their depths.
  const auto place = [&](control::ImagePoint& point, const Vector2d& p_T) {
    const Vector2d uv = vision::Transfer(seen.H_w, p_T);
    const Vector3d ray = R_VC_ * Vector3d((uv.x() - view.cx) / view.fx, (uv.y() - view.cy) / view.fy, 1);
    point = At(view_.X_VT, {p_T.x(), p_T.y(), 0});
    if (ray.z() > 0) point.s = ray.hnormalized();
  };
  view_.corners.resize(outline_.size());
  for (std::size_t i = 0; i < outline_.size(); ++i) place(view_.corners[i], outline_[i]);
  place(view_.centre, Vector2d::Zero());
  return view_;
}

const ServoView& ServoSight::LookForDepth(const vision::PadObservation& seen, const vision::Pinhole& view,
                                          double exposed_s, const control::VehicleState& now) {
  Look(seen, view, exposed_s, now);
  const Eigen::Quaterniond R_NV = HeadingRotation(YawOf(then_.R_NB)) * X_BC_.R;
  std::vector<Vector2d> north;
  for (const control::ImagePoint& p : view_.corners)
    north.push_back((R_NV * Vector3d(p.s.homogeneous())).hnormalized());
  depth_.Add(exposed_s, north, then_.v_N);
  view_.plane_depth_m = depth_.depth_m();
  return view_;
}

std::shared_ptr<ServoReport> ServoSight::ReportOf(const ServoAnswer& answer,
                                                  const vision::Pinhole& view) const {
  const auto report = std::make_shared<ServoReport>();
  const auto pixel = [&](const Vector2d& s) {
    return Vector2d(view.cx + view.fx * s.x(), view.cy + view.fy * s.y());
  };
  double square = 0;
  for (std::size_t i = 0; i < report->corners_px.size(); ++i) {
    report->corners_px[i] = pixel(view_.corners[i].s);
    report->wanted_px[i] = pixel(view_.corners_wanted[i].s);
    square += (report->corners_px[i] - report->wanted_px[i]).squaredNorm();
  }
  report->error_px = std::sqrt(square / static_cast<double>(report->corners_px.size()));
  report->state = answer.state;
  report->conditioning = answer.conditioning, report->reach = answer.reach;
  report->depth_m = view_.plane_depth_m.value_or(view_.centre.Z);
  return report;
}

void ServoSight::Draw(cv::Mat& bgr) const {
  const auto on_image = [&](const control::ImagePoint& point) -> std::optional<cv::Point> {
    const auto at = vision::Project(camera_, R_VC_.conjugate() * Vector3d(point.s.homogeneous()));
    if (!at || !(at->norm() < 1e4)) return std::nullopt;
    return cv::Point(static_cast<int>(at->x()), static_cast<int>(at->y()));
  };
  for (std::size_t i = 0; i < view_.corners.size(); ++i) {
    const auto to = on_image(view_.corners_wanted[i]), from = on_image(view_.corners[i]);
    if (!to || !from) continue;
    cv::line(bgr, *from, *to, cv::Scalar(255, 255, 255), 1, cv::LINE_AA);
    cv::drawMarker(bgr, *to, vision::kSetpointColour, cv::MARKER_CROSS, 16, 2, cv::LINE_AA);
  }
}

}  // namespace kestrel::mission
