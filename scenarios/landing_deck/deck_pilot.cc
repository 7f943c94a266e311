// SPDX-License-Identifier: Apache-2.0
#include "scenarios/landing_deck/deck_pilot.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <opencv2/imgproc.hpp>

#include "base/stopwatch.h"
#include "geometry/limited.h"
#include "geometry/tait_bryan.h"
#include "vision/drawn_colours.h"
#include "vision/landmark/pad_drawing.h"

namespace kestrel::scenarios {

DeckPilot::DeckPilot(const mission::MissionParts& parts, const DeckPilotParameters& parameters)
    : parameters_(parts.pilot),
      deck_parameters_(parameters),
      camera_(parts.camera),
      view_(mission::TrackersCamera(parts.camera).value()),
      tracker_(parts.pad, view_, parts.pilot.tracker),
      estimator_(parts.X_BC, parameters.deck) {
  if (!std::holds_alternative<vision::Pinhole>(camera_))
    to_view_ = vision::MakeViewTable(vision::PerspectiveView{view_}, camera_);
}

mission::Decision DeckPilot::Observe(const vision::Frame& frame, const control::VehicleState& state) {
  const auto start = std::chrono::steady_clock::now();
  mission::Decision decision;
  cv::Mat grey = frame.image;
  if (grey.channels() == 3) cv::cvtColor(frame.image, grey, cv::COLOR_BGR2GRAY);
  if (to_view_) grey = vision::Look(*to_view_, grey);
  estimator_.AddState(state);
  t_s_ = state.t_s;
  yaw_ = YawOf(state.R_NB);
  const bool frozen = frozen_.Is(grey);
  seen_ = frozen ? std::nullopt : tracker_.Track(grey, estimator_.ExpectedPose(frame.t_s));
  fix_.reset();
  if (seen_)
    if (const auto X_TB = estimator_.Correct(frame.t_s, seen_->X_CT, seen_->covariance))
      fix_ = mission::FixBy(*seen_, *X_TB);
  deck_ = estimator_.At(t_s_);
  const bool too_long = deck_ && deck_->age_s > deck_parameters_.chase_s;
  if (deck_ && (too_long || deck_->sigma_m > deck_parameters_.chase_sigma_m)) {
    estimator_.Forget();
    deck_.reset();
  }
  if (deck_) {
    lost_since_s_.reset();
    const control::VehicleState in_O = *estimator_.Aircraft(t_s_);
    p_TB_N_ = in_O.p_NB - deck_->p_OT;
    v_TB_N_ = state.v_N - deck_->v_N;
  }
  decision.fix = fix_;
  decision.fix_age_s = deck_ ? deck_->age_s : state.t_s;
  mission::TellPad(frozen, seen_, fix_, decision);
  decision.vision_s = SecondsSince(start);
  return decision;
}

control::VelocitySetpoint DeckPilot::Follow(double yaw_T, double down_m_s) const {
  const control::ServoGains& gains = parameters_.servo;
  const control::DeckEstimator::Deck ahead = DeckIn(deck_parameters_.lead_s);
  Eigen::Vector3d v_N = ahead.v_N;
  v_N.head<2>() += Limited(Eigen::Vector2d(-gains.lambda_per_s * p_TB_N_.head<2>()), gains.speed_limit_m_s);
  v_N.z() += down_m_s;
  const double limit = Radians(gains.yaw_rate_limit_deg_s);
  const double turn = deck_->yaw_rate + gains.lambda_yaw_per_s * WrapAngle(deck_->yaw + yaw_T - yaw_);
  return {HeadingRotation(-yaw_) * v_N, std::clamp(turn, -limit, limit)};
}

double DeckPilot::ToHeight(double height_m) const {
  const control::ServoGains& gains = parameters_.servo;
  return std::clamp(gains.lambda_vertical_per_s * (-p_TB_N_.z() - height_m), -gains.climb_limit_m_s,
                    gains.climb_limit_m_s);
}

std::optional<control::Setpoint> DeckPilot::Search(const control::VehicleState& state) {
  const mission::SearchParameters& search = parameters_.search;
  if (!lost_since_s_) {
    lost_since_s_ = state.t_s;
    waits_ = {state.p_NB, YawOf(state.R_NB)};
  }
  const double lost_s = state.t_s - *lost_since_s_;
  if (lost_s > search.give_up_s) return std::nullopt;
  if (lost_s > search.stop_s && -waits_.p_N.z() < search.ceiling_m) {
    if (-state.p_NB.z() < search.ceiling_m) return control::VelocitySetpoint{{0, 0, -search.climb_m_s}, 0};
    waits_.p_N = state.p_NB;
  }
  return waits_;
}

control::VelocityLag DeckPilot::MaxLag() const {
  return {control::MaxLag(parameters_.servo.lambda_per_s),
          control::MaxLag(parameters_.servo.lambda_vertical_per_s)};
}

void DeckPilot::Draw(cv::Mat& bgr) const {
  vision::DrawPoints(bgr, camera_, view_, tracker_.tracked_points(), 2, vision::kPointColour);
  if (!seen_) return;
  vision::DrawPoints(bgr, camera_, view_, tracker_.inlier_points(), 3, vision::kFixColour);
  vision::DrawOutlineAndAxes(bgr, camera_, seen_->X_CT, tracker_.reference().Outline());
}

std::vector<mission::Caption> DeckPilot::Captions(std::string_view phase) const {
  std::vector<mission::Caption> captions = {{std::string(phase)}};
  if (!fix_) captions.push_back({"pad lost", true});
  if (!deck_) return captions;
  captions.push_back({fmt::format("off {:.2f} m  height {:.2f} m", p_TB_N_.head<2>().norm(), -p_TB_N_.z())});
  captions.push_back(
      {fmt::format("deck {:.1f} m/s, heave {:+.2f} m/s", deck_->v_N.head<2>().norm(), -deck_->v_N.z())});
  if (!fix_) captions.push_back({fmt::format("last seen {:.1f} s ago", deck_->age_s)});
  return captions;
}

}  // namespace kestrel::scenarios
