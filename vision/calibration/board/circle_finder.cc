// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/circle_finder.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <optional>

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

constexpr double kMinDiscContrast = 20;
constexpr double kMinDiscRadius_px = 2.5;  // of a disc
constexpr double kOverRadius = 1.5;        // how far beyond a disc's radius is looked at, and white expected

struct SeenDisc {
  Vector2d pixel;
  double radius_px = 0, variance = 0;  // of the pixel along an axis, px^2
};

// The middle of the darkness within a distance. None: no disc is there.
std::optional<SeenDisc> MiddleOfDarkness(const cv::Mat& grey, const Vector2d& near, double within_px) {
  Vector2d at = near;
  SeenDisc disc;
  for (int pass = 0; pass < 4; ++pass) {
    const double reach = pass == 0 ? within_px : std::min(within_px, kOverRadius * disc.radius_px + 1);
    if (!(reach > 1) || !(at.x() - reach >= 0) || !(at.y() - reach >= 0) ||
        !(at.x() + reach <= grey.cols - 1) || !(at.y() + reach <= grey.rows - 1)) {
      return std::nullopt;
    }
    std::vector<double> rim;
    double black = 255;
    const auto each = [&](auto&& use) {
      for (int v = static_cast<int>(std::ceil(at.y() - reach)); v <= at.y() + reach; ++v) {
        for (int u = static_cast<int>(std::ceil(at.x() - reach)); u <= at.x() + reach; ++u) {
          const double distance = std::hypot(u - at.x(), v - at.y());
          if (distance <= reach) use(Vector2d(u, v), distance, double(grey.at<std::uint8_t>(v, u)));
        }
      }
    };
    each([&](const Vector2d&, double distance, double value) {
      if (distance > reach - 1) rim.push_back(value);
      black = std::min(black, value);
    });
    if (rim.empty()) return std::nullopt;
    std::nth_element(rim.begin(), rim.begin() + static_cast<std::ptrdiff_t>(rim.size() / 2), rim.end());
    const double white = rim[rim.size() / 2];
    if (!(white - black > kMinDiscContrast)) return std::nullopt;
    double noise = 0;
    for (const double value : rim) noise += std::abs(value - white) / static_cast<double>(rim.size());
    // What is nearly white is noise, of which far pixels would make much.
    const double floor = std::min(0.3 * (white - black), 3 * noise + 2);
    double sum = 0, square = 0;
    Vector2d first = Vector2d::Zero();
    each([&](const Vector2d& uv, double, double value) {
      const double dark = white - value > floor ? white - value : 0;
      sum += dark, first += dark * uv, square += (uv - at).squaredNorm();
    });
    at = first / sum;
    disc = {at, std::sqrt(sum / (white - black) / std::numbers::pi),
            std::pow(std::max(noise, 0.5), 2) * square / 2 / (sum * sum)};
    if (!((at - near).norm() < within_px / 2) || !(disc.radius_px > kMinDiscRadius_px)) return std::nullopt;
  }
  return disc;
}

// A detector of dark blobs of any size that a grid may have in the image.
cv::Ptr<cv::FeatureDetector> BlobDetector(const cv::Mat& grey) {
  cv::SimpleBlobDetector::Params parameters;
  parameters.minArea = static_cast<float>(std::numbers::pi * kMinDiscRadius_px * kMinDiscRadius_px);
  parameters.maxArea = static_cast<float>(grey.total()) / 30;
  parameters.minDistBetweenBlobs = 2 * kMinDiscRadius_px;
  parameters.minConvexity = 0.8F;
  parameters.minInertiaRatio = 0.05F;
  return cv::SimpleBlobDetector::create(parameters);
}

struct ExpectedDisc {
  Vector2d shift;       // from the image of the disc's middle to the middle of its image, px
  double px_per_m = 0;  // square root of how much larger its image is than it
};

std::optional<ExpectedDisc> ExpectDisc(const CircleGrid& board, const Vector2d& place,
                                       const CameraModel& camera, const Pose& X_CT) {
  constexpr int kRings = 5, kAngles = 16;
  const auto middle = Project(camera, X_CT * Eigen::Vector3d(place.x(), place.y(), 0));
  if (!middle) return std::nullopt;
  const Eigen::Matrix<double, 3, 2> axes = X_CT.R.toRotationMatrix().leftCols<2>();
  Vector2d sum = Vector2d::Zero();
  double area = 0;
  for (int ring = 0; ring < kRings; ++ring) {
    const double radius = board.diameter_m / 2 * std::sqrt((ring + 0.5) / kRings);  // rings of one area
    for (int i = 0; i < kAngles; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAngles;
      const Eigen::Vector3d p_CQ = X_CT * Eigen::Vector3d(place.x() + radius * std::cos(angle),
                                                          place.y() + radius * std::sin(angle), 0);
      Eigen::Matrix<double, 2, 3> d_point;
      const auto uv = Project(camera, p_CQ, &d_point);
      if (!uv) return std::nullopt;
      const double share = std::abs((d_point * axes).determinant());
      sum += share * *uv, area += share;
    }
  }
  return ExpectedDisc{sum / area - *middle, std::sqrt(area / (kRings * kAngles))};
}

// Each disc that is seen, by its index, as it is and as it was to be expected.
template <typename Use>
void EachDisc(const cv::Mat& grey, const CircleGrid& board, std::span<const BoardCorner> corners,
              const CameraModel& camera, const Pose& X_CT, Use&& use) {
  const std::vector<Vector2d> places = Corners(board);
  for (const BoardCorner& corner : corners) {
    const auto expected = ExpectDisc(board, places[static_cast<std::size_t>(corner.index)], camera, X_CT);
    double nearest = std::numeric_limits<double>::infinity();
    for (const BoardCorner& other : corners) {
      if (other.index != corner.index) nearest = std::min(nearest, (other.pixel - corner.pixel).norm());
    }
    const auto disc = expected ? MiddleOfDarkness(grey, corner.pixel, nearest / 2) : std::nullopt;
    if (disc) use(corner.index, *disc, *expected);
  }
}

// Reverses the order of rows, or of all.
void Reverse(std::vector<cv::Point2f>& points, int cols, int rows, bool rows_alone) {
  std::reverse(points.begin(), points.end());
  for (int r = 0; rows_alone && r < rows; ++r)
    std::reverse(points.begin() + r * cols, points.begin() + (r + 1) * cols);
}

}  // namespace

std::vector<BoardCorner> FindCircleGrid(const cv::Mat& grey, const CircleGrid& board) {
  const int grid = board.asymmetric ? cv::CALIB_CB_ASYMMETRIC_GRID : cv::CALIB_CB_SYMMETRIC_GRID;
  const cv::Size size(board.cols, board.rows);
  std::vector<cv::Point2f> points;
  if (!cv::findCirclesGrid(grey, size, points, grid, BlobDetector(grey)) &&
      !cv::findCirclesGrid(grey, size, points, grid | cv::CALIB_CB_CLUSTERING, BlobDetector(grey))) {
    return {};
  }
  const auto at = [&](int c, int r) {
    const cv::Point2f& p = points[static_cast<std::size_t>(r * board.cols + c)];
    return Vector2d(p.x, p.y);
  };
  // Rows of the image count downwards, those of the board upwards.
  const Vector2d right = at(board.cols - 1, 0) - at(0, 0), up = at(0, board.rows - 1) - at(0, 0);
  if (right.x() * up.y() - right.y() * up.x() > 0) {
    if (board.asymmetric && board.rows % 2 == 0) return {};  // its mirror image is another grid
    Reverse(points, board.cols, board.rows, true);
  }
  std::vector<BoardCorner> corners;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector2d near(points[i].x, points[i].y);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (j != i) nearest = std::min(nearest, (Vector2d(points[j].x, points[j].y) - near).norm());
    }
    const auto disc = MiddleOfDarkness(grey, near, nearest / 2);
    if (!disc) continue;
    corners.push_back({static_cast<int>(i), disc->pixel, disc->variance * Eigen::Matrix2d::Identity()});
  }
  return corners;
}

std::vector<BoardCorner> RefitCircleGrid(const cv::Mat& grey, const CircleGrid& board,
                                         std::span<const BoardCorner> corners, const CameraModel& camera,
                                         const Pose& X_CT) {
  std::vector<BoardCorner> refitted;
  EachDisc(
      grey, board, corners, camera, X_CT, [&](int index, const SeenDisc& disc, const ExpectedDisc& expected) {
        refitted.push_back({index, disc.pixel - expected.shift, disc.variance * Eigen::Matrix2d::Identity()});
      });
  return refitted;
}

std::vector<double> SeenDiameters_m(const cv::Mat& grey, const CircleGrid& board,
                                    std::span<const BoardCorner> corners, const CameraModel& camera,
                                    const Pose& X_CT) {
  std::vector<double> diameters_m;
  EachDisc(grey, board, corners, camera, X_CT, [&](int, const SeenDisc& disc, const ExpectedDisc& expected) {
    diameters_m.push_back(2 * disc.radius_px / expected.px_per_m);
  });
  return diameters_m;
}

}  // namespace kestrel::vision
