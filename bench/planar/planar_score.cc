// SPDX-License-Identifier: Apache-2.0
#include "bench/planar/planar_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"
#include "base/stopwatch.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::bench {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kGone = 0.01, kBack = 0.5;  // shares of the picture

}  // namespace

double AlignmentError_px(const Eigen::Matrix3d& H_w, const Eigen::Matrix3d& H_true) {
  double square = 0;
  for (const Eigen::Vector2d& corner : PlanarCorners())
    square += (vision::Transfer(H_w, corner) - vision::Transfer(H_true, corner)).squaredNorm() / 4;
  const double error = std::sqrt(square);
  return std::isfinite(error) ? error : kNever;
}

double PlanarScore::Precision(double within_px) const {
  const auto right =
      std::count_if(error_px.begin(), error_px.end(), [&](double e) { return e <= within_px; });
  return static_cast<double>(right) / static_cast<double>(std::max<std::size_t>(1, error_px.size()));
}

double PlanarScore::Accuracy_px() const {
  std::vector<double> tracked;
  std::copy_if(error_px.begin(), error_px.end(), std::back_inserter(tracked),
               [](double e) { return e <= kLost_px; });
  return Mean(tracked);
}

void PlanarScore::Add(const PlanarScore& other) {
  error_px.insert(error_px.end(), other.error_px.begin(), other.error_px.end());
  recovery_s.insert(recovery_s.end(), other.recovery_s.begin(), other.recovery_s.end());
  ms.insert(ms.end(), other.ms.begin(), other.ms.end());
  losses += other.losses, gone += other.gone, imagined += other.imagined;
}

PlanarScore ScoreOf(const PlanarTracker& tracker, const std::vector<PlanarFrame>& frames) {
  PlanarScore score;
  bool tracked = true, gone = false, recovering = false;
  std::size_t back = 0;  // the first frame after it was out of view, while recovering
  tracker.start(frames.front().image, frames.front().H_w);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const PlanarFrame& frame = frames[i];
    const double start_ms = ThreadCpu_ms();
    const auto H_w = tracker.track(frame.image);
    score.ms.push_back(ThreadCpu_ms() - start_ms);
    const double error = H_w ? AlignmentError_px(*H_w, frame.H_w) : kNever;
    if (frame.visible < kGone) {
      ++score.gone, score.imagined += H_w.has_value();
      gone = true;
    }
    if (gone && frame.visible >= kBack) gone = false, recovering = true, back = i;
    if (recovering && error <= PlanarScore::kRight_px) {
      score.recovery_s.push_back(static_cast<double>(i - back) / kPlanarRate_hz);
      recovering = false;
    }
    if (frame.visible < PlanarScore::kCounts) continue;
    score.error_px.push_back(error);
    score.losses += tracked && error > PlanarScore::kLost_px;
    tracked = error <= PlanarScore::kLost_px;
  }
  if (recovering) score.recovery_s.push_back(kNever);
  return score;
}

}  // namespace kestrel::bench
