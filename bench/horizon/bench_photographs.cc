// SPDX-License-Identifier: Apache-2.0
#include "bench/horizon/bench_photographs.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "base/file/files.h"
#include "base/stopwatch.h"
#include "base/user_file.h"
#include "geometry/tait_bryan.h"
#include "vision/camera/camera_mount.h"
#include "vision/horizon/horizon_drawing.h"
#include "vision/horizon/skyline.h"

namespace kestrel::bench {
namespace {

struct Tally {
  int photographs = 0, answered = 0;
  std::vector<double> errors_deg;  // of the labelled
  int within_2_sigma = 0;          // of roll and pitch, each
  std::map<std::string, int> refused;
};

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

std::string LineOf(const std::string& name, const Tally& t) {
  std::string line = fmt::format("{:<46} {:>4} {:>8}", name, t.photographs, t.answered);
  line += t.errors_deg.empty() ? fmt::format(" {:>7} {:>7} {:>7}", "", "", "")
                               : fmt::format(" {:>7.2f} {:>7.2f} {:>7.2f}", Quantile(t.errors_deg, 0.5),
                                             Quantile(t.errors_deg, 0.95), Quantile(t.errors_deg, 1));
  std::string refused;
  for (const auto& [reason, count] : t.refused)
    refused += fmt::format("{}{} {}", refused.empty() ? "" : ", ", reason, count);
  return line + "  " + refused;
}

}  // namespace

vision::Pinhole PhotographCamera(const cv::Size& size, double fov_deg) {
  const double f = (std::max(size.width, size.height) / 2.0) / std::tan(Radians(fov_deg) / 2);
  return {size.width, size.height, f, f, (size.width - 1) / 2.0, (size.height - 1) / 2.0};
}

Eigen::Vector3d LabelledDown(const Photograph& p, const vision::Pinhole& camera) {
  const double c = p.offset * camera.height_px;
  return Eigen::Vector3d(-p.slope * camera.fx, camera.fx, camera.cy - p.slope * camera.cx - c).normalized();
}

std::vector<Photograph> ReadPhotographs(const std::filesystem::path& folder, Mistakes& mistakes) {
  std::vector<Photograph> out;
  if (!std::filesystem::is_directory(folder)) {
    mistakes.Add(folder.string(), "", "no such folder", "valid: a folder of .jpg, .jpeg or .png files");
    return out;
  }
  constexpr auto kNone = std::numeric_limits<double>::quiet_NaN();
  std::map<std::string, std::pair<double, double>> labels;
  const auto label = [&](int number, const std::string& name, std::pair<double, double> is) {
    const std::string csv = (folder / "label.csv").string(), line = fmt::format("line {}", number);
    if (!IsFile(folder / name))
      mistakes.Add(csv, line, fmt::format("'{}' is not in the folder", name));
    else if (!labels.emplace(name, is).second)
      mistakes.Add(csv, line, fmt::format("'{}' has a label already", name));
  };
  std::ifstream file(folder / "label.csv");
  std::string text;
  for (int number = 1; std::getline(file, text); ++number) {
    if (!text.empty() && text.back() == '\r') text.pop_back();
    if (number == 1 || text.empty()) continue;
    const auto second = text.rfind(','), first = second == 0 ? second : text.rfind(',', second - 1);
    double slope = 0, offset = 0;
    if (first != std::string::npos && text.substr(first) == ",none,none") {
      label(number, text.substr(0, first), {kNone, kNone});
      continue;
    }
    if (second == std::string::npos || first == std::string::npos || first == second ||
        std::sscanf(text.c_str() + first, ",%lf,%lf", &slope, &offset) != 2 ||
        !std::isfinite(slope + offset)) {
      mistakes.Add((folder / "label.csv").string(), fmt::format("line {}", number), text,
                   "valid: filename,slope,offset, or filename,none,none where no horizon is in view");
      continue;
    }
    label(number, text.substr(0, first), {slope, offset});
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string extension = entry.path().extension(), stem = entry.path().stem();
    if (extension != ".jpg" && extension != ".jpeg" && extension != ".png") continue;
    Photograph p{.file = entry.path(), .flight = stem.substr(0, stem.rfind('_'))};
    if (const auto found = labels.find(entry.path().filename()); found != labels.end()) {
      std::tie(p.slope, p.offset) = found->second;
      p.labelled = true, p.none = std::isnan(p.slope);
    }
    out.push_back(p);
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.file < b.file; });
  if (out.empty())
    mistakes.Add(folder.string(), "", "no photograph in it", "valid: a folder of .jpg, .jpeg or .png files");
  return out;
}

void BenchPhotographs(const std::vector<Photograph>& photographs, double fov_deg,
                      const std::filesystem::path& out, std::vector<records::Figure>& table) {
  std::filesystem::create_directories(out);
  const Eigen::Matrix3d R_BC = vision::MountPose({.pitch_deg = 90}).R.toRotationMatrix();
  std::string csv =
      "photograph,flight,error_deg,roll_deg,pitch_deg,roll_sigma_deg,pitch_sigma_deg,cpu_ms,reason\n";
  std::map<std::string, Tally> flights;
  Tally all;
  double cpu_ms = 0;
  int none = 0, none_answered = 0;
  for (const Photograph& p : photographs) {
    none += p.none;
    const cv::Mat image = cv::imread(p.file.string(), cv::IMREAD_COLOR);
    Tally& flight = flights[p.flight];
    for (Tally* t : {&flight, &all}) ++t->photographs;
    if (image.empty()) {
      for (Tally* t : {&flight, &all}) ++t->refused["unreadable"];
      continue;
    }
    const vision::Pinhole camera = PhotographCamera(image.size(), fov_deg);
    const vision::Skyline skyline(camera, R_BC, {}, {});
    const double start_ms = ThreadCpu_ms();
    const vision::SkylineResult result = skyline.Measure(image);
    const double used_ms = ThreadCpu_ms() - start_ms;
    cpu_ms += used_ms;
    cv::imwrite((out / (p.file.stem().string() + ".png")).string(),
                vision::DrawHorizon(image, camera, R_BC, result, vision::NoHeading::kNoVertical));
    csv += fmt::format("{},{},", p.file.filename().string(), p.flight);
    const auto* fix = std::get_if<vision::SkylineFix>(&result);
    if (!fix) {
      const char* reason = vision::NameOf(std::get<vision::NoSkyline>(result));
      for (Tally* t : {&flight, &all}) ++t->refused[reason];
      csv += fmt::format(",,,,,{:.1f},{}\n", used_ms, reason);
      continue;
    }
    for (Tally* t : {&flight, &all}) ++t->answered;
    const vision::RollPitch is =
        vision::RollPitchFromDown(R_BC * fix->down_C, R_BC * fix->covariance * R_BC.transpose());
    const double roll_sigma = std::sqrt(is.covariance(0, 0)), pitch_sigma = std::sqrt(is.covariance(1, 1));
    std::string error;
    if (p.none) {
      ++none_answered;
    } else if (p.labelled) {
      const Eigen::Vector3d down_C = LabelledDown(p, camera);
      const double error_deg = Degrees(std::acos(std::clamp(fix->down_C.dot(down_C), -1.0, 1.0)));
      const vision::RollPitch said = vision::RollPitchFromDown(R_BC * down_C);
      const int within = (std::abs(WrapAngle(is.roll - said.roll)) < 2 * roll_sigma) +
                         (std::abs(is.pitch - said.pitch) < 2 * pitch_sigma);
      for (Tally* t : {&flight, &all}) t->errors_deg.push_back(error_deg), t->within_2_sigma += within;
      error = fmt::format("{:.3f}", error_deg);
    }
    csv += fmt::format("{},{:.3f},{:.3f},{:.3f},{:.3f},{:.1f},\n", error, Degrees(is.roll), Degrees(is.pitch),
                       Degrees(roll_sigma), Degrees(pitch_sigma), used_ms);
  }
  WriteFile(out / "photographs.csv", csv);
  fmt::print("{:<46} {:>4} {:>8} {:>7} {:>7} {:>7}  {}\n", "flight", "all", "answered", "median", "95 %",
             "worst deg", "refused");
  for (const auto& [name, tally] : flights) fmt::print("{}\n", LineOf(name, tally));
  fmt::print("{}\nRows and pictures: {}\n\n", LineOf("all", all), out.string());

  const auto add = [&](const char* what, double value, const char* unit, std::optional<double> target,
                       bool at_least = false) {
    table.push_back({std::string("photographs, ") + what, value, unit, target, at_least, ""});
  };
  const auto n = static_cast<double>(all.photographs);
  if (none < all.photographs)
    add("answered", (all.answered - none_answered) / (n - none), "share", 0.90, true);
  if (none > 0) add("answered though no horizon is in view", none_answered, "photographs", 0);
  add("mean of one core", cpu_ms / n, "ms", {});
  if (all.errors_deg.empty()) return;
  const auto over = [&](double deg) {
    return static_cast<double>(
        std::count_if(all.errors_deg.begin(), all.errors_deg.end(), [&](double e) { return e > deg; }));
  };
  const auto labelled = static_cast<double>(all.errors_deg.size());
  add("error, median", Quantile(all.errors_deg, 0.5), "deg", 0.8);
  add("error, 95th percentile", Quantile(all.errors_deg, 0.95), "deg", {});
  add("error, worst", Quantile(all.errors_deg, 1), "deg", {});
  add("answers off by more than 5 degrees", over(5) / labelled, "share", 0.01);
  add("answers off by more than 10 degrees", over(10), "photographs", 0);
  add("within 2 sigma", all.within_2_sigma / (2 * labelled), "share", 0.90, true);
}

}  // namespace kestrel::bench
