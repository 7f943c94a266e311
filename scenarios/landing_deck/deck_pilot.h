// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "control/estimate/deck/deck_estimator.h"
#include "mission/helipad_pilot.h"
#include "mission/mission_type.h"
#include "vision/camera/views.h"
#include "vision/capture/frozen_image.h"
#include "vision/landmark/pad_tracker.h"

namespace kestrel::scenarios {

// What the pilot may do with the deck's motion.
struct DeckPilotParameters {
  control::DeckEstimatorOptions deck;
  double lead_s = 0.25;
  double chase_s = 8, chase_sigma_m = 6;
};

inline void Fields(FieldVisitor& v, DeckPilotParameters& p) {
  v({"deck", "Kalman filters of the deck's place, heave, tilt and heading"}, p.deck);
  v({"lead_s",
     "time by which the aircraft follows velocities late, for which those of the deck are predicted"},
    p.lead_s, 0.0, 2.0);
  v({"chase_s", "time for which a deck out of sight is flown after by its predicted place"}, p.chase_s, 0.0,
    60.0);
  v({"chase_sigma_m", "standard deviation of that place up to which it is"}, p.chase_sigma_m, 0.1, 100.0);
}

// Sees the pad, knows where the deck under it is and will be, flies in its moving frame, and looks for it.
class DeckPilot {
 public:
  // parts: with a pad, and a camera that has a TrackersCamera.
  DeckPilot(const mission::MissionParts& parts, const DeckPilotParameters& parameters);

  // Looks at a frame: fills the target, fix and vision_s of a new decision.
  mission::Decision Observe(const vision::Frame& frame, const control::VehicleState& state);

  // Where the deck is believed to be well enough to fly by, in sight or not.
  bool Knows() const { return deck_.has_value(); }
  // Now. Only while Knows().
  const control::DeckEstimator::Deck& deck() const { return *deck_; }
  control::DeckEstimator::Deck DeckIn(double ahead_s) const { return *estimator_.At(t_s_ + ahead_s); }
  // The aircraft from the pad's centre, level, with the axes of N, and its velocity by the deck's.
  const Eigen::Vector3d& p_TB_N() const { return p_TB_N_; }
  const Eigen::Vector3d& v_TB_N() const { return v_TB_N_; }

  // With the deck, and to a place over the pad's centre, at a velocity up and down by the deck's own.
  control::VelocitySetpoint Follow(double yaw_T, double down_m_s) const;
  // The vertical velocity that brings it to a height over the pad.
  double ToHeight(double height_m) const;
  // It holds its place, then climbs above where it began, and waits there. None: given up.
  std::optional<control::Setpoint> Search(const control::VehicleState& state);

  void ChangeServo(const control::ServoGains& servo) { parameters_.servo = servo; }
  control::VelocityLag MaxLag() const;
  void Draw(cv::Mat& bgr) const;
  std::vector<mission::Caption> Captions(std::string_view phase) const;

 private:
  mission::PilotParameters parameters_;
  DeckPilotParameters deck_parameters_;
  vision::CameraModel camera_;
  vision::Pinhole view_;                      // the tracker's camera, of the same C
  std::optional<vision::ViewTable> to_view_;  // from a frame; none: the frame is the view
  vision::PadTracker tracker_;
  control::DeckEstimator estimator_;
  vision::FrozenImage frozen_;
  std::optional<control::DeckEstimator::Deck> deck_;
  std::optional<vision::PadObservation> seen_;
  std::optional<mission::TargetFix> fix_;
  Eigen::Vector3d p_TB_N_ = Eigen::Vector3d::Zero(), v_TB_N_ = Eigen::Vector3d::Zero();
  double t_s_ = 0, yaw_ = 0;  // of the aircraft
  std::optional<double> lost_since_s_;
  control::PositionSetpoint waits_;
};

}  // namespace kestrel::scenarios
