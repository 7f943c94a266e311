// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "control/estimate/state_history.h"
#include "control/estimate/target_estimator.h"
#include "mission/ground/clock_offset.h"
#include "mission/ground/ground_observer.h"
#include "mission/helipad_pilot.h"
#include "mission/mission_type.h"
#include "mission/pilot.h"

namespace kestrel::mission {

// What the camera on the ground had to say of a frame.
struct GroundReport {
  std::string_view state;              // NameOf(GroundState), or "clock apart"
  std::vector<GroundFix> fixes = {};   // of the frames that came with this one
  bool board = false, ground = false;  // which cameras measured the place
  std::optional<double> clock_offset_s = {};
};

// A pilot by a camera on the ground: eye-to-hand, thesis 5.2.1. It knows where the pad is by where the mast stands
// beside it, and never sees it. Hybrid, it looks at the pad too, as HelipadPilot does: one filter takes the fixes of
// the camera on board while there are any, and those from the ground else, in the order of their exposures; while
// both see, it learns by how much the mast is off, and takes that from the ground's fixes.
class GroundPilot final : public Pilot {
 public:
  // parts.ground must be there. hybrid: also by the camera on board, for which parts are what HelipadPilot needs.
  GroundPilot(const MissionParts& parts, bool hybrid);

  Decision Observe(const vision::Frame& frame, const control::VehicleState& state) override;
  bool HasEstimate() const override { return estimate_ && estimate_->age_s < patience_s_; }
  const control::TargetEstimator::Estimate& where() const override { return *estimate_; }
  // Stays where it last knew its place, by the autopilot's own navigation, while the head of the mast looks for
  // it; hybrid, it searches for the pad.
  std::optional<control::Setpoint> Search(const control::VehicleState& state) override;
  void Draw(cv::Mat& bgr) const override;
  std::vector<Caption> Captions(std::string_view phase) const override;
  cv::Mat ProductImage() const override { return observer_.Drawn(); }

  const GroundReport& report() const { return report_; }  // of the last frame

 private:
  // A place of the aircraft that a camera measured.
  struct Measured {
    double t_s = 0;
    Pose X_TB;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    bool by_ground = false;
  };
  void TakeGround(const control::VehicleState& state, std::vector<Measured>& all);
  // X_TB_board: where the camera on board has the aircraft at that stamp; none: it does not see.
  void WatchClock(const GroundFix& fix, const std::optional<Pose>& X_TB_board);
  bool Correct(const Measured& measured);

  SearchParameters search_;
  control::TargetEstimator estimator_;  // of fixes in T, as of a camera in B
  control::StateHistory states_;
  GroundObserver observer_;
  std::optional<HelipadPilot> board_;  // hybrid
  ClockOffset clock_;
  bool clock_apart_ = false;
  std::optional<control::TargetEstimator::Estimate> estimate_;
  double corrected_s_ = -1e9;  // exposure of the newest fix in the filter
  double patience_s_ = 0;
  double board_s_ = -1e9;                    // of the newest fix from on board
  std::optional<Eigen::Vector3d> offset_T_;  // the ground's fixes less those from on board
  double offset_s_ = 0;
  std::optional<TargetFix> fix_;
  GroundReport report_;
  std::optional<double> lost_since_s_;
  std::optional<control::PositionSetpoint> stay_;
};

}  // namespace kestrel::mission
