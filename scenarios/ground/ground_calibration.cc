// SPDX-License-Identifier: Apache-2.0
#include "scenarios/ground/ground_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/file/files.h"
#include "control/estimate/state_history.h"
#include "geometry/tait_bryan.h"
#include "mission/ground/ground_observer.h"
#include "mission/helipad_pilot.h"
#include "vision/aircraft/place_calibration.h"

namespace kestrel::scenarios {
namespace {

constexpr const char* kFile = "ground_place.yaml";
constexpr double kApart_s = 0.03;  // a fix from on board and one from the ground that are of one place
constexpr double kPeriod_s = 0.1;  // of sightings that are kept

// At the end of a flight that found the place.
struct PlaceReport final : mission::MissionReport {
  double sigma_m = 0, sigma_deg = 0;  // of the coordinate and of the angle that are known worst
};

PlaceReport ReportOf(const vision::PlaceCalibration& found) {
  const Eigen::Matrix<double, 6, 1> sigma = found.covariance.diagonal().cwiseSqrt();
  PlaceReport report;
  report.sigma_m = sigma.head<3>().maxCoeff();
  report.sigma_deg = Degrees(sigma.tail<3>().maxCoeff());
  return report;
}

std::string PlaceFile(const vision::PlaceCalibration& found) {
  const TaitBryan angles = TaitBryanFromRotation(found.X_TG.R.toRotationMatrix());
  const Eigen::Matrix<double, 6, 1> sigma = found.covariance.diagonal().cwiseSqrt();
  std::string text = fmt::format(
      "# Where the camera on the ground stands, by {} sightings, {:.2f} sigmas left; lines for a file of "
      "gains.\n",
      found.sightings, found.residual);
  const Eigen::Vector3d position_m(found.X_TG.p.x(), found.X_TG.p.y(), -found.X_TG.p.z());
  for (int i = 0; i < 3; ++i)
    text += fmt::format("ground_camera.place.position_m.{}: {:.4f}  # sigma {:.4f}\n", i, position_m[i],
                        sigma[i]);
  text += fmt::format(
      "ground_camera.place.yaw_deg: {:.4f}\nground_camera.place.pitch_deg: {:.4f}\n"
      "ground_camera.place.roll_deg: {:.4f}\n",
      Degrees(angles.yaw), Degrees(angles.pitch), Degrees(angles.roll));
  const PlaceReport report = ReportOf(found);
  text += fmt::format("ground_camera.place.position_sigma_m: {:.4f}\n", report.sigma_m);
  text += fmt::format("ground_camera.place.angle_sigma_deg: {:.4f}\n", report.sigma_deg);
  text += "# Covariance of the position and of a turn about the pad's axes, m and rad:\n";
  for (int i = 0; i < 6; ++i) {
    text += "#";
    for (int j = 0; j < 6; ++j) text += fmt::format(" {:11.4e}", found.covariance(i, j));
    text += "\n";
  }
  return text;
}

class CalibrationMission final : public mission::Mission {
 public:
  CalibrationMission(const GroundCalibrationFlight& flight, const mission::MissionParts& parts)
      : flight_(flight), pilot_(mission::PilotOf(parts)), observer_(parts.ground.value()) {
    X_TG_ = vision::MastPose(parts.ground->place);
    // Round the pad below, up, round it above and down again.
    const double r = flight.reach_m;
    for (int lap = 0; lap < flight.laps; ++lap)
      for (const double height_m : {flight.low_m, flight.high_m})
        for (const auto& [x, y] : {std::pair{r, r}, {r, -r}, {-r, -r}, {-r, r}})
          corners_.emplace_back(x, y, -height_m);
  }

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision = pilot_.Observe(frame, state);
    states_.Add(state);
    if (decision.fix) board_.push_back({frame.t_s, *decision.fix});
    if (board_.size() > kBoardKept) board_.erase(board_.begin());
    for (const mission::GroundFix& fix : observer_.Observe(states_, state.t_s, Expected())) Add(fix);
    decision.target =
        observer_.state() == mission::GroundState::kNoFrame ? decision.target : NameOf(observer_.state());
    Fly(state, decision);
    decision.phase = phase_;
    return decision;
  }
  bool Accomplished() const override {
    return next_ == corners_.size() && Found().state == vision::PlaceState::kFound;
  }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kInSight; }
  control::VelocityLag MaxLag() const override { return pilot_.MaxLag(); }
  void Draw(cv::Mat& bgr) const override { pilot_.Draw(bgr); }
  std::vector<mission::Caption> Captions() const override { return pilot_.Captions(phase_); }
  cv::Mat ProductImage() const override { return observer_.Drawn(); }
  void WriteProducts(const std::filesystem::path& folder) const override {
    if (const auto found = Found(); found.state == vision::PlaceState::kFound)
      WriteFile(folder / kFile, PlaceFile(found));
  }

 private:
  struct BoardFix {
    double t_s;
    mission::TargetFix fix;
  };
  static constexpr std::size_t kBoardKept = 60;

  vision::PlaceCalibration Found() const { return vision::CalibratePlace(sightings_, kPeriod_s); }

  // By the place of the mast that is believed, which may be far off: where to look first.
  std::function<std::optional<Pose>(double)> Expected() const {
    return [this](double t_s) -> std::optional<Pose> {
      const auto state = states_.At(t_s);
      if (!pilot_.HasEstimate() || !state) return std::nullopt;
      const auto& where = pilot_.where();
      const Eigen::Quaterniond R_TN = HeadingRotation(where.yaw_TB - YawOf(state->R_NB));
      return Pose{R_TN * state->R_NB, where.p_TB};
    };
  }

  void Add(const mission::GroundFix& ground) {
    if (!sightings_.empty() && ground.t_s < last_s_ + kPeriod_s) return;
    const auto near =
        std::min_element(board_.begin(), board_.end(), [&](const BoardFix& a, const BoardFix& b) {
          return std::abs(a.t_s - ground.t_s) < std::abs(b.t_s - ground.t_s);
        });
    if (near == board_.end() || std::abs(near->t_s - ground.t_s) > kApart_s) return;
    const auto then = states_.At(near->t_s);
    if (!then) return;
    const Eigen::Quaterniond R_TN = HeadingRotation(near->fix.yaw_TB - YawOf(then->R_NB));
    vision::PlaceSighting s;
    s.p_TB = near->fix.p_TB + R_TN * then->v_N * (ground.t_s - near->t_s);
    s.sigma_m = 0.01 + 0.01 * std::abs(s.p_TB.z());
    // As the head had it: the place that is believed drops out.
    s.p_GB = X_TG_.Inverse() * ground.X_TB.p;
    const Eigen::Vector3d ray_T = (ground.X_TB.p - X_TG_.p).normalized();
    const double along = ray_T.dot(ground.covariance * ray_T);
    s.range_sigma_m = std::sqrt(along);
    s.bearing_sigma = std::sqrt(std::max(0.0, ground.covariance.trace() - along) / 2) / s.p_GB.norm();
    sightings_.push_back(s);
    last_s_ = ground.t_s;
  }

  void Fly(const control::VehicleState& state, mission::Decision& decision) {
    if (!pilot_.HasEstimate()) {
      phase_ = "search";
      decision.setpoint = pilot_.Search(state);
      if (!decision.setpoint) decision.outcome = "pad not found";
      return;
    }
    while (next_ < corners_.size() && (pilot_.where().p_TB - corners_[next_]).norm() < flight_.reached_m)
      ++next_;
    phase_ = "corners";
    if (next_ == corners_.size()) {
      const vision::PlaceCalibration found = Found();
      const bool calibrated = found.state == vision::PlaceState::kFound;
      decision.outcome = calibrated ? "calibrated" : NameOf(found.state);
      if (calibrated) decision.report = std::make_shared<PlaceReport>(ReportOf(found));
    }
    const Eigen::Vector3d goal_T = corners_[std::min(next_, corners_.size() - 1)];
    decision.setpoint = pilot_.GoTo(goal_T, Radians(flight_.yaw_deg));
  }

  GroundCalibrationFlight flight_;
  mission::HelipadPilot pilot_;
  mission::GroundObserver observer_;
  control::StateHistory states_;
  Pose X_TG_;  // as it is believed
  std::vector<Eigen::Vector3d> corners_;
  std::size_t next_ = 0;
  std::vector<BoardFix> board_;
  std::vector<vision::PlaceSighting> sightings_;
  double last_s_ = 0;
  std::string_view phase_ = "search";
};

}  // namespace

void CheckFlight(const GroundCalibrationFlight& flight, const Place& where, Mistakes& mistakes) {
  if (flight.high_m < flight.low_m + 0.5)
    mistakes.Add(
        where, "flight.high_m",
        fmt::format("{:g} is less than half a metre above flight.low_m = {:g}", flight.high_m, flight.low_m),
        "valid: more");
}

mission::MissionType TypeOf(const GroundCalibrationFlight&) {
  return {.name = "ground_calibration",
          .summary = "Finds where a camera on the ground stands, by flying over the pad before it.",
          .looks_for_pad = true,
          .needs_ground_camera = true,
          .begins_in_the_air = true,
          .metrics = {{"ground_place_sigma_m", "m",
                       "Stated standard deviation of the worst coordinate of the camera on the ground"},
                      {"ground_place_sigma_deg", "deg",
                       "Stated standard deviation of the worst angle of the camera on the ground"}},
          .add_metrics =
              [](const std::vector<mission::LogRow>& rows, std::map<std::string, double>& metrics) {
                const auto* report =
                    rows.empty() ? nullptr : mission::ReportOf<PlaceReport>(rows.back().decision);
                if (!report) return;
                metrics["ground_place_sigma_m"] = report->sigma_m;
                metrics["ground_place_sigma_deg"] = report->sigma_deg;
              },
          .common_metrics = {"fix_*", "longest_loss_s"},
          .products = {kFile},
          .product_video = "ground.mp4"};
}

std::unique_ptr<mission::Mission> MakeMission(const GroundCalibrationFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<CalibrationMission>(flight, parts);
}

}  // namespace kestrel::scenarios
