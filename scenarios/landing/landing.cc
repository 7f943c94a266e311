// SPDX-License-Identifier: Apache-2.0
#include "scenarios/landing/landing.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "geometry/tait_bryan.h"
#include "mission/touch_down/touch_down_records.h"
#include "mission/touch_down/wind_from_lean.h"
#include "scenarios/landing/descent_plot.h"
#include "scenarios/landing/descent_report.h"

namespace kestrel::scenarios {
namespace {

constexpr double kRest_s = 1;        // after the motors have stopped, until the aircraft stands still
constexpr double kBlindClimb_s = 4;  // of an aborted flight that has lost the pad

using Advice = mission::GoAround::Advice;

class LandingMission final : public mission::Mission {
 public:
  LandingMission(const LandingFlight& flight, std::unique_ptr<mission::Pilot> pilot)
      : flight_(flight),
        own_pilot_(std::move(pilot)),
        pilot_(*own_pilot_),
        wind_(flight.drag_per_s),
        go_around_(flight.limits, flight.go_around) {
    if (flight.height_law == "fuzzy")
      fuzzy_ = std::make_shared<FuzzyDescentLaw>(
          FuzzyDescentLaw{flight.fuzzy, control::MakeInference(flight.fuzzy.controller)});
  }

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision = pilot_.Observe(frame, state);
    decision.goal_T = Eigen::Vector3d::Zero();
    decision.goal_yaw_TB = Radians(flight_.yaw_deg);
    wind_.Add(state);
    if (state.landed) {
      phase_ = "landed";
      if (!landed_s_) landed_s_ = state.t_s;
      if (state.t_s - *landed_s_ >= kRest_s) decision.outcome = "landed";
    } else if (committed_ && !pilot_.HasEstimate() && decision.fix_age_s < BlindTime_s()) {
      // Too low to see: on with the last course, level and straight down.
      decision.setpoint = control::VelocitySetpoint{{0, 0, flight_.commit_sink_m_s}, 0};
    } else if (!pilot_.HasEstimate() && go_around_.aborted()) {
      decision.setpoint = control::VelocitySetpoint{{0, 0, -flight_.go_around.climb_m_s}, 0};
      if (decision.fix_age_s > kBlindClimb_s) End(decision);
    } else if (!pilot_.HasEstimate()) {
      committed_ = false;
      phase_ = "search";
      decision.setpoint = pilot_.Search(state);
      if (!decision.setpoint) decision.outcome = "pad not found";
    } else {
      decision.setpoint = Approach(state, decision);
    }
    decision.report = Report();
    decision.phase = phase_;
    return decision;
  }
  void Change(const mission::Flight& flight, const mission::PilotParameters& pilot) override {
    if (const auto* changed = flight.As<LandingFlight>()) flight_ = *changed;
    pilot_.ChangeServo(pilot.servo);
  }
  bool Accomplished() const override { return landed_s_.has_value() || ended_; }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kInSight; }
  control::VelocityLag MaxLag() const override { return pilot_.MaxLag(); }
  void Draw(cv::Mat& bgr) const override { pilot_.Draw(bgr); }
  std::vector<mission::Caption> Captions() const override { return pilot_.Captions(phase_); }
  cv::Mat ProductImage() const override { return pilot_.ProductImage(); }

 private:
  // The ground must come within this, or something else has.
  double BlindTime_s() const { return 2 * flight_.blind_m / flight_.commit_sink_m_s + 1; }

  void End(mission::Decision& decision) {
    ended_ = true;
    decision.outcome = mission::kAborted;
  }

  // Over a level pad.
  mission::ExpectedTouch Expected(const control::VehicleState& state) const {
    const Eigen::Vector3d& v_T = pilot_.where().v_T;
    // What does not sink though it should may stand on the pad, and rocks as it settles there.
    const bool sinks = v_T.z() > flight_.commit_sink_m_s / 2;
    const auto tilt_in = [&](double lead_s) {
      return std::acos(
          std::clamp((state.R_NB * ExpRotation(lead_s * state.w_B)).toRotationMatrix()(2, 2), -1.0, 1.0));
    };
    const double lead_s = sinks ? flight_.go_around.lead_s : 0;
    return {std::max(tilt_in(0), tilt_in(lead_s)), ExpectedSink(-pilot_.where().p_TB.z(), v_T.z()),
            v_T.head<2>().norm(), wind_.speed_m_s()};
  }

  // At the touch. From commit_m to blind_m it still slows down from its descent, within a second or so: each metre
  // takes away a metre per second.
  double ExpectedSink(double height_m, double sink_m_s) const {
    constexpr double kSlowsWithin_s = 1;
    if (height_m > flight_.commit_m) return flight_.commit_sink_m_s;
    const double slowed_m_s = sink_m_s - std::max(0.0, height_m - flight_.blind_m) / kSlowsWithin_s;
    return std::max(slowed_m_s, std::min(sink_m_s, flight_.commit_sink_m_s));
  }

  control::VelocitySetpoint Approach(const control::VehicleState& state, mission::Decision& decision) {
    const Eigen::Vector3d& p_TB = pilot_.where().p_TB;
    const double height = -p_TB.z();
    switch (go_around_.Ask(state.t_s, height, flight_.commit_m, Expected(state))) {
      case Advice::kWait:
        phase_ = "wait";
        committed_ = false;
        return pilot_.GoTo({0, 0, -flight_.go_around.decision_m}, Radians(flight_.yaw_deg));
      case Advice::kGoAround:
        phase_ = "go around";
        return Climb();
      case Advice::kAbort:
        phase_ = "abort";
        if (!go_around_.climbing()) End(decision);
        return Climb();
      case Advice::kApproach:
        return Descend();
    }
    return {};
  }

  control::VelocitySetpoint Climb() {
    committed_ = false;
    return pilot_.DescendTo({0, 0}, Radians(flight_.yaw_deg), -flight_.go_around.climb_m_s);
  }

  control::VelocitySetpoint Descend() {
    const Eigen::Vector3d& p_TB = pilot_.where().p_TB;
    const double off = p_TB.head<2>().norm();
    const double yaw = Radians(flight_.yaw_deg);
    committed_ = -p_TB.z() < flight_.blind_m;
    const double height = -pilot_.Ahead_T().z();  // at which it will do what it is told now
    if (height < flight_.commit_m) {
      phase_ = "touch down";
      return pilot_.DescendTo({0, 0}, yaw, flight_.commit_sink_m_s);
    }
    if (off > flight_.centred_m + 0.1 * height) {
      phase_ = "centre";
      return pilot_.DescendTo({0, 0}, yaw, 0);
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
    if (descent) descent_ = std::make_shared<DescentReport>(fuzzy_, height, sinking, *descent);
    return descent;
  }

  std::shared_ptr<const mission::MissionReport> Report() {
    const std::shared_ptr<DescentReport> descent = std::exchange(descent_, nullptr);
    const std::shared_ptr<mission::TouchDownReport> report =
        descent ? descent : std::make_shared<mission::TouchDownReport>();
    report->limits = flight_.limits;
    report->attempt = go_around_.attempt();
    report->wind_m_s = wind_.speed_m_s();
    return report;
  }

  LandingFlight flight_;
  std::unique_ptr<mission::Pilot> own_pilot_;
  mission::Pilot& pilot_;
  std::string_view phase_ = "search";
  std::optional<double> landed_s_;
  std::shared_ptr<const FuzzyDescentLaw> fuzzy_;  // null: the law is linear
  std::shared_ptr<DescentReport> descent_;        // of this frame
  mission::WindFromLean wind_;
  mission::GoAround go_around_;
  bool committed_ = false;  // so low that the camera need no longer see the pad
  bool ended_ = false;      // aborted
};

}  // namespace

void CheckFlight(const LandingFlight& flight, const Place& where, Mistakes& mistakes) {
  if (flight.commit_sink_m_s > flight.descent_m_s)
    mistakes.Add(
        where, "flight.commit_sink_m_s",
        fmt::format("{:g} is above flight.descent_m_s = {:g}", flight.commit_sink_m_s, flight.descent_m_s),
        "valid: no more than that");
  mission::CheckGoAround(flight.go_around, flight.commit_m, "flight.commit_m", where, mistakes);
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
          .telemetry = mission::TouchDownColumns(),
          .metrics = mission::TouchDownMetrics(),
          .add_metrics = mission::AddTouchDownMetrics,
          .common_metrics = {"fix_*", "longest_loss_s", "settle_s", "touchdown_*", "rest_*"},
          .plots = {{"fuzzy.png", DescendsByRules, DescentPlot}},
          .changeable = {"flight.yaw_deg", "flight.descent_m_s", "flight.commit_*", "flight.blind_m",
                         "flight.centred_m", "pilot.servo.*"}};
}

std::unique_ptr<mission::Mission> MakeLanding(const LandingFlight& flight,
                                              std::unique_ptr<mission::Pilot> pilot) {
  return std::make_unique<LandingMission>(flight, std::move(pilot));
}

std::unique_ptr<mission::Mission> MakeMission(const LandingFlight& flight,
                                              const mission::MissionParts& parts) {
  return MakeLanding(flight, std::make_unique<mission::HelipadPilot>(mission::PilotOf(parts)));
}

}  // namespace kestrel::scenarios
