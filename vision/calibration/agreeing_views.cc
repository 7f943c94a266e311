// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/agreeing_views.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

constexpr double kMaxOutliers = 1.0 / 3;  // of a view's corners

}  // namespace

std::vector<std::vector<SeenPoint>> PointsOf(const Board& board, std::span<const BoardView> views,
                                             const std::vector<std::size_t>& usable, double common_px,
                                             const BoardShape& shape) {
  const std::vector<Vector2d> places = Corners(board);
  std::vector<std::vector<SeenPoint>> all;
  for (const std::size_t i : usable) {
    std::vector<SeenPoint> points;
    for (const BoardCorner& corner : views[i].corners) {
      const Eigen::Matrix2d covariance =
          corner.covariance + common_px * common_px * Eigen::Matrix2d::Identity();
      const Eigen::Matrix2d L = covariance.llt().matrixL();
      const std::size_t number = static_cast<std::size_t>(corner.index);
      Eigen::Vector3d p_T(places[number].x(), places[number].y(), 0);
      if (!shape.offsets_m.empty()) p_T += shape.offsets_m[number];
      points.push_back({p_T, corner.pixel, L.inverse(), corner.index});
    }
    all.push_back(std::move(points));
  }
  return all;
}

double FreedomOf(const Agreeing& a, std::size_t free) {
  double points = 0;
  for (const AdjustedView& view : a.adjustment.views) points += static_cast<double>(view.points.size());
  return 2 * points - static_cast<double>(free) - 6 * static_cast<double>(a.adjustment.views.size());
}

Agreeing SelectAgreeing(const PlacedViews& placed, std::vector<std::string>& left_out) {
  const double limit = kOutlier * RobustScale(placed.adjustment);
  Agreeing agreeing{{placed.adjustment.camera, {}, placed.adjustment.board}, {}, {}};
  std::fill(left_out.begin(), left_out.end(), "no pose of the board fits it");
  for (std::size_t i = 0; i < placed.numbers.size(); ++i) {
    const AdjustedView& all = placed.adjustment.views[i];
    AdjustedView noise{all.X_CT, {}};
    std::vector<std::size_t> corners;
    for (std::size_t j = 0; j < all.points.size(); ++j) {
      const auto error = WhitenedError(placed.adjustment.camera, all.X_CT, all.points[j]);
      if (!error || error->norm() > limit) continue;
      noise.points.push_back(all.points[j]);
      corners.push_back(j);
    }
    const std::size_t wild = all.points.size() - corners.size();
    std::string& reason = left_out[placed.numbers[i]];
    reason.clear();
    if (static_cast<double>(wild) > kMaxOutliers * static_cast<double>(all.points.size()) ||
        corners.size() < kMinCorners) {
      reason = fmt::format("{} of its {} corners do not fit the other views", wild, all.points.size());
      continue;
    }
    agreeing.adjustment.views.push_back(std::move(noise));
    agreeing.numbers.push_back(placed.numbers[i]);
    agreeing.corners.push_back(std::move(corners));
  }
  return agreeing;
}

double CommonError(std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                   const Agreeing& a, std::size_t free) {
  std::vector<std::pair<double, double>> squares;  // of the error, and expected by the corner's own part
  for (std::size_t i = 0; i < a.numbers.size(); ++i) {
    const AdjustedView& view = a.adjustment.views[i];
    for (std::size_t j = 0; j < view.points.size(); ++j) {
      const auto error = PixelError(a.adjustment.camera, view.X_CT, view.points[j]);
      const Eigen::Matrix2d& own = views[usable[a.numbers[i]]].corners[a.corners[i][j]].covariance;
      if (error) squares.emplace_back(error->squaredNorm() / 2, own.trace() / 2);
    }
  }
  const double expected = (FreedomOf(a, free) - CostOf(a.adjustment.board)) / 2;
  const auto excess = [&](double common) {
    double sum = -expected;
    for (const auto& [square, own] : squares) sum += square / (own + common * common);
    return sum;
  };
  double low = 0, high = 100;
  if (!(excess(1e-6) > 0)) return 0;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (excess(middle) > 0 ? low : high) = middle;
  }
  return high;
}

PlacedViews AdjustRobustly(const CameraModel& start, const std::vector<int>& free,
                           const std::vector<std::vector<SeenPoint>>& points) {
  PlacedViews placed = PlaceViews(start, points);
  for (int round = 0; round < 3; ++round) {
    Adjust(placed.adjustment, {.free = free, .huber = 2.5 * RobustScale(placed.adjustment)});
    placed = PlaceViews(placed.adjustment.camera, points);  // once more, now that the camera is known better
  }
  return placed;
}

}  // namespace kestrel::vision
