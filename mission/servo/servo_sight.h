// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "control/autopilot.h"
#include "control/estimate/plane_depth.h"
#include "control/estimate/state_history.h"
#include "mission/mission_type.h"
#include "mission/servo/servo_laws.h"
#include "mission/servo/servo_report.h"
#include "vision/camera/camera_model.h"
#include "vision/camera/pinhole.h"
#include "vision/landmark/pad_tracking.h"

namespace kestrel::mission {

// From where and how the pad is to be seen.
struct ServoGoal {
  double height_m = 3, yaw_rad = 0;  // above its middle; clockwise from the top of its picture
  double pad_tilt_rad = 0;           // how far that top is raised
  bool level_camera = true;          // see by the image of a level camera
};

// What the laws of visual servoing see of the pad: its corners in the image, as they are and as they are wanted.
class ServoSight {
 public:
  // Of a camera that looks straight down.
  ServoSight(const MissionParts& parts, const ServoGoal& goal);

  void AddState(const control::VehicleState& state) { history_.Add(state); }
  // By the attitude that the autopilot had at the exposure; view: the camera that the pad was seen by.
  const ServoView& Look(const vision::PadObservation& seen, const vision::Pinhole& view, double exposed_s,
                        const control::VehicleState& now);
  // The same with the way that the camera went by the autopilot, for an adaptive estimate of the depth.
  const ServoView& LookForDepth(const vision::PadObservation& seen, const vision::Pinhole& view,
                                double exposed_s, const control::VehicleState& now);

  const ServoView& view() const { return view_; }                  // of the last look
  const Eigen::Quaterniond& R_VC() const { return R_VC_; }         // of the same
  const control::VehicleState& then() const { return then_; }      // the autopilot's state at its exposure
  double height_m() const { return -view_.X_VT.Inverse().p.z(); }  // over the pad's plane

  const Eigen::Vector3d& goal_T() const { return goal_T_; }  // of the aircraft
  double goal_yaw_TB() const { return goal_yaw_TB_; }

  std::shared_ptr<ServoReport> ReportOf(const ServoAnswer& answer, const vision::Pinhole& view) const;
  // Crosses where the corners are wanted, and the ways to them, on a frame as the camera gave it.
  void Draw(cv::Mat& bgr) const;

 private:
  std::vector<control::ImagePoint> Corners(const Pose& X_VT) const;

  vision::CameraModel camera_;
  Pose X_BC_;
  ServoGoal goal_;
  std::vector<Eigen::Vector2d> outline_;
  Eigen::Vector3d goal_T_;
  double goal_yaw_TB_ = 0;
  control::StateHistory history_;
  control::PlaneDepth depth_;
  control::VehicleState then_;
  Eigen::Quaterniond R_VC_ = Eigen::Quaterniond::Identity();
  ServoView view_;
};

}  // namespace kestrel::mission
