// SPDX-License-Identifier: Apache-2.0
#include "mission/ground/ground_pilot.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/stopwatch.h"
#include "geometry/tait_bryan.h"

namespace kestrel::mission {
namespace {

constexpr double kFresh_s = 0.25;           // a fix by which a flight is in sight of its aircraft
constexpr double kOffsetTime_s = 3;         // over which the mast's error is learnt
constexpr double kBoardFresh_s = 0.3;       // a fix from on board that the ground's is held against
constexpr double kClockLimit_s = 0.04;      // offset of the clock that a flight may have
constexpr double kBoardSigma_m = 0.01;      // of a place from on board, and
constexpr double kBoardSigma_per_m = 0.01;  // for each metre of height

control::TargetEstimatorOptions WithoutTilt(control::TargetEstimatorOptions options) {
  options.tilt_alignment = false;  // the place of the aircraft is measured in T already
  return options;
}

// As the estimator takes it, which expects the target in a camera: here the camera is B itself.
Eigen::Matrix<double, 6, 6> AsSeenFromB(const Pose& X_TB, const Eigen::Matrix3d& covariance_T) {
  Eigen::Matrix<double, 6, 6> all = Eigen::Matrix<double, 6, 6>::Zero();
  const Eigen::Matrix3d R_BT = X_TB.R.conjugate().toRotationMatrix();
  all.topLeftCorner<3, 3>() = R_BT * covariance_T * R_BT.transpose();
  return all;
}

}  // namespace

GroundPilot::GroundPilot(const MissionParts& parts, bool hybrid)
    : Pilot(parts.pilot.servo),
      search_(parts.pilot.search),
      estimator_({}, WithoutTilt(parts.pilot.estimator)),
      observer_(parts.ground.value()) {
  if (hybrid) board_.emplace(PilotOf(parts));
}

void GroundPilot::WatchClock(const GroundFix& fix, const std::optional<Pose>& X_TB_board) {
  const auto state = states_.At(fix.t_s);
  if (!state || (board_ && !X_TB_board)) return;
  const Eigen::Quaterniond R_TN = HeadingRotation(YawOf(fix.X_TB.R) - YawOf(state->R_NB));
  clock_.Add(fix.t_s, fix.X_TB.p, X_TB_board ? X_TB_board->p : R_TN * state->p_NB, R_TN * state->v_N);
}

void GroundPilot::TakeGround(const control::VehicleState& state, std::vector<Measured>& all) {
  const auto expected = [this](double t_s) -> std::optional<Pose> {
    const auto X_BT = estimator_.ExpectedPose(t_s);
    if (!X_BT) return std::nullopt;
    Pose X_TB = X_BT->Inverse();
    if (offset_T_) X_TB.p += *offset_T_;  // where this camera sees it
    return X_TB;
  };
  report_.fixes = observer_.Observe(states_, state.t_s, expected);
  const bool by_board = std::abs(state.t_s - board_s_) < kBoardFresh_s;
  std::vector<Measured> measured;
  for (const GroundFix& fix : report_.fixes) {
    std::optional<Pose> X_TB_board;
    if (const auto X_BT = estimator_.ExpectedPose(fix.t_s); X_BT && by_board) X_TB_board = X_BT->Inverse();
    WatchClock(fix, X_TB_board);
    if (X_TB_board) {
      const Eigen::Vector3d off = fix.X_TB.p - X_TB_board->p;
      const double dt = std::max(0.0, fix.t_s - offset_s_);
      offset_T_ = offset_T_ ? *offset_T_ + std::min(1.0, dt / kOffsetTime_s) * (off - *offset_T_) : off;
      offset_s_ = fix.t_s;
    }
    measured.push_back({fix.t_s, fix.X_TB, fix.covariance, true});
    if (offset_T_) measured.back().X_TB.p -= *offset_T_;
  }
  if (const auto clock = clock_.Get()) report_.clock_offset_s = clock->offset_s;
  // An aircraft that then stands still tells nothing of the clock.
  clock_apart_ = clock_.Apart(kClockLimit_s) || (clock_apart_ && !clock_.Together(kClockLimit_s));
  report_.state = clock_apart_ ? "clock apart" : NameOf(observer_.state());
  report_.ground = !measured.empty() && !clock_apart_;
  // The camera on board is the sharper one by far: what both see is measured by it.
  if (!clock_apart_ && !by_board) all.insert(all.end(), measured.begin(), measured.end());
}

bool GroundPilot::Correct(const Measured& measured) {
  Pose X_TB = measured.X_TB;
  double t_s = measured.t_s;
  if (t_s < corrected_s_) {
    // It comes late: carried to the newest fix by the autopilot's own motion.
    const auto then = states_.At(t_s), newest = states_.At(corrected_s_);
    if (!then || !newest) return false;
    const Eigen::Quaterniond R_TN = HeadingRotation(YawOf(X_TB.R) - YawOf(then->R_NB));
    X_TB.p += R_TN * ((then->v_N + newest->v_N) / 2 * (corrected_s_ - t_s));
    X_TB.R = R_TN * newest->R_NB;
    t_s = corrected_s_;
  }
  if (!estimator_.Correct(t_s, X_TB.Inverse(), AsSeenFromB(X_TB, measured.covariance))) return false;
  corrected_s_ = t_s;
  return true;
}

Decision GroundPilot::Observe(const vision::Frame& frame, const control::VehicleState& state) {
  const auto start = std::chrono::steady_clock::now();
  report_ = {};
  Hear(state);
  states_.Add(state);
  estimator_.AddState(state);
  std::vector<Measured> all;
  Decision decision;
  if (board_) {
    decision = board_->Observe(frame, state);
    if (decision.fix) {
      const auto then = states_.At(frame.t_s);
      const Eigen::Quaterniond R_TB = HeadingRotation(decision.fix->yaw_TB - YawOf(then->R_NB)) * then->R_NB;
      const double sigma = kBoardSigma_m + kBoardSigma_per_m * std::abs(decision.fix->p_TB.z());
      all.push_back(
          {frame.t_s, {R_TB, decision.fix->p_TB}, sigma * sigma * Eigen::Matrix3d::Identity(), false});
      board_s_ = frame.t_s;
    }
  }
  TakeGround(state, all);
  std::stable_sort(all.begin(), all.end(),
                   [](const Measured& a, const Measured& b) { return a.t_s < b.t_s; });
  const Measured* by_ground = nullptr;
  for (const Measured& measured : all) {
    if (!Correct(measured)) {
      report_.ground = report_.ground && !measured.by_ground;
      continue;
    }
    if (measured.by_ground)
      by_ground = &measured;
    else
      report_.board = true;
  }
  estimate_ = estimator_.At(state.t_s);
  patience_s_ = search_.stop_s + std::max(0.0, state.t_s - frame.t_s);
  if (!report_.board) decision.fix.reset();
  if (!report_.board && by_ground != nullptr) {
    // As of the frame that this decision is on.
    const Eigen::Vector3d moved = estimate_->v_T * (frame.t_s - by_ground->t_s);
    const GroundFix& last = report_.fixes.back();
    decision.fix = TargetFix{
        by_ground->X_TB.p + moved, YawOf(by_ground->X_TB.R), last.lights, last.residual_px, 1, true};
  }
  fix_ = decision.fix;
  decision.fix_age_s = estimate_ ? estimate_->age_s : state.t_s;
  const bool used = report_.board || report_.ground;
  // Its frames need not come with those that pace the flight.
  const bool fresh = used || (estimate_ && estimate_->age_s < kFresh_s);
  const bool bad_clock = clock_apart_ || observer_.state() == GroundState::kClock;
  if (board_)
    decision.target = report_.board && report_.ground ? "both"
                      : report_.board && bad_clock    ? "board, clock"
                      : report_.board                 ? "board"
                      : report_.ground                ? "ground"
                                                      : report_.state;
  else
    decision.target = report_.state;
  decision.target_state = fresh                                       ? TargetState::kInSight
                          : observer_.state() == GroundState::kFrozen ? TargetState::kBlind
                          : !report_.fixes.empty()                    ? TargetState::kUncertain
                                                                      : TargetState::kLost;
  if (used) {
    lost_since_s_.reset();
    stay_.reset();
  }
  decision.vision_s = SecondsSince(start);
  return decision;
}

std::optional<control::Setpoint> GroundPilot::Search(const control::VehicleState& state) {
  if (board_) return board_->Search(state);
  if (!lost_since_s_) lost_since_s_ = state.t_s;
  if (state.t_s - *lost_since_s_ > search_.give_up_s) return std::nullopt;
  if (!stay_) stay_ = control::PositionSetpoint{state.p_NB, YawOf(state.R_NB)};
  return *stay_;
}

void GroundPilot::Draw(cv::Mat& bgr) const {
  if (board_) board_->Draw(bgr);
}

std::vector<Caption> GroundPilot::Captions(std::string_view phase) const {
  std::vector<Caption> captions;
  if (board_) {
    captions = board_->Captions(phase);
  } else {
    captions = {{std::string(phase)}, {"not flown by this camera"}};
    if (fix_)
      captions.push_back(
          {fmt::format("by the ground: x {:+.2f}  y {:+.2f}  z {:+.2f} m  yaw {:+.1f} deg", fix_->p_TB.x(),
                       fix_->p_TB.y(), fix_->p_TB.z(), Degrees(fix_->yaw_TB))});
  }
  captions.push_back({fmt::format("ground {}", report_.state)});
  return captions;
}

}  // namespace kestrel::mission
