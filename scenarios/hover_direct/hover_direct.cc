// SPDX-License-Identifier: Apache-2.0
#include "scenarios/hover_direct/hover_direct.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/diagnostics.h"
#include "base/stopwatch.h"
#include "control/estimate/state_history.h"
#include "control/law/level_camera.h"
#include "geometry/tait_bryan.h"
#include "mission/mean_square.h"
#include "mission/servo/servo_sight.h"
#include "scenarios/hover_direct/photometric_sight.h"
#include "vision/capture/frozen_image.h"

namespace kestrel::scenarios {
namespace {

using Eigen::Vector3d;

constexpr double kHoldFrom_s = 4;  // of the direct hover, for its metrics

struct DirectReport : mission::MissionReport {
  bool direct = false, photometric = false;
  Vector3d p_N, v_N, d_N;
  double yaw_deg = 0, residual_grey = 0;
};

class HoverDirectMission final : public mission::Mission {
 public:
  HoverDirectMission(const HoverDirectFlight& flight, const mission::MissionParts& parts)
      : flight_(flight),
        X_BC_(parts.X_BC),
        pilot_(mission::PilotOf(parts)),
        sight_(parts, {flight.height_m, Radians(flight.yaw_deg), 0, true}),
        observer_(flight.observer) {
    if (flight.law == "photometric")
      photometric_.emplace(parts.pad, pilot_.view(), sight_.view().X_DT, flight.photometric.blur_px);
  }

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    history_.Add(state);
    sight_.AddState(state);
    report_ = std::make_shared<DirectReport>();
    mission::Decision decision = Look(frame, state);
    decision.goal_T = sight_.goal_T();
    decision.goal_yaw_TB = sight_.goal_yaw_TB();
    const auto estimate = observer_.At(state.t_s);
    if (state.landed) {
      phase_ = "take off";
      decision.setpoint =
          control::PositionSetpoint{{state.p_NB.x(), state.p_NB.y(), -flight_.height_m}, YawOf(state.R_NB)};
    } else if (!estimate || estimate->age_s > flight_.lost_s + (state.t_s - frame.t_s)) {
      // What is not seen cannot be flown by: the autopilot's own loops hold, and look for it.
      phase_ = "search";
      observer_.Forget();
      decision.setpoint = pilot_.Search(state);
      if (!decision.setpoint) decision.outcome = "pad not found";
    } else {
      phase_ = near_ ? "grey levels" : "points";
      decision.setpoint = Fly(*estimate, frame.t_s, state);
    }
    decision.report = report_;
    decision.phase = phase_;
    return decision;
  }

  bool Accomplished() const override { return report_ && report_->direct; }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kInSight; }

  void Draw(cv::Mat& bgr) const override {
    if (near_) return;
    pilot_.Draw(bgr);
    sight_.Draw(bgr);
  }
  std::vector<mission::Caption> Captions() const override {
    if (near_) return {{"grey levels"}};
    return pilot_.Captions(phase_);
  }

 private:
  // Grey levels, or the tracker of the pad; what they measure goes to the observer.
  mission::Decision Look(const vision::Frame& frame, const control::VehicleState& state) {
    if (photometric_ && near_) {
      mission::Decision decision;
      if (Compare(frame, state, decision)) return decision;
      near_ = false;
    }
    mission::Decision decision = pilot_.Observe(frame, state);
    const auto* seen = pilot_.seen();
    if (!seen) return decision;
    const mission::ServoView& view = sight_.Look(*seen, pilot_.view(), frame.t_s, state);
    seen_R_TB_ = (X_BC_ * seen->X_CT).Inverse().R;
    // The law's velocity by a gain of 1 per second is the way to the goal.
    const mission::ServoAnswer answer = mission::AnswerOf("points_desired", view, 1);
    if (answer.state != control::ServoState::kRegular) return decision;
    Measured(-answer.twist.v, -answer.twist.yaw_rate, frame.t_s, state);
    near_ = photometric_ && (-answer.twist.v).norm() < flight_.photometric.within_m;
    return decision;
  }

  bool Compare(const vision::Frame& frame, const control::VehicleState& state, mission::Decision& decision) {
    const auto start = std::chrono::steady_clock::now();
    cv::Mat grey = frame.image;
    if (grey.channels() == 3) cv::cvtColor(frame.image, grey, cv::COLOR_BGR2GRAY);
    const bool frozen = frozen_.Is(grey);
    const TaitBryan angles =
        TaitBryanFromRotation(history_.At(frame.t_s).value_or(state).R_NB.toRotationMatrix());
    const Eigen::Quaterniond R_VC = control::LevelRotation(angles.roll, angles.pitch, X_BC_.R);
    const auto fix = frozen ? std::nullopt : photometric_->Compare(grey, R_VC);
    decision.vision_s = SecondsSince(start);
    if (!fix || fix->residual_grey > flight_.photometric.max_residual_grey ||
        fix->p_V.norm() > 2 * flight_.photometric.within_m)
      return false;
    decision.target = "grey levels";
    decision.target_state = mission::TargetState::kInSight;
    report_->photometric = true, report_->residual_grey = fix->residual_grey;
    Measured(fix->p_V, fix->yaw, frame.t_s, state);
    return true;
  }

  void Measured(const Vector3d& p_V, double yaw, double exposed_s, const control::VehicleState& state) {
    const double yaw_N = YawOf(history_.At(exposed_s).value_or(state).R_NB);
    // Of the camera; the aircraft is off by its lever less, which turns with it alone.
    const Vector3d p_N = HeadingRotation(yaw_N) * (X_BC_.R * p_V);
    const Eigen::Quaterniond turn = HeadingRotation(yaw_N - yaw);
    observer_.Correct(exposed_s, p_N - (HeadingRotation(yaw_N) * X_BC_.p - turn * X_BC_.p));
    goal_yaw_N_ = yaw_N - yaw;
  }

  control::Setpoint Fly(const control::HoverObserver::Estimate& now, double exposed_s,
                        const control::VehicleState& state) {
    const double at_s = flight_.predict ? state.t_s : exposed_s;
    const auto estimate = flight_.predict ? now : *observer_.At(exposed_s);
    const control::VehicleState flown = history_.At(at_s).value_or(state);
    const Eigen::Quaterniond R_NB = Attitude(flown, exposed_s);
    control::DirectError error{estimate.p_N, estimate.v_N, estimate.d_N,
                               WrapAngle(goal_yaw_N_ - YawOf(flown.R_NB))};
    const control::RateSetpoint setpoint = control::DirectHover(error, R_NB, flight_.gains);
    observer_.AddAcceleration(state.t_s, control::ThrustAcceleration(setpoint.thrust, R_NB, flight_.gains));
    report_->direct = true;
    report_->p_N = estimate.p_N, report_->v_N = estimate.v_N, report_->d_N = estimate.d_N;
    report_->yaw_deg = Degrees(error.yaw);
    return setpoint;
  }

  // By the autopilot; or by the pad's pose at the last exposure that showed it, and the gyros since.
  Eigen::Quaterniond Attitude(const control::VehicleState& at, double exposed_s) const {
    if (flight_.attitude == "autopilot" || !seen_R_TB_) return at.R_NB;
    const auto then = history_.At(exposed_s);
    if (!then) return at.R_NB;
    const Eigen::Quaterniond since = then->R_NB.conjugate() * at.R_NB;
    return HeadingRotation(YawOf(then->R_NB) - YawOf(*seen_R_TB_)) * *seen_R_TB_ * since;
  }

  HoverDirectFlight flight_;
  Pose X_BC_;
  mission::HelipadPilot pilot_;
  mission::ServoSight sight_;
  control::StateHistory history_;
  control::HoverObserver observer_;
  std::optional<PhotometricSight> photometric_;
  vision::FrozenImage frozen_;
  std::optional<Eigen::Quaterniond> seen_R_TB_;
  double goal_yaw_N_ = 0;
  bool near_ = false;  // flown by grey levels
  std::string_view phase_ = "search";
  std::shared_ptr<DirectReport> report_;
};

const DirectReport* ReportOf(const mission::LogRow& row) {
  return mission::ReportOf<DirectReport>(row.decision);
}

std::vector<mission::TelemetryColumn> Columns() {
  const auto column = [](const std::string& name, auto get) {
    return mission::TelemetryColumn{name, [get](const mission::LogRow& row) -> std::optional<double> {
                                      const DirectReport* report = ReportOf(row);
                                      return report && report->direct ? std::optional<double>(get(*report))
                                                                      : std::nullopt;
                                    }};
  };
  std::vector<mission::TelemetryColumn> columns;
  for (int i = 0; i < 3; ++i) {
    const char axis = "xyz"[i];
    columns.push_back(
        column(fmt::format("direct_{}_m", axis), [i](const DirectReport& r) { return r.p_N[i]; }));
    columns.push_back(
        column(fmt::format("direct_v{}_m_s", axis), [i](const DirectReport& r) { return r.v_N[i]; }));
    columns.push_back(
        column(fmt::format("direct_d{}_m_s2", axis), [i](const DirectReport& r) { return r.d_N[i]; }));
  }
  columns.push_back(column("direct_yaw_deg", [](const DirectReport& r) { return r.yaw_deg; }));
  columns.push_back(column("direct_residual_grey", [](const DirectReport& r) { return r.residual_grey; }));
  return columns;
}

void AddMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& m) {
  mission::MeanSquare level, height;
  double direct = 0, grey = 0;
  for (const mission::LogRow& row : rows) {
    const DirectReport* report = ReportOf(row);
    if (!report) continue;
    direct += report->direct, grey += report->photometric;
    if (!row.decision.goal_T || row.now.t_s < rows.front().now.t_s + kHoldFrom_s) continue;
    const Vector3d off = (row.now.X_NT.Inverse() * row.now.X_NB).p - *row.decision.goal_T;
    level.Add(off.head<2>().norm()), height.Add(off.z());
  }
  const auto frames = static_cast<double>(rows.size());
  m["direct_share"] = direct / frames, m["grey_share"] = grey / frames;
  if (level.count > 0) {
    m["direct_horizontal_rmse_m"] = level.Root();
    m["direct_vertical_rmse_m"] = height.Root();
  }
}

}  // namespace

mission::MissionType TypeOf(const HoverDirectFlight&) {
  return {.name = "hover_direct",
          .summary = "Hovers over the pad by rates and thrust straight from what the camera sees.",
          .looks_for_pad = true,
          .telemetry = Columns(),
          .metrics = {{"direct_share", "1", "Share of the frames that were flown by rates and thrust", 0, 1},
                      {"grey_share", "1", "Share of the frames that were flown by grey levels", 0, 1},
                      {"direct_horizontal_rmse_m", "m", "RMS horizontal distance from the goal, from 4 s on"},
                      {"direct_vertical_rmse_m", "m", "RMS vertical distance from the goal, from 4 s on"}},
          .add_metrics = AddMetrics,
          .common_metrics = {"fix_*", "longest_loss_s", "settle_s", "hold_*"}};
}

std::unique_ptr<mission::Mission> MakeMission(const HoverDirectFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<HoverDirectMission>(flight, parts);
}

void CheckFlight(const HoverDirectFlight& flight, const Place& where, Mistakes& mistakes) {
  if (flight.law == "photometric" && flight.attitude == "camera")
    mistakes.Add(where, "flight.attitude", "camera: grey levels tell no roll and pitch", "valid: autopilot");
}

void CheckFlightView(const HoverDirectFlight& flight, const vision::CameraModel& camera,
                     const vision::CameraMount& mount, const Place& where, const Place& mount_where,
                     Mistakes& mistakes) {
  if (mount.pitch_deg != 0 || mount.roll_deg != 0)
    mistakes.Add(mount_where, mount.pitch_deg != 0 ? "mount.pitch_deg" : "mount.roll_deg",
                 "the camera does not look straight down, as hover_direct needs it", "valid: 0");
  if (flight.law == "photometric" && !std::holds_alternative<vision::Pinhole>(camera))
    mistakes.Add(where, "flight.law", "photometric: the camera is no pinhole", "valid: points");
}

}  // namespace kestrel::scenarios
