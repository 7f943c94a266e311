// SPDX-License-Identifier: Apache-2.0
#include "bench/enhance/steadiness.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/statistics.h"
#include "vision/enhance/motion/motion_model.h"

namespace kestrel::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Discrete cosine transform (II), orthonormal.
std::vector<double> Cosines(const std::vector<double>& x) {
  const std::size_t n = x.size();
  std::vector<double> X(n);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < n; ++i)
      X[k] += x[i] * std::cos(M_PI * (static_cast<double>(i) + 0.5) * static_cast<double>(k) /
                              static_cast<double>(n));
    X[k] *= std::sqrt((k == 0 ? 1.0 : 2.0) / static_cast<double>(n));
  }
  return X;
}

void TakeOutLine(std::vector<double>& x) {
  const double n = static_cast<double>(x.size()), middle = (n - 1) / 2, mean = Mean(x);
  double slope = 0, spread = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double t = static_cast<double>(i) - middle;
    slope += t * x[i], spread += t * t;
  }
  slope /= spread;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= mean + slope * (static_cast<double>(i) - middle);
}

// Share of the energy, without the mean, in the second to the sixth coefficient (Liu et al., "Bundled camera paths for
// video stabilization", 2013).
double LowShare(const std::vector<double>& path) {
  const std::vector<double> X = Cosines(path);
  double low = 0, all = 0;
  for (std::size_t k = 1; k < X.size(); ++k) {
    all += X[k] * X[k];
    if (k < 6) low += X[k] * X[k];
  }
  return all > 0 ? low / all : 1;
}

// Linear part of how the view shows the image about its middle.
Eigen::Matrix2d LinearPart(const vision::ImageView& view, const vision::CameraModel& camera) {
  const Vector2d middle((vision::WidthPx(camera) - 1) / 2.0, (vision::HeightPx(camera) - 1) / 2.0);
  constexpr double kStep_px = 50;
  Eigen::Matrix2d A;
  for (int k = 0; k < 2; ++k) {
    const Vector2d step = kStep_px * Vector2d::Unit(k);
    A.col(k) =
        (*vision::ShownAt(view, &camera, middle + step) - *vision::ShownAt(view, &camera, middle - step)) /
        (2 * kStep_px);
  }
  return A;
}

}  // namespace

double BandRms(std::vector<double> path, double rate_hz, double from_hz, double to_hz) {
  TakeOutLine(path);
  const std::vector<double> X = Cosines(path);
  double sum = 0;
  for (std::size_t k = 1; k < X.size(); ++k) {
    const double hz = static_cast<double>(k) * rate_hz / (2 * static_cast<double>(X.size()));
    if (hz >= from_hz && hz <= to_hz) sum += X[k] * X[k];
  }
  return std::sqrt(sum / static_cast<double>(path.size()));
}

Steadiness SteadinessOf(const ShakenClip& clip, int first, const std::vector<vision::ImageView>& views) {
  const vision::CameraModel camera = clip.camera();
  const double w = clip.camera().width_px - 1, h = clip.camera().height_px - 1;
  Steadiness result;
  // The corners of what is shown, as the intended path sees them, and where they are.
  constexpr double kCorner = 0.08;
  std::array<std::vector<double>, 8> in, out, absolute_in, absolute_out;
  std::vector<double> skews_in, skews, crops, outsides;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const int i = first + static_cast<int>(k);
    const vision::ImageView& view = views[k];
    const Pose intended = clip.Intended(clip.t_s(i)), actual = clip.X_NC(clip.t_s(i)),
               begin = clip.Intended(clip.t_s(first));
    std::size_t c = 0;
    for (const double x : {kCorner, 1 - kCorner}) {
      for (const double y : {kCorner, 1 - kCorner}) {
        const Vector2d corner(x * w, y * h);
        const Vector3d p_N = clip.Ground(intended, corner);
        const Vector2d seen = clip.SeenByRows(i, p_N), shown = *vision::ShownAt(view, &camera, seen);
        for (int d = 0; d < 2; ++d, ++c) {
          in[c].push_back(seen[d] - corner[d]), out[c].push_back(shown[d] - corner[d]);
          // The path itself, without what of it is due to the corner being another place each time.
          const double along = (clip.SeenFrom(begin, p_N) - corner)[d];
          absolute_in[c].push_back(seen[d] - corner[d] - along);
          absolute_out[c].push_back(shown[d] - corner[d] - along);
        }
      }
    }
    // The rows' times: against an image that is exposed at once.
    vision::ImageView at_once = view;
    at_once.row_warps.clear();
    if (view.turned) at_once.R_NC_rows = {vision::AttitudeOfRow(view.R_NC_rows, 3, 1)};
    std::vector<vision::PointPair> pairs_in, pairs_out;
    for (const double x : {0.15, 0.4, 0.6, 0.85}) {
      for (const double y : {0.15, 0.4, 0.6, 0.85}) {
        const Vector3d p_N = clip.Ground(actual, {x * w, y * h});
        const Vector2d once = clip.SeenFrom(actual, p_N), seen = clip.SeenByRows(i, p_N);
        pairs_in.push_back({once, seen});
        pairs_out.push_back(
            {*vision::ShownAt(at_once, &camera, once), *vision::ShownAt(view, &camera, seen)});
      }
    }
    for (const auto& [pairs, rms] : {std::pair{&pairs_in, &skews_in}, {&pairs_out, &skews}}) {
      const auto S = vision::FitMotion(*pairs, vision::MotionModel::kSimilarity);
      for (const vision::PointPair& pair : *pairs)
        rms->push_back((vision::Transfer(*S, pair.from) - pair.to).norm());
    }
    const Vector2d scales = Eigen::JacobiSVD<Eigen::Matrix2d>(LinearPart(view, camera)).singularValues();
    result.distortion = std::max(result.distortion, scales.x() / scales.y());
    crops.push_back(view.size.width / (w + 1) / std::sqrt(scales.x() * scales.y()));
    int outside = 0;
    constexpr int kSteps = 20;
    for (int y = 0; y <= kSteps; ++y)
      for (int x = 0; x <= kSteps; ++x) {
        const auto at = vision::SourceOf(
            view, &camera, {x * (view.size.width - 1.0) / kSteps, y * (view.size.height - 1.0) / kSteps});
        outside += !at || at->x() < -0.01 || at->y() < -0.01 || at->x() > w + 0.01 || at->y() > h + 0.01;
      }
    outsides.push_back(outside / double((kSteps + 1) * (kSteps + 1)));
  }
  constexpr double kFrom_hz = 0.5, kTo_hz = 15;
  const auto rms = [&](const auto& paths) {
    std::vector<double> all;
    for (const auto& path : paths) all.push_back(BandRms(path, clip.options().rate_hz, kFrom_hz, kTo_hz));
    return std::sqrt(2.0) * Rms(all);  // of both coordinates
  };
  const auto low = [](const auto& paths) {
    std::vector<double> all;
    for (const auto& path : paths) all.push_back(LowShare(path));
    return Mean(all);
  };
  // In pixels of the input: the view may be enlarged.
  result.crop = Mean(crops);
  const double zoom = views.empty() ? 1 : views[0].size.width / (w + 1) / result.crop;
  result.jitter_in_px = rms(in), result.jitter_px = rms(out) / zoom;
  result.stability_in = low(absolute_in), result.stability = low(absolute_out);
  result.skew_in_px = Rms(skews_in), result.skew_px = Rms(skews) / zoom;
  result.outside = Mean(outsides);
  return result;
}

}  // namespace kestrel::bench
