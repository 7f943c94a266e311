// SPDX-License-Identifier: Apache-2.0
#include "scenarios/stabilise/stabilise.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <deque>
#include <opencv2/imgproc.hpp>
#include <string>

#include "base/stopwatch.h"
#include "control/estimate/state_history.h"
#include "geometry/tait_bryan.h"
#include "mission/path/path_pilot.h"
#include "mission/path/path_records.h"
#include "records/plot/path_plot.h"
#include "scenarios/stabilise/stabilise_metrics.h"
#include "scenarios/stabilise/stabilise_plot.h"
#include "scenarios/stabilise/stabilise_report.h"
#include "vision/drawn_colours.h"
#include "vision/enhance/motion/opencl_device.h"
#include "vision/enhance/motion/point_flow.h"
#include "vision/enhance/stabilisation/stabiliser.h"

namespace kestrel::scenarios {
namespace {

constexpr double kUsualRate_hz = 30;  // of a camera whose own rate the frames have not told yet

std::vector<mission::Waypoint> HoverTransitHover(const StabiliseFlight& flight, const Eigen::Vector3d& p_N,
                                                 double yaw) {
  const Eigen::Vector3d from(p_N.x(), p_N.y(), -flight.height_m);
  const Eigen::Vector3d to = from + flight.transit_m * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0);
  return {{p_N, yaw, 0, "approach"},
          {from, yaw, flight.hover_s, "hover"},
          {to, yaw, 0, "transit"},
          {to, yaw, flight.hover_s, "hover again"}};
}

class StabiliseMission final : public mission::Mission {
 public:
  StabiliseMission(const StabiliseFlight& flight, const mission::MissionParts& parts)
      : flight_(flight),
        pilot_(
            flight.height_m, flight.path,
            [flight](const Eigen::Vector3d& p_N, double yaw) { return HoverTransitHover(flight, p_N, yaw); }),
        X_BC_(parts.X_BC),
        camera_(std::make_shared<vision::CameraModel>(parts.camera)),
        stabiliser_(flight.stabiliser, parts.camera, kUsualRate_hz) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision;
    auto report = std::make_shared<StabiliseReport>();
    history_.Add(state);
    report->camera = camera_;
    report->zoom = flight_.stabiliser.scale ? 1 / flight_.stabiliser.crop : 1;
    report->reference = pilot_.Fly(state, decision);
    Stabilise(frame, decision, *report);
    phase_ = decision.phase;
    // The video is late: what it shows last is still of the path.
    if (pilot_.AtEnd(state) && !ended_s_) ended_s_ = frame.t_s;
    if (ended_s_ && shown_s_ >= *ended_s_) decision.outcome = "flown";
    decision.report = report;
    return decision;
  }
  bool Accomplished() const override { return ended_s_.has_value(); }
  // It flies by the autopilot's own state, and the video is stabilised beside that.
  mission::TargetNeed Target() const override { return mission::TargetNeed::kNone; }

  void Draw(cv::Mat& bgr) const override {
    for (const vision::PointPair& pair : stabiliser_.last_inliers())
      cv::line(bgr, cv::Point2d(pair.from.x(), pair.from.y()), cv::Point2d(pair.to.x(), pair.to.y()),
               vision::kFixColour, 1, cv::LINE_AA);
  }
  std::vector<mission::Caption> Captions() const override {
    std::vector<mission::Caption> captions = {{std::string(phase_)},
                                              {last_.empty() ? "nothing stabilised yet" : last_}};
    if (flight_.stabiliser.motion.opencl)
      captions.push_back({"points are followed on " + vision::FlowDevice(true)});
    return captions;
  }
  cv::Mat ProductImage() const override { return product_; }

 private:
  void Stabilise(const vision::Frame& frame, mission::Decision& decision, StabiliseReport& report) {
    const auto start = std::chrono::steady_clock::now();
    vision::ImageAttitudes attitudes;
    if (const auto then = history_.At(frame.t_s)) {
      const Eigen::Quaterniond R_NC = then->R_NB * X_BC_.R;
      attitudes.R_NC_rows = {R_NC}, attitudes.down_C = R_NC.conjugate() * Eigen::Vector3d::UnitZ();
    }
    const auto image = stabiliser_.Step(frame.image, frame.t_s, attitudes);
    decision.vision_s = SecondsSince(start);
    waiting_.push_back(frame.sequence);
    product_.release();
    if (!image) {
      decision.target = "waiting";
      return;
    }
    report.shown = ShownImage{
        waiting_.front(),
        image->t_s,
        image->state,
        image->inliers,
        image->strength,
        image->view,
        flight_.stabiliser.motion.opencl && vision::OpenClStateNow() == vision::OpenClState::kUsed};
    waiting_.pop_front();
    shown_s_ = image->t_s;
    decision.target = vision::NameOf(image->state);
    product_ = image->image;
    if (product_.channels() == 1) cv::cvtColor(image->image, product_, cv::COLOR_GRAY2BGR);
    last_ = fmt::format("{}   {} of {} points agree, {:.2f} px   {:.1f} s late", decision.target,
                        image->inliers, image->points, image->rms_px, frame.t_s - image->t_s);
  }

  StabiliseFlight flight_;
  mission::PathPilot pilot_;
  Pose X_BC_;
  std::shared_ptr<const vision::CameraModel> camera_;
  vision::Stabiliser stabiliser_;
  control::StateHistory history_;
  std::deque<std::int64_t> waiting_;  // frames that were not shown yet
  std::optional<double> ended_s_;
  double shown_s_ = 0;
  cv::Mat product_;
  std::string last_;
  std::string_view phase_;
};

}  // namespace

mission::MissionType TypeOf(const StabiliseFlight&) {
  std::vector<mission::TelemetryColumn> columns = mission::PathColumns();
  for (const mission::TelemetryColumn& each : StabiliseColumns()) columns.push_back(each);
  std::vector<mission::Metric> metrics = mission::PathMetrics();
  for (const mission::Metric& each : StabiliseMetrics()) metrics.push_back(each);
  return {.name = "stabilise",
          .summary = "Hovers, flies on and hovers again while the video of its shaking camera is stabilised.",
          .telemetry = std::move(columns),
          .metrics = std::move(metrics),
          .add_metrics =
              [](const std::vector<mission::LogRow>& rows, std::map<std::string, double>& values) {
                mission::AddPathMetrics(rows, values);
                AddStabiliseMetrics(rows, values);
              },
          .plots = {{"path.png", records::FliesPath, records::PathPlot},
                    {"corner_motion.png", ShowsStabilised, CornerMotionPlot}},
          .product_video = "stabilised.mp4"};
}

void CheckFlight(const StabiliseFlight& flight, const Place& where, Mistakes& mistakes) {
  if (flight.stabiliser.mode == "offline")
    mistakes.Add(where, "flight.stabiliser.mode", "is 'offline', which waits for the end of the flight",
                 "valid in flight: reference, smooth");
  if (flight.stabiliser.level && flight.stabiliser.by == "vision")
    mistakes.Add(where, "flight.stabiliser.level",
                 "is true, and by: vision knows no attitude of which the view could be levelled",
                 "valid: by: sphere, gyro or both");
}

void CheckFlightLimits(const StabiliseFlight& flight, const mission::AircraftLimits& limits,
                       const Place& where, Mistakes& mistakes) {
  mission::CheckPathLimits(flight.path, limits, where, mistakes);
}

std::unique_ptr<mission::Mission> MakeMission(const StabiliseFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<StabiliseMission>(flight, parts);
}

}  // namespace kestrel::scenarios
