// SPDX-License-Identifier: Apache-2.0
#include "records/recorder.h"

#include <fmt/format.h>

#include <initializer_list>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "geometry/tait_bryan.h"
#include "mission/mission_type.h"
#include "records/plot/flown_plot.h"
#include "records/summary.h"
#include "vision/write_image.h"

namespace kestrel::records {
namespace {

constexpr std::size_t kTargets = 2;  // with columns of their own

// The names and the values of the columns, side by side, so that neither shifts against the other.
class Columns {
 public:
  Columns(const LogRow& row, const TelemetryOptions& options);

  std::string names, values;

 private:
  void Add(std::string_view name, std::string_view value) {
    const char* separator = names.empty() ? "" : ",";
    names += fmt::format("{}{}", separator, name);
    values += fmt::format("{}{}", separator, value);
  }
  void Text(std::string_view name, std::string_view value) {
    if (value.find_first_of(",\"\n\r") == std::string_view::npos) return Add(name, value);
    std::string quoted = "\"";
    for (const char c : value) quoted.append(c == '"' ? 2 : 1, c);
    Add(name, quoted + '"');
  }
  void Flag(std::string_view name, bool value) { Add(name, value ? "1" : "0"); }
  void Number(std::string_view name, double value) { Add(name, fmt::format("{:.9g}", value)); }
  template <class T>
  void Number(std::string_view name, bool given, T value) {
    Add(name, given ? fmt::format("{:.9g}", static_cast<double>(value)) : "");
  }
  // The names have {} where x, y, z stand.
  void Vector(std::string_view name, const Eigen::Vector3d& v) { Vector(name, true, v); }
  void Vector(std::string_view name, bool given, const Eigen::Vector3d& v, std::string_view letters = "xyz") {
    for (int i = 0; i < 3; ++i) Number(fmt::format(fmt::runtime(name), letters[i]), given, v[i]);
  }
  void Angles(std::string_view of, const std::optional<Eigen::Quaterniond>& R) {
    const TaitBryan angles = R ? TaitBryanFromRotation(R->toRotationMatrix()) : TaitBryan{};
    Number(fmt::format("{}_yaw_deg", of), R.has_value(), Degrees(angles.yaw));
    Number(fmt::format("{}_pitch_deg", of), R.has_value(), Degrees(angles.pitch));
    Number(fmt::format("{}_roll_deg", of), R.has_value(), Degrees(angles.roll));
  }
  void Setpoints(std::string_view of, const std::optional<control::Setpoint>& given) {
    const control::Setpoint* setpoint = given ? &*given : nullptr;
    const auto* velocity = std::get_if<control::VelocitySetpoint>(setpoint);
    const auto* position = std::get_if<control::PositionSetpoint>(setpoint);
    const auto* attitude = std::get_if<control::AttitudeSetpoint>(setpoint);
    const auto* rates = std::get_if<control::RateSetpoint>(setpoint);
    Vector(fmt::format("{}_v{{}}_m_s", of), velocity, velocity ? velocity->v_H : Eigen::Vector3d::Zero());
    Number(fmt::format("{}_yaw_rate_deg_s", of), velocity || attitude || rates,
           Degrees(velocity   ? velocity->yaw_rate
                   : attitude ? attitude->yaw_rate
                   : rates    ? rates->w_B.z()
                              : 0));
    Vector(fmt::format("{}_{{}}_m", of), position, position ? position->p_N : Eigen::Vector3d::Zero());
    Number(fmt::format("{}_yaw_deg", of), position, position ? Degrees(position->yaw) : 0);
    Number(fmt::format("{}_pitch_deg", of), attitude, attitude ? Degrees(attitude->pitch) : 0);
    Number(fmt::format("{}_roll_deg", of), attitude, attitude ? Degrees(attitude->roll) : 0);
    Number(fmt::format("{}_pitch_rate_deg_s", of), rates, rates ? Degrees(rates->w_B.y()) : 0);
    Number(fmt::format("{}_roll_rate_deg_s", of), rates, rates ? Degrees(rates->w_B.x()) : 0);
    Number(fmt::format("{}_thrust", of), attitude || rates,
           attitude ? attitude->thrust
           : rates  ? rates->thrust
                    : 0);
  }
};

Columns::Columns(const LogRow& row, const TelemetryOptions& options) {
  const bool truth = options.truth;
  const mission::Decision& decision = row.decision;
  Add("sequence", fmt::format("{}", row.sequence));
  Number("t_s", row.now.t_s);
  Number("exposure_t_s", row.exposure.t_s);
  Text("phase", decision.phase);
  Text("target", decision.target);
  Text("target_state", mission::NameOf(decision.target_state));
  Text("mode", row.heard ? control::NameOf(row.estimate.mode) : "");
  Flag("landed", row.estimate.landed);
  Flag("saturated", row.estimate.saturated);

  Vector("truth_{}_m", truth, row.now.X_NB.p);
  Vector("truth_v{}_m_s", truth, row.now.v_N);
  Angles("truth", truth ? std::optional(row.now.X_NB.R) : std::nullopt);
  Vector("truth_rate_{}_deg_s", truth, row.now.w_B * Degrees(1));
  Number("truth_touching", truth, row.now.touching);
  Number("truth_attitude_failed", truth, row.now.attitude_failed);
  Vector("wind_{}_m_s", truth, row.now.wind_N, "ned");

  Vector("estimate_{}_m", row.heard, row.estimate.p_NB);
  Vector("estimate_v{}_m_s", row.heard, row.estimate.v_N);
  Angles("estimate", row.heard ? std::optional(row.estimate.R_NB) : std::nullopt);
  Flag("aided", row.estimate.aided);
  Angles("inertial", row.estimate.R_NB_inertial);

  const Pose X_TB = row.exposure.X_NT.Inverse() * row.exposure.X_NB;
  Vector("target_{}_m", truth, X_TB.p);
  Number("target_yaw_deg", truth, Degrees(YawOf(X_TB.R)));
  const bool seen = decision.fix.has_value();
  const mission::TargetFix fix = decision.fix.value_or(mission::TargetFix{});
  Vector("fix_{}_m", seen, fix.p_TB);
  Number("fix_yaw_deg", seen, Degrees(fix.yaw_TB));
  Number("fix_inliers", seen, fix.inliers);
  Number("fix_residual_px", seen, fix.residual_px);
  Number("fix_visible", seen, fix.visible);
  Number("fix_registered", seen, fix.registered);
  Number("fix_age_s", decision.fix_age_s);
  if (options.mission)
    for (const mission::TelemetryColumn& column : options.mission->telemetry) {
      const std::optional<double> value = column.value(row);
      Number(column.name, value.has_value(), value.value_or(0));
    }
  for (std::size_t i = 0; i < kTargets; ++i) {
    const bool there = i < row.now.targets.size();
    const TargetTruth target = there ? row.now.targets[i] : TargetTruth{};
    Vector(fmt::format("truth_target{}_{{}}_m", i), there, target.p_N);
    Vector(fmt::format("truth_target{}_v{{}}_m_s", i), there, target.v_N);
    Number(fmt::format("truth_target{}_in_view", i), there, target.in_view);
  }

  Setpoints("setpoint", decision.setpoint);
  Text("outcome", decision.outcome);
  if (!options.safety) return;
  Setpoints("safe", row.sent);
  Text("safety_hazard", row.hazard);
  Text("safety_reaction", row.reaction);
}

}  // namespace

std::string TelemetryHeader(const TelemetryOptions& options) { return Columns(LogRow{}, options).names; }
std::string TelemetryLine(const LogRow& row, const TelemetryOptions& options) {
  return Columns(row, options).values;
}

Recorder::Recorder(std::filesystem::path folder, RecorderOptions options)
    : folder_(std::move(folder)), options_(std::move(options)) {
  std::error_code error;
  std::filesystem::create_directories(folder_ / "plots", error);
  if (error) throw std::runtime_error(fmt::format("cannot write {}: {}", folder_.string(), error.message()));
  std::vector<std::filesystem::path> files = {"page.json", "report.html", "summary.json", "telemetry.csv",
                                              "video.mp4"};
  for (const std::string& name : PlotNames()) files.push_back(std::filesystem::path("plots") / name);
  for (const mission::Flight& each : mission::Missions()) {
    const mission::MissionType& type = each.type();
    files.insert(files.end(), type.products.begin(), type.products.end());
    if (!type.product_video.empty()) files.push_back(type.product_video);
  }
  for (const std::filesystem::path& each : files) {
    for (const std::filesystem::path& file : {folder_ / each, PartOf(folder_ / each)}) {
      std::filesystem::remove(file, error);
      if (error)
        throw std::runtime_error(fmt::format("cannot remove {}: {}", file.string(), error.message()));
    }
  }
  telemetry_.emplace(folder_ / "telemetry.csv");
  telemetry_->Write(TelemetryHeader(options_.telemetry) + '\n');
  if (!options_.video) return;
  video_.emplace(folder_ / "video.mp4", options_.rate_hz, options_.video_kbit_s);
  const mission::MissionType* mission = options_.telemetry.mission;
  if (mission && !mission->product_video.empty())
    product_.emplace(folder_ / mission->product_video, options_.rate_hz);
}

void Recorder::Write(const LogRow& row) {
  telemetry_->Write(TelemetryLine(row, options_.telemetry) + '\n');
  plotted_.Add(row);
}

void Recorder::WriteImage(const cv::Mat& bgr) {
  if (video_) video_->Write(bgr);
}

void Recorder::WriteProduct(const cv::Mat& bgr) {
  if (product_ && !bgr.empty()) product_->Write(bgr);
}

Summary Recorder::Finish(Summary summary) {
  const auto attempt = [&summary](auto&& action) {
    try {
      action();
    } catch (const std::runtime_error& e) {
      summary.complete = summary.passed = false;
      if (summary.error.find(e.what()) == std::string::npos) {
        summary.error += fmt::format("{}{}", summary.error.empty() ? "" : "; ", e.what());
      }
    }
  };
  attempt([&] { telemetry_->Close(); });
  if (video_) attempt([&] { video_->Close(); });
  if (product_) attempt([&] { product_->Close(); });
  attempt([&] {
    if (options_.telemetry.truth)
      DrawPlots(folder_ / "plots", plotted_.rows(), options_.plots);
    else
      DrawFlownPlot(folder_ / "plots" / "flown.png", plotted_.rows(), options_.plots.title);
  });
  WriteFile(folder_ / "summary.json", ToJson(summary));
  return summary;
}

}  // namespace kestrel::records
