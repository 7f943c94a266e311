// SPDX-License-Identifier: Apache-2.0
// A flight of one's own: circles over the pad by what the camera sees of it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"
#include "mission/plugin.h"
#include "records/plot/gnuplot.h"
#include "records/plot/plot_parts.h"

namespace {

using namespace kestrel;

struct CircleFlight {
  double height_m = 4;
  double radius_m = 0.8;
  double period_s = 30;
};

void Fields(FieldVisitor& v, CircleFlight& p) {
  v({"height_m", "height above the pad at which the aircraft circles"}, p.height_m, 1.0, 30.0);
  v({"radius_m", "radius of the circle about the pad's centre"}, p.radius_m, 0.1, 10.0);
  v({"period_s", "time of once around the circle"}, p.period_s, 5.0, 300.0);
}

class CircleMission final : public mission::Mission {
 public:
  CircleMission(const CircleFlight& flight, mission::HelipadPilot pilot)
      : flight_(flight), pilot_(std::move(pilot)) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision = pilot_.Observe(frame, state);
    if (state.landed) {
      phase_ = "take off";
      decision.setpoint =
          control::PositionSetpoint{{state.p_NB.x(), state.p_NB.y(), -flight_.height_m}, YawOf(state.R_NB)};
    } else if (!pilot_.HasEstimate()) {
      phase_ = "search";
      decision.setpoint = pilot_.Search(state);
      if (!decision.setpoint) decision.outcome = "pad not found";
    } else {
      const Eigen::Vector2d from_centre = pilot_.where().p_TB.head<2>();
      phase_ = around_ || std::abs(from_centre.norm() - flight_.radius_m) < 0.1 ? "circle" : "approach";
      around_ = around_ || std::string_view(phase_) == "circle";
      // A step ahead of where the aircraft is, on the circle: the goal cannot run away from it.
      const double ahead = 2 * M_PI / flight_.period_s;
      const double angle = std::atan2(from_centre.y(), from_centre.x()) + (around_ ? ahead : 0);
      const Eigen::Vector3d goal_T(flight_.radius_m * std::cos(angle), flight_.radius_m * std::sin(angle),
                                   -flight_.height_m);
      decision.goal_T = goal_T;
      decision.setpoint = pilot_.GoTo(goal_T, 0);
    }
    decision.phase = phase_;
    return decision;
  }
  bool Accomplished() const override { return around_; }
  mission::TargetNeed Target() const override { return mission::TargetNeed::kInSight; }
  control::VelocityLag MaxLag() const override { return pilot_.MaxLag(); }
  void Draw(cv::Mat& bgr) const override { pilot_.Draw(bgr); }
  std::vector<mission::Caption> Captions() const override { return pilot_.Captions(phase_); }

 private:
  CircleFlight flight_;
  mission::HelipadPilot pilot_;
  std::string_view phase_ = "search";
  bool around_ = false;
};

// Judged by the truth: how far around the pad it came.
void AddCircleMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& metrics) {
  double around = 0;
  std::optional<double> before;
  for (const mission::LogRow& row : rows) {
    if (row.decision.phase != "circle") continue;
    const Eigen::Vector3d p_TB = row.now.X_NT.Inverse() * row.now.X_NB.p;
    const double angle = std::atan2(p_TB.y(), p_TB.x());
    if (before) around += std::remainder(angle - *before, 2 * M_PI);
    before = angle;
  }
  if (before) metrics["circle_around_deg"] = Degrees(around);
}

bool Circles(const std::vector<mission::LogRow>& rows) {
  return std::any_of(rows.begin(), rows.end(),
                     [](const auto& row) { return row.decision.phase == "circle"; });
}

// The path over the pad from above, with the circle that was to be flown: a script of gnuplot.
std::string PathPlot(const std::filesystem::path& file, const std::vector<mission::LogRow>& rows,
                     const mission::FigureText& figure) {
  std::string text = "$path << END\n";
  for (const mission::LogRow& row : rows) {
    const Eigen::Vector3d p_TB = row.now.X_NT.Inverse() * row.now.X_NB.p;
    text += fmt::format("{:.4f} {:.4f}\n", p_TB.y(), p_TB.x());
  }
  text += "END\n$goals << END\n";
  for (const mission::LogRow& row : rows)
    if (const auto& goal_T = row.decision.goal_T)
      text += fmt::format("{:.4f} {:.4f}\n", goal_T->y(), goal_T->x());
  return text + "END\n" + records::BeginFigure(file, 800, 800) +
         fmt::format(
             "set title {}\nset size ratio -1\nset xlabel 'y of the pad (m)'\n"
             "set ylabel 'x of the pad (m)'\nset key top right\n"
             "plot $path with {} title 'truth', $goals with points pt 7 ps 0.4 title 'goal'\n",
             records::GnuplotQuoted(figure.title), records::kTruthStyle) +
         records::EndFigure();
}

mission::MissionType TypeOf(const CircleFlight&) {
  return {.name = "circle",
          .summary = "Circles over the pad.",
          .looks_for_pad = true,
          .metrics = {{"circle_around_deg", "deg", "how far around the pad it came, clockwise", -1e9, 1e9}},
          .add_metrics = AddCircleMetrics,
          .common_metrics = {"fix_*", "longest_loss_s"},
          .plots = {{"circle.png", Circles, PathPlot}}};
}

std::unique_ptr<mission::Mission> MakeMission(const CircleFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<CircleMission>(flight, mission::PilotOf(parts));
}

}  // namespace

KESTREL_PLUGIN { kestrel::mission::AddMission<CircleFlight>(); }
