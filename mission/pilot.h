// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "control/estimate/late_following.h"
#include "control/estimate/target_estimator.h"
#include "control/estimate/velocity_lag.h"
#include "control/law/pbvs.h"
#include "mission/caption/caption.h"
#include "mission/decision.h"
#include "vision/camera.h"

namespace kestrel::mission {

// What every flight over a pad has, by whatever camera: it knows where the aircraft is over the pad T, servoes to
// a place over it, and has a way to find it again.
class Pilot {
 public:
  explicit Pilot(const control::ServoGains& servo) : servo_(servo) {}
  virtual ~Pilot() = default;

  // Looks at a frame: fills the target, fix and vision_s of a new decision.
  virtual Decision Observe(const vision::Frame& frame, const control::VehicleState& state) = 0;
  // It knows the place, or did a moment ago.
  virtual bool HasEstimate() const = 0;
  // Now, not at the exposure. Only while HasEstimate().
  virtual const control::TargetEstimator::Estimate& where() const = 0;
  // Not HasEstimate(): the next move of the search. None: given up.
  virtual std::optional<control::Setpoint> Search(const control::VehicleState& state) = 0;
  virtual void Draw(cv::Mat& bgr) const = 0;  // on a frame as the camera gives it
  virtual std::vector<Caption> Captions(std::string_view phase) const = 0;
  // As Mission's: the last image of a second camera, as the pilot saw it; empty: there is none.
  virtual cv::Mat ProductImage() const { return {}; }

  void ChangeServo(const control::ServoGains& servo) { servo_ = servo; }
  // Servoes to a place and yaw in T. Only while HasEstimate().
  control::VelocitySetpoint GoTo(const Eigen::Vector3d& p_T, double yaw_T);
  // The same sideways, with a given velocity downwards.
  control::VelocitySetpoint DescendTo(const Eigen::Vector2d& p_T, double yaw_T, double sink_m_s);
  // Where it will be in T once the autopilot has flown what it was given; where it is, with one that is
  // prompt. Only while HasEstimate().
  Eigen::Vector3d Ahead_T() const;
  const control::LateFollowing& following() const { return following_; }
  control::VelocityLag MaxLag() const;  // of an autopilot that is given what GoTo and DescendTo return

 protected:
  // Of each frame, before anything is decided on it.
  void Hear(const control::VehicleState& state);

 private:
  void Give(const control::VelocitySetpoint& setpoint);

  control::ServoGains servo_;
  control::LateFollowing following_;
  double yaw_NB_ = 0;  // rad
};

}  // namespace kestrel::mission
