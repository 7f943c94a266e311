// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "base/yaml/fields.h"
#include "control/estimate/target_estimator.h"
#include "control/law/pbvs.h"
#include "mission/mission.h"
#include "mission/pilot.h"
#include "vision/camera/camera_model.h"
#include "vision/camera/views.h"
#include "vision/capture/frozen_image.h"
#include "vision/landmark/pad_reference.h"
#include "vision/landmark/pad_tracker.h"

namespace kestrel::mission {

// What the tracker looks through: a pinhole itself, or within any other camera the virtual one along its axis
// (thesis 6.6). None: the camera does not see along its own axis.
std::optional<vision::Pinhole> TrackersCamera(const vision::CameraModel& camera);

// The fix of an aircraft that is there by an observation of the pad.
TargetFix FixBy(const vision::PadObservation& seen, const Pose& X_TB);
// What a decision says of its target: frozen, the same image again; seen: none, it is lost; fix: none, what was seen
// cannot be where it is expected.
void TellPad(bool frozen, const std::optional<vision::PadObservation>& seen,
             const std::optional<TargetFix>& fix, Decision& decision);

struct SearchParameters {
  double stop_s = 0.5;
  double climb_m_s = 0.8;
  double ceiling_m = 12;
  double give_up_s = 90;
};

inline void Fields(FieldVisitor& v, SearchParameters& p) {
  v({"stop_s",
     "time out of sight after which the search for the pad begins, and for which it hovers before it climbs"},
    p.stop_s, 0.0, 10.0);
  v({"climb_m_s", "climb rate of the search"}, p.climb_m_s, 0.05, 3.0);
  v({"ceiling_m",
     "height above the autopilot's local origin up to which the search climbs, then to fly a growing square"},
    p.ceiling_m, 1.0, 60.0);
  v({"give_up_s", "time of searching after which the mission gives up"}, p.give_up_s, 1.0, 3600.0);
}

struct PilotParameters {
  vision::PadTrackerOptions tracker;
  control::TargetEstimatorOptions estimator;
  control::ServoGains servo;
  SearchParameters search;
};

inline void Fields(FieldVisitor& v, PilotParameters& p) {
  v({"tracker", "tracking of the pad from image to image"}, p.tracker);
  v({"estimator", "Kalman filter of the aircraft's position and velocity over the pad"}, p.estimator);
  v({"servo", "gains and limits of position-based visual servoing"}, p.servo);
  v({"search", "what to do while the pad is out of sight: stop, climb, fly a growing square"}, p.search);
}

// What every helipad flight shares: it sees the pad, knows where the aircraft is over it, servoes to a place
// over it, and searches when it is lost.
class HelipadPilot final : public Pilot {
 public:
  // A camera that has a TrackersCamera.
  HelipadPilot(vision::PadReference reference, const vision::CameraModel& camera, const Pose& X_BC,
               const PilotParameters& parameters);

  // Looks at a frame: fills the target, fix and vision_s of a new decision. An image that is the one before,
  // to the last bit, shows nothing: the camera is frozen.
  Decision Observe(const vision::Frame& frame, const control::VehicleState& state) override;

  // The pad is in sight, or was a moment ago.
  bool HasEstimate() const override {
    return estimate_ && estimate_->age_s < parameters_.search.stop_s + latency_s_;
  }
  // The pad in the last frame, before any filter; null: it was not seen, or the fix was not believed.
  const vision::PadObservation* seen() const { return seen_ && fix_ ? &*seen_ : nullptr; }
  // The camera that seen() is of: the frame's own, or the virtual one within it.
  const vision::Pinhole& view() const { return view_; }
  // Now, not at the exposure. Only while HasEstimate().
  const control::TargetEstimator::Estimate& where() const override { return *estimate_; }

  // Not HasEstimate(): the next move of the search. None: given up.
  std::optional<control::Setpoint> Search(const control::VehicleState& state) override;

  void Draw(cv::Mat& bgr) const override;
  std::vector<Caption> Captions(std::string_view phase) const override;

 private:
  control::Setpoint GrowingSquare(const control::VehicleState& state);

  PilotParameters parameters_;
  vision::CameraModel camera_;
  vision::Pinhole view_;                      // the tracker's camera, of the same C
  std::optional<vision::ViewTable> to_view_;  // from a frame; none: the frame is the view
  vision::PadTracker tracker_;
  control::TargetEstimator estimator_;
  std::optional<control::TargetEstimator::Estimate> estimate_;
  std::optional<vision::PadObservation> seen_;
  vision::FrozenImage frozen_;
  std::optional<TargetFix> fix_;
  double latency_s_ = 0;

  std::optional<double> lost_since_s_;                      // of the search
  Eigen::Vector3d last_place_N_ = Eigen::Vector3d::Zero();  // the pad on the autopilot's map, when last seen
  bool placed_ = false;
  int leg_ = -1;
  control::PositionSetpoint waypoint_;
};

}  // namespace kestrel::mission
