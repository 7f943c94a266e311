// SPDX-License-Identifier: Apache-2.0
#include "scenarios/hand_held/hand_held.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <variant>

#include "base/stopwatch.h"
#include "scenarios/hand_held/hand_held_metrics.h"
#include "scenarios/hand_held/hand_held_plots.h"
#include "scenarios/hand_held/hand_held_report.h"
#include "vision/camera/camera_model.h"
#include "vision/drawn_colours.h"

namespace kestrel::scenarios {
namespace {

vision::PadTrackerOptions ChainOf(vision::PadTrackerOptions options) {
  options.method = "klt", options.registration = false;
  return options;
}

class HandHeldMission final : public mission::Mission {
 public:
  HandHeldMission(const HandHeldFlight& flight, const mission::MissionParts& parts)
      : camera_(std::get<vision::Pinhole>(parts.camera)),
        X_BC_(parts.X_BC),
        tracker_(parts.pad, camera_, parts.pilot.tracker) {
    if (flight.chain && parts.pilot.tracker.registration)
      chain_.emplace(parts.pad, camera_, ChainOf(parts.pilot.tracker));
  }

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState&) override {
    const auto start = std::chrono::steady_clock::now();
    mission::Decision decision;
    cv::Mat grey = frame.image;
    if (grey.channels() == 3) cv::cvtColor(frame.image, grey, cv::COLOR_BGR2GRAY);
    auto report = std::make_shared<HandHeldReport>();
    report->X_BC = X_BC_;
    seen_ = report->seen = tracker_.Track(grey, std::nullopt);
    decision.vision_s = SecondsSince(start);
    // The chain begins where the landmark is first found, and goes on alone until it breaks.
    if (chain_) report->chained = chain_->Track(grey, std::nullopt);
    const bool breaks = chain_begun_ && (!report->chained || report->chained->found);
    if (breaks) report->chained.reset(), chain_.reset();
    chain_begun_ = chain_begun_ || report->chained;
    ever_seen_ = ever_seen_ || seen_;
    decision.phase = "carried";
    decision.target = !seen_ ? "lost" : seen_->found ? "found" : seen_->registered ? "tracked" : "chained";
    decision.target_state = seen_ ? mission::TargetState::kInSight : mission::TargetState::kLost;
    decision.report = report;
    return decision;
  }
  bool Accomplished() const override { return ever_seen_; }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kNone; }  // it commands nothing

  void Draw(cv::Mat& bgr) const override {
    if (!seen_) return;
    for (const Eigen::Vector2d& p : tracker_.inlier_points())
      cv::circle(bgr, cv::Point2d(p.x(), p.y()), 3, vision::kFixColour, 1, cv::LINE_AA);
    const auto at = [&](const Eigen::Vector3d& p_T) {
      const Eigen::Vector2d uv =
          vision::Project(camera_, seen_->X_CT * p_T).value_or(Eigen::Vector2d::Zero());
      return cv::Point2d(uv.x(), uv.y());
    };
    const std::vector<Eigen::Vector2d> corners = tracker_.reference().Outline();
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Eigen::Vector2d &from = corners[k], &to = corners[(k + 1) % corners.size()];
      cv::line(bgr, at({from.x(), from.y(), 0}), at({to.x(), to.y(), 0}), vision::kFixColour, 2, cv::LINE_AA);
    }
  }
  std::vector<mission::Caption> Captions() const override {
    if (!seen_) return {{"carried by hand"}, {"landmark lost", true}};
    const Eigen::Vector3d &p = seen_->X_CT.p, sigma = seen_->covariance.diagonal().head<3>().cwiseSqrt();
    return {{"carried by hand"},
            {fmt::format("landmark x {:+.3f}  y {:+.3f}  z {:.3f} m", p.x(), p.y(), p.z())},
            {fmt::format("sigma {:.1f} {:.1f} {:.1f} mm", 1e3 * sigma.x(), 1e3 * sigma.y(), 1e3 * sigma.z())},
            {fmt::format("{} inliers, {:.2f} px", seen_->inliers, seen_->residual_px)}};
  }

 private:
  vision::Pinhole camera_;
  Pose X_BC_;
  vision::PadTracker tracker_;
  std::optional<vision::PadTracker> chain_;
  std::optional<vision::PadObservation> seen_;
  bool ever_seen_ = false, chain_begun_ = false;
};

}  // namespace

mission::MissionType TypeOf(const HandHeldFlight&) {
  return {.name = "hand_held",
          .summary = "A camera carried by hand estimates where it is by a landmark on a wall.",
          .looks_for_pad = true,
          .telemetry = HandHeldColumns(),
          .metrics = HandHeldMetrics(),
          .add_metrics = AddHandHeldMetrics,
          .plots = {{"hand_held.png", SawLandmark, HandHeldPlot},
                    {"hand_held_trajectory.png", SawLandmark, HandHeldTrajectory}}};
}

void CheckFlightView(const HandHeldFlight&, const vision::CameraModel& camera, const vision::CameraMount&,
                     const Place& where, const Place&, Mistakes& mistakes) {
  if (!std::holds_alternative<vision::Pinhole>(camera))
    mistakes.Add(where, "camera", "is none that the mission 'hand_held' sees through", "valid: a pinhole");
}

bool FlightCanHave(const HandHeldFlight& flight, const std::string& metric, const mission::Varies& varies) {
  return !metric.starts_with("chain_") || flight.chain || varies("flight.chain");
}

std::unique_ptr<mission::Mission> MakeMission(const HandHeldFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<HandHeldMission>(flight, parts);
}

}  // namespace kestrel::scenarios
