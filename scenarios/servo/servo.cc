// SPDX-License-Identifier: Apache-2.0
#include "scenarios/servo/servo.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/file/model_files.h"
#include "control/estimate/velocity_lag.h"
#include "geometry/tait_bryan.h"
#include "mission/servo/servo_sight.h"
#include "scenarios/servo/servo_metrics.h"
#include "scenarios/servo/servo_plot.h"

namespace kestrel::scenarios {
namespace {

using Eigen::Vector3d;

constexpr double kIntegralBelow_m_s = 0.3;  // a larger velocity of the law is on its way, not an error
constexpr double kIntegralLimit_m_s = 0.5;
constexpr double kArrived = 0.03;  // error of the corners, a ratio to the focal length

class ServoMission final : public mission::Mission {
 public:
  ServoMission(const ServoFlight& flight, const mission::MissionParts& parts)
      : flight_(flight),
        X_BC_(parts.X_BC),
        pilot_(mission::PilotOf(parts)),
        sight_(parts, {flight.height_m, Radians(flight.yaw_deg), Radians(flight.pad_tilt_deg),
                       flight.level_camera}) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision = pilot_.Observe(frame, state);
    sight_.AddState(state);
    report_.reset();
    decision.goal_T = sight_.goal_T();
    decision.goal_yaw_TB = sight_.goal_yaw_TB();
    if (state.landed) {
      phase_ = "take off";
      decision.setpoint =
          control::PositionSetpoint{{state.p_NB.x(), state.p_NB.y(), -flight_.height_m}, YawOf(state.R_NB)};
      seen_s_ = state.t_s;
    } else if (const auto* seen = pilot_.seen()) {
      phase_ = "servo";
      seen_s_ = state.t_s;
      const mission::ServoView& view = flight_.law == "points_adaptive"
                                           ? sight_.LookForDepth(*seen, pilot_.view(), frame.t_s, state)
                                           : sight_.Look(*seen, pilot_.view(), frame.t_s, state);
      const mission::ServoAnswer answer = mission::AnswerOf(flight_.law, view, flight_.gains.lambda_per_s);
      report_ = sight_.ReportOf(answer, pilot_.view());
      arrived_ = arrived_ || report_->error_px < kArrived * pilot_.view().fx;
      decision.setpoint = Setpoint(answer.twist, state);
      if (sight_.height_m() > flight_.ceiling_m) decision.outcome = "retreated";
      if (sight_.height_m() < flight_.floor_m) decision.outcome = "too low";
    } else {
      phase_ = "wait";
      decision.setpoint = Setpoint({}, state);
      if (!seen_s_) seen_s_ = state.t_s;
      if (state.t_s - *seen_s_ > flight_.give_up_s) decision.outcome = "pad lost";
    }
    decision.report = report_;
    decision.phase = phase_;
    return decision;
  }

  bool Accomplished() const override { return arrived_; }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kInSight; }
  control::VelocityLag MaxLag() const override {
    const double lag_s = control::MaxLag(flight_.gains.lambda_per_s);
    return {lag_s, lag_s};
  }

  void Draw(cv::Mat& bgr) const override {
    pilot_.Draw(bgr);
    if (report_) sight_.Draw(bgr);
  }
  std::vector<mission::Caption> Captions() const override {
    std::vector<mission::Caption> captions = pilot_.Captions(phase_);
    if (report_) captions.push_back({fmt::format("{}: error {:.1f} px", flight_.law, report_->error_px)});
    return captions;
  }

 private:
  // The law moves the camera's centre; the aircraft's own velocity is that less the camera's lever in a turn.
  control::Setpoint Setpoint(const control::LevelTwist& twist, const control::VehicleState& state) {
    const ServoFlightGains& g = flight_.gains;
    const Eigen::Quaterniond R_NH = HeadingRotation(YawOf(state.R_NB));
    Vector3d v_H = X_BC_.R * twist.v - (twist.yaw_rate * Vector3d::UnitZ()).cross(X_BC_.p);
    const double share =
        std::max({1.0, v_H.head<2>().norm() / g.speed_limit_m_s, std::abs(v_H.z()) / g.climb_limit_m_s,
                  std::abs(twist.yaw_rate) / Radians(g.yaw_rate_limit_deg_s)});
    v_H /= share;
    const double dt_s = last_s_ ? std::clamp(state.t_s - *last_s_, 0.0, 0.5) : 0;
    last_s_ = state.t_s;
    if (v_H.norm() < kIntegralBelow_m_s)
      integral_N_ = (integral_N_ + g.integral_per_s * dt_s * (R_NH * v_H))
                        .cwiseMax(-kIntegralLimit_m_s)
                        .cwiseMin(kIntegralLimit_m_s);
    v_H += R_NH.conjugate() * integral_N_;
    return control::VelocitySetpoint{v_H, twist.yaw_rate / share};
  }

  ServoFlight flight_;
  Pose X_BC_;
  mission::HelipadPilot pilot_;
  mission::ServoSight sight_;
  Vector3d integral_N_ = Vector3d::Zero();  // m/s
  std::optional<double> last_s_, seen_s_;
  bool arrived_ = false;
  std::string_view phase_ = "wait";
  std::shared_ptr<const mission::ServoReport> report_;
};

}  // namespace

mission::MissionType TypeOf(const ServoFlight&) {
  return {.name = "servo",
          .summary = "Goes over the pad by one law of visual servoing, image-based or pose-based.",
          .looks_for_pad = true,
          .telemetry = ServoColumns(),
          .metrics = ServoMetrics(),
          .add_metrics = AddServoMetrics,
          .common_metrics = {"fix_*", "longest_loss_s", "settle_s", "hold_*"},
          .plots = {{"servo.png", HasServoed, ServoPlot}}};
}

std::unique_ptr<mission::Mission> MakeMission(const ServoFlight& flight, const mission::MissionParts& parts) {
  return std::make_unique<ServoMission>(flight, parts);
}

void CheckFlight(const ServoFlight& flight, const Place& where, Mistakes& mistakes) {
  const auto beyond = [&](const char* key, double value, const char* side) {
    mistakes.Add(where, fmt::format("flight.{}", key),
                 fmt::format("{:g} is not {} flight.height_m", value, side),
                 fmt::format("valid: {} {:g}", side, flight.height_m));
  };
  if (!(flight.ceiling_m > flight.height_m)) beyond("ceiling_m", flight.ceiling_m, "above");
  if (!(flight.floor_m < flight.height_m)) beyond("floor_m", flight.floor_m, "below");
}

void CheckFlightLimits(const ServoFlight& flight, const mission::AircraftLimits& limits, const Place& where,
                       Mistakes& mistakes) {
  const NoMoreThan most{where, mistakes};
  most("flight.gains.speed_limit_m_s", flight.gains.speed_limit_m_s, limits.speed_m_s,
       "autopilot.speed_limit_m_s");
  most("flight.gains.climb_limit_m_s", flight.gains.climb_limit_m_s, limits.climb_m_s,
       "autopilot.climb_limit_m_s");
  most("flight.gains.yaw_rate_limit_deg_s", flight.gains.yaw_rate_limit_deg_s, limits.yaw_rate_deg_s,
       "autopilot.yaw_rate_limit_deg_s");
}

// Yaw is the turn about the optical axis, as several of the laws have it.
void CheckFlightView(const ServoFlight&, const vision::CameraModel&, const vision::CameraMount& mount,
                     const Place&, const Place& mount_where, Mistakes& mistakes) {
  if (mount.pitch_deg == 0 && mount.roll_deg == 0) return;
  mistakes.Add(mount_where, mount.pitch_deg != 0 ? "mount.pitch_deg" : "mount.roll_deg",
               "the camera does not look straight down, as the laws of servo need it", "valid: 0");
}

}  // namespace kestrel::scenarios
