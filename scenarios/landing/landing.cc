// SPDX-License-Identifier: Apache-2.0
#include "scenarios/landing/landing.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "geometry/tait_bryan.h"
#include "scenarios/landing/descent_plot.h"
#include "scenarios/landing/descent_report.h"

namespace kestrel::scenarios {
namespace {

constexpr double kRest_s = 1;  // after the motors have stopped, until the aircraft stands still

class LandingMission final : public mission::Mission {
 public:
  LandingMission(const LandingFlight& flight, mission::HelipadPilot pilot)
      : flight_(flight), pilot_(std::move(pilot)) {
    if (flight.height_law == "fuzzy")
      fuzzy_ = std::make_shared<FuzzyDescentLaw>(
          FuzzyDescentLaw{flight.fuzzy, control::MakeInference(flight.fuzzy.controller)});
  }

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision = pilot_.Observe(frame, state);
    decision.goal_T = Eigen::Vector3d::Zero();
    decision.goal_yaw_TB = Radians(flight_.yaw_deg);
    if (state.landed) {
      phase_ = "landed";
      if (!landed_s_) landed_s_ = state.t_s;
      if (state.t_s - *landed_s_ >= kRest_s) decision.outcome = "landed";
    } else if (committed_ && !pilot_.HasEstimate() && decision.fix_age_s < BlindTime_s()) {
      // Too low to see: on with the last course, level and straight down.
      decision.setpoint = control::VelocitySetpoint{{0, 0, flight_.commit_sink_m_s}, 0};
    } else if (!pilot_.HasEstimate()) {
      committed_ = false;
      phase_ = "search";
      decision.setpoint = pilot_.Search(state);
      if (!decision.setpoint) decision.outcome = "pad not found";
    } else {
      decision.setpoint = Descend();
      decision.report = std::exchange(report_, nullptr);
    }
    decision.phase = phase_;
    return decision;
  }
  bool Accomplished() const override { return landed_s_.has_value(); }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kInSight; }
  control::VelocityLag MaxLag() const override { return pilot_.MaxLag(); }
  void Draw(cv::Mat& bgr) const override { pilot_.Draw(bgr, phase_); }

 private:
  // The ground must come within this, or something else has.
  double BlindTime_s() const { return 2 * flight_.blind_m / flight_.commit_sink_m_s + 1; }

  control::VelocitySetpoint Descend() {
    const Eigen::Vector3d& p_TB = pilot_.where().p_TB;
    const double height = -p_TB.z(), off = p_TB.head<2>().norm();
    const double yaw = Radians(flight_.yaw_deg);
    committed_ = height < flight_.blind_m;
    if (height < flight_.commit_m) {
      phase_ = "touch down";
      return pilot_.DescendTo({0, 0}, yaw, flight_.commit_sink_m_s);
    }
    if (off > flight_.centred_m + 0.1 * height) {
      phase_ = "centre";
      return pilot_.GoTo({0, 0, p_TB.z()}, yaw);
    }
    phase_ = "descend";
    const std::optional<double> wanted = fuzzy_ ? Fuzzy(height) : Linear(height);
    if (!wanted) {
      phase_ = "no rule";
      return pilot_.DescendTo({0, 0}, yaw, 0);
    }
    return pilot_.DescendTo({0, 0}, yaw, std::clamp(*wanted, flight_.commit_sink_m_s, flight_.descent_m_s));
  }

  // Slower towards the height of commitment, where the constant speed takes over.
  double Linear(double height) const { return 0.7 * (height - flight_.commit_m) + flight_.commit_sink_m_s; }

  std::optional<double> Fuzzy(double height) {
    const double sinking = pilot_.where().v_T.z();
    const auto descent = control::FuzzyDescent(fuzzy_->height, fuzzy_->inference, height, sinking);
    if (descent) report_ = std::make_shared<DescentReport>(fuzzy_, height, sinking, *descent);
    return descent;
  }

  LandingFlight flight_;
  mission::HelipadPilot pilot_;
  std::string_view phase_ = "search";
  std::optional<double> landed_s_;
  std::shared_ptr<const FuzzyDescentLaw> fuzzy_;  // null: the law is linear
  std::shared_ptr<const DescentReport> report_;   // of this frame
  bool committed_ = false;                        // so low that the camera need no longer see the pad
};

}  // namespace

void CheckFlight(const LandingFlight& flight, const Place& where, Mistakes& mistakes) {
  if (flight.commit_sink_m_s > flight.descent_m_s)
    mistakes.Add(
        where, "flight.commit_sink_m_s",
        fmt::format("{:g} is above flight.descent_m_s = {:g}", flight.commit_sink_m_s, flight.descent_m_s),
        "valid: no more than that");
  control::CheckHeight(flight.fuzzy, "flight.fuzzy", where, mistakes);
}

void CheckFlightPad(const LandingFlight& flight, double seen_from_m, const Place& where, Mistakes& mistakes) {
  constexpr double kStillKnown_m = 0.1;  // it sinks so far until the estimate counts as lost
  if (seen_from_m > flight.blind_m + kStillKnown_m)
    mistakes.Add(
        where, "flight.blind_m",
        fmt::format("{:g}, but the pad is lost to the camera below {:.2g} m: it would stop there and climb",
                    flight.blind_m, seen_from_m),
        fmt::format("valid: from {:.2g} on, a pad with smaller marks in its middle such as nested, or a "
                    "camera that sees more",
                    seen_from_m - kStillKnown_m + 0.005));
}

mission::MissionType TypeOf(const LandingFlight&) {
  return {.name = "landing",
          .summary = "Centres over the pad, descends and lands on it; it lands on no other place.",
          .looks_for_pad = true,
          .begins_in_the_air = true,
          .common_metrics = {"fix_*", "longest_loss_s", "settle_s", "touchdown_*", "rest_*"},
          .plots = {{"fuzzy.png", DescendsByRules, DescentPlot}}};
}

std::unique_ptr<mission::Mission> MakeMission(const LandingFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<LandingMission>(flight, mission::PilotOf(parts));
}

}  // namespace kestrel::scenarios
