// SPDX-License-Identifier: Apache-2.0
#include "scenarios/landing_deck/landing_deck.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/tait_bryan.h"
#include "mission/touch_down/wind_from_lean.h"
#include "scenarios/landing_deck/deck_records.h"

namespace kestrel::scenarios {
namespace {

using Advice = mission::GoAround::Advice;

constexpr double kStandsFor_s = 0.15;    // without sinking
constexpr double kStandsWithin_m = 0.2;  // of the height at which it would
constexpr double kBlindClimb_s = 4;      // of an aborted flight that has lost the deck
constexpr double kBeside = 0.3;          // of the height: level distance at which it is not above the deck
constexpr double kDescentGain_per_s = 0.8;

class LandingDeckMission final : public mission::Mission {
 public:
  LandingDeckMission(const LandingDeckFlight& flight, const mission::MissionParts& parts)
      : flight_(flight),
        pilot_(parts, flight.pilot),
        wind_(flight.drag_per_s),
        go_around_(flight.limits, flight.go_around) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision = pilot_.Observe(frame, state);
    decision.goal_T = Eigen::Vector3d::Zero();
    decision.goal_yaw_TB = Radians(flight_.yaw_deg);
    wind_.Add(state);
    auto report = std::make_shared<DeckReport>();
    if (state.landed) {
      phase_ = "landed";
      if (!landed_s_) landed_s_ = state.t_s;
      if (state.t_s - *landed_s_ >= flight_.rest_s) decision.outcome = "landed";
    } else if (pilot_.Knows()) {
      decision.setpoint = WithDeck(state, decision, *report);
    } else if (go_around_.aborted()) {
      decision.setpoint = control::VelocitySetpoint{{0, 0, -flight_.go_around.climb_m_s}, 0};
      if (!blind_since_s_) blind_since_s_ = state.t_s;
      if (state.t_s - *blind_since_s_ > kBlindClimb_s) End(decision);
    } else {
      phase_ = "search";
      decision.setpoint = pilot_.Search(state);
      if (!decision.setpoint) decision.outcome = "deck not found";
    }
    report->limits = flight_.limits;
    report->attempt = go_around_.attempt();
    report->wind_m_s = wind_.speed_m_s();
    decision.report = report;
    decision.phase = phase_;
    return decision;
  }
  void Change(const mission::Flight& flight, const mission::PilotParameters& pilot) override {
    if (const auto* changed = flight.As<LandingDeckFlight>()) flight_ = *changed;
    pilot_.ChangeServo(pilot.servo);
  }
  bool Accomplished() const override { return landed_s_.has_value() || ended_; }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kInSight; }
  control::VelocityLag MaxLag() const override { return pilot_.MaxLag(); }
  void Draw(cv::Mat& bgr) const override { pilot_.Draw(bgr); }
  std::vector<mission::Caption> Captions() const override { return pilot_.Captions(phase_); }

 private:
  double Yaw() const { return Radians(flight_.yaw_deg); }
  double Height() const { return -pilot_.p_TB_N().z(); }

  void End(mission::Decision& decision) {
    ended_ = true;
    decision.outcome = mission::kAborted;
  }

  // Of the aircraft as it leans now or soon, against the deck at about the moment of touch-down.
  mission::ExpectedTouch Expected(const control::VehicleState& state, double touch_s,
                                  DeckReport& report) const {
    const double lead_s = flight_.go_around.lead_s;
    const Eigen::Vector3d now_N = state.R_NB * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d soon_N = state.R_NB * ExpRotation(lead_s * state.w_B) * Eigen::Vector3d::UnitZ();
    mission::ExpectedTouch touch;
    for (const double at_s : {0.7 * touch_s, touch_s, touch_s + 0.3}) {
      const control::DeckEstimator::Deck deck = pilot_.DeckIn(at_s);
      for (const Eigen::Vector3d& down_N : {now_N, soon_N})
        touch.tilt = std::max(touch.tilt, std::acos(std::clamp(down_N.dot(deck.normal_N), -1.0, 1.0)));
      // The aircraft meets the deck's velocity of a moment ago.
      const double late = pilot_.DeckIn(std::max(0.0, at_s - lead_s)).v_N.z() - deck.v_N.z();
      touch.sink_m_s = std::max(touch.sink_m_s, flight_.commit_sink_m_s + late);
    }
    // Higher up it sinks faster than it will.
    if (Height() < flight_.last_look_m) touch.sink_m_s = std::max(touch.sink_m_s, pilot_.v_TB_N().z());
    touch.speed_m_s = pilot_.v_TB_N().head<2>().norm();
    touch.wind_m_s = wind_.speed_m_s();
    report.touch = touch;
    return touch;
  }

  control::VelocitySetpoint WithDeck(const control::VehicleState& state, mission::Decision& decision,
                                     DeckReport& report) {
    blind_since_s_.reset();
    report.deck = pilot_.deck();
    const double age_s = pilot_.deck().age_s;
    if (Stands(state)) {
      phase_ = "press";
      return pilot_.Follow(Yaw(), flight_.press_m_s);
    }
    const double touch_s = std::max(0.0, Height() - flight_.stands_m) / flight_.commit_sink_m_s;
    const mission::ExpectedTouch expected = Expected(state, touch_s, report);
    const bool lost = age_s > flight_.coast_s;
    if (lost && go_around_.committed() && Height() > flight_.blind_m) go_around_.BreakOff();
    switch (go_around_.Ask(state.t_s, Height(), flight_.last_look_m, expected)) {
      case Advice::kWait:
        phase_ = "wait";
        return pilot_.Follow(Yaw(), pilot_.ToHeight(flight_.go_around.decision_m));
      case Advice::kGoAround:
        phase_ = "go around";
        return pilot_.Follow(Yaw(), -flight_.go_around.climb_m_s);
      case Advice::kAbort:
        phase_ = "abort";
        if (!go_around_.climbing()) End(decision);
        return pilot_.Follow(Yaw(), -flight_.go_around.climb_m_s);
      case Advice::kApproach:
        break;
    }
    if (go_around_.committed()) {
      phase_ = "touch down";
      return pilot_.Follow(Yaw(), flight_.commit_sink_m_s);
    }
    return Approach(lost);
  }

  control::VelocitySetpoint Approach(bool lost) {
    const double off = pilot_.p_TB_N().head<2>().norm();
    const double speed = pilot_.v_TB_N().head<2>().norm();
    if (lost) {
      phase_ = "chase";
      return pilot_.Follow(Yaw(), std::min(0.0, pilot_.ToHeight(flight_.follow_m)));
    }
    if (off > flight_.centred_m + 0.1 * Height() || speed > flight_.matched_m_s) {
      phase_ = "follow";
      // Not lower than it is until it is above the deck: it would see less.
      const bool beside = off > kBeside * Height() + flight_.centred_m;
      const double height =
          beside ? std::max(Height(), flight_.follow_m) : std::min(Height(), flight_.follow_m);
      return pilot_.Follow(Yaw(), pilot_.ToHeight(height));
    }
    phase_ = "descend";
    const double above = Height() - flight_.go_around.decision_m;
    return pilot_.Follow(Yaw(), std::clamp(kDescentGain_per_s * above + flight_.commit_sink_m_s / 2,
                                           flight_.commit_sink_m_s / 2, flight_.descent_m_s));
  }

  // Where it should sink and does not, about where it would stand.
  bool Stands(const control::VehicleState& state) {
    const bool near = go_around_.committed() && Height() < flight_.stands_m + kStandsWithin_m;
    const bool sinks = pilot_.v_TB_N().z() > flight_.commit_sink_m_s / 2;
    if (!near || (sinks && !stands_)) {
      stands_ = false;
      still_since_s_ = state.t_s;
    }
    if (state.t_s - still_since_s_ >= kStandsFor_s) stands_ = true;
    return stands_;
  }

  LandingDeckFlight flight_;
  DeckPilot pilot_;
  mission::WindFromLean wind_;
  mission::GoAround go_around_;
  std::string_view phase_ = "search";
  std::optional<double> landed_s_, blind_since_s_;
  double still_since_s_ = 0;
  bool stands_ = false, ended_ = false;
};

}  // namespace

void CheckFlight(const LandingDeckFlight& flight, const Place& where, Mistakes& mistakes) {
  mission::CheckGoAround(flight.go_around, flight.last_look_m, "flight.last_look_m", where, mistakes);
  if (flight.follow_m < flight.go_around.decision_m)
    mistakes.Add(where, "flight.follow_m",
                 fmt::format("{:g} is below flight.go_around.decision_m = {:g}", flight.follow_m,
                             flight.go_around.decision_m),
                 "valid: no less than that");
  if (flight.commit_sink_m_s > flight.go_around.share * flight.limits.sink_m_s)
    mistakes.Add(
        where, "flight.commit_sink_m_s",
        fmt::format("{:g} is above the share {:g} of flight.limits.sink_m_s = {:g}, so that every approach "
                    "would be broken off",
                    flight.commit_sink_m_s, flight.go_around.share, flight.limits.sink_m_s),
        fmt::format("valid: up to {:g}", flight.go_around.share * flight.limits.sink_m_s));
}

void CheckFlightPad(const LandingDeckFlight& flight, double seen_from_m, const Place& where,
                    Mistakes& mistakes) {
  if (seen_from_m <= flight.blind_m) return;
  mistakes.Add(
      where, "flight.blind_m",
      fmt::format("{:g}, but the pad is lost to the camera below {:.2g} m: it would go around there",
                  flight.blind_m, seen_from_m),
      fmt::format("valid: from {:.2g} on, a pad with smaller marks in its middle such as nested, or a "
                  "camera that sees more",
                  seen_from_m + 0.005));
}

mission::MissionType TypeOf(const LandingDeckFlight&) {
  return {.name = "landing_deck",
          .summary =
              "Comes up with a deck that moves, follows it and lands on it, within its limits or not at all.",
          .looks_for_pad = true,
          .begins_in_the_air = true,
          .telemetry = DeckColumns(),
          .metrics = DeckMetrics(),
          .add_metrics = AddDeckMetrics,
          .common_metrics = {"fix_*", "longest_loss_s", "settle_s", "touchdown_*", "rest_*"},
          .changeable = {"flight.yaw_deg", "flight.follow_m", "flight.centred_m", "flight.matched_m_s",
                         "flight.descent_m_s", "flight.commit_sink_m_s", "flight.coast_s", "pilot.servo.*"}};
}

std::unique_ptr<mission::Mission> MakeMission(const LandingDeckFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<LandingDeckMission>(flight, parts);
}

}  // namespace kestrel::scenarios
