// SPDX-License-Identifier: Apache-2.0
#include "scenarios/stabilise/corner_motion.h"

#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>

#include "scenarios/stabilise/stabilise_report.h"
#include "vision/camera/camera_model.h"

namespace kestrel::scenarios {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Shown {
  const ShownImage* image;
  const vision::CameraModel* camera;
  double zoom;
  Pose X_NC;  // truly
};

// Where another camera sees what this one sees at uv on the ground; none: that is no ground.
std::optional<Vector2d> Moved(const Shown& from, const Shown& to, const Vector2d& uv) {
  const auto ray = vision::Ray(*from.camera, uv);
  if (!ray) return std::nullopt;
  const Vector3d ray_N = from.X_NC.R * *ray;
  if (ray_N.z() <= 0 || from.X_NC.p.z() >= 0) return std::nullopt;
  const Vector3d ground_N = from.X_NC.p - from.X_NC.p.z() / ray_N.z() * ray_N;
  return vision::Project(*to.camera, to.X_NC.Inverse() * ground_N);
}

std::optional<CornerFlow> FlowBetween(const Shown& from, const Shown& to) {
  CornerFlow flow;
  flow.t_s = to.image->t_s;
  const cv::Size view = to.image->view.size;
  const Vector2d middle(0.5 * (vision::WidthPx(*to.camera) - 1), 0.5 * (vision::HeightPx(*to.camera) - 1));
  const Vector2d view_middle(0.5 * (view.width - 1), 0.5 * (view.height - 1));
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d corner(i == 1 || i == 2 ? view.width - 1 : 0, i >= 2 ? view.height - 1 : 0);
    const Vector2d still = middle + (corner - view_middle) / to.zoom;
    const auto in = Moved(from, to, still);
    const auto source = vision::SourceOf(from.image->view, from.camera, corner);
    const auto moved = source ? Moved(from, to, *source) : std::nullopt;
    const auto out = moved ? vision::ShownAt(to.image->view, to.camera, *moved) : std::nullopt;
    if (!in || !out) return std::nullopt;
    flow.in[i] = to.zoom * (*in - still), flow.out[i] = *out - corner;
  }
  return flow;
}

}  // namespace

std::vector<CornerFlow> CornerFlows(const std::vector<mission::LogRow>& rows) {
  std::map<std::int64_t, Pose> truth;
  for (const mission::LogRow& row : rows) truth[row.sequence] = row.exposure.X_NC;
  std::vector<CornerFlow> longest, run;
  std::optional<Shown> before;
  const auto end_run = [&] {
    if (run.size() > longest.size()) longest = run;
    run.clear();
  };
  for (const mission::LogRow& row : rows) {
    const auto* report = mission::ReportOf<StabiliseReport>(row.decision);
    if (!report || !report->shown) continue;
    const Shown now{&*report->shown, report->camera.get(), report->zoom, truth[report->shown->sequence]};
    std::optional<CornerFlow> flow;
    if (before && now.image->sequence == before->image->sequence + 1) flow = FlowBetween(*before, now);
    if (flow) {
      run.push_back(*flow);
    } else {
      end_run();
    }
    before = now;
  }
  end_run();
  return longest;
}

std::vector<double> PathAmplitudes(const std::vector<double>& steps) {
  const int n = static_cast<int>(steps.size());
  if (n < 8) return {};
  cv::Mat windowed(1, n, CV_64F), spectrum;
  double mean = 0, weight = 0, power = 0;
  const auto hann = [n](int i) { return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (i + 0.5) / n); };
  for (int i = 0; i < n; ++i)
    mean += hann(i) * steps[static_cast<std::size_t>(i)], weight += hann(i), power += hann(i) * hann(i);
  mean /= weight;
  for (int i = 0; i < n; ++i) windowed.at<double>(i) = hann(i) * (steps[static_cast<std::size_t>(i)] - mean);
  cv::dft(windowed, spectrum, cv::DFT_COMPLEX_OUTPUT);
  std::vector<double> amplitudes = {0};
  for (int k = 1; 2 * k <= n; ++k) {
    const cv::Vec2d c = spectrum.at<cv::Vec2d>(k);
    // A step is the difference of two places: of a cosine it has the gain 2 sin(w / 2).
    const double gain = 2 * std::sin(std::numbers::pi * k / n);
    amplitudes.push_back(2 * std::hypot(c[0], c[1]) / std::sqrt(power * n) / gain);
  }
  return amplitudes;
}

double BandRms(const std::vector<double>& steps, double rate_hz, double from_hz, double until_hz) {
  const std::vector<double> amplitudes = PathAmplitudes(steps);
  double sum = 0;
  for (std::size_t k = 1; k < amplitudes.size(); ++k) {
    const double hz = rate_hz * static_cast<double>(k) / static_cast<double>(steps.size());
    if (hz >= from_hz && hz <= until_hz) sum += 0.5 * amplitudes[k] * amplitudes[k];
  }
  return std::sqrt(sum);
}

}  // namespace kestrel::scenarios
