// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/patch/match_corners.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kestrel::vision {
namespace {

constexpr int kHalf_px = 6, kSide_px = 2 * kHalf_px + 1;
constexpr int kRow = 16;                 // numbers in a row: whole registers
constexpr int kDrawn_px = kSide_px + 2;  // with the neighbours that gradients take
constexpr int kMaxSteps = 12;
constexpr double kLastStep_px = 0.01;
constexpr double kMaxShift_px = kHalf_px;
constexpr int kMinPixels = kSide_px * kSide_px / 2;
// Of the gradient's mean square along the direction in which it is least: what Lucas-Kanade can hold on to.
constexpr float kMinGradient2 = 1;

// A number for each pixel of a patch; those beyond its width are 0.
using Plane = std::array<float, kSide_px * kRow>;

float Bilinear(const uchar* p, std::ptrdiff_t stride, float fu, float fv) {
  const float a = p[0], b = p[1], c = p[stride], d = p[stride + 1];
  const float upper = a + fu * (b - a), lower = c + fu * (d - c);
  return upper + fv * (lower - upper);
}

// With the outermost pixels repeated beyond the rim.
float AtRim(const cv::Mat& image, float u, float v) {
  u = std::clamp(u, 0.0f, static_cast<float>(image.cols - 1));
  v = std::clamp(v, 0.0f, static_cast<float>(image.rows - 1));
  const int iu = std::min(static_cast<int>(u), image.cols - 2),
            iv = std::min(static_cast<int>(v), image.rows - 2);
  return Bilinear(image.ptr(iv) + iu, static_cast<std::ptrdiff_t>(image.step), u - static_cast<float>(iu),
                  v - static_cast<float>(iv));
}

// The patch of an image about a point.
void Cut(const cv::Mat& image, double u, double v, Plane& patch) {
  const double left = u - kHalf_px, top = v - kHalf_px;
  const double floor_u = std::floor(left), floor_v = std::floor(top);
  const float fu = static_cast<float>(left - floor_u), fv = static_cast<float>(top - floor_v);
  const bool inside = left >= 0 && top >= 0 && floor_u + kRow < image.cols && floor_v + kSide_px < image.rows;
  if (!inside) {
    for (int y = 0; y < kSide_px; ++y)
      for (int x = 0; x < kSide_px; ++x)
        patch[static_cast<std::size_t>(y * kRow + x)] =
            AtRim(image, static_cast<float>(left + x), static_cast<float>(top + y));
    return;
  }
  const int iu = static_cast<int>(floor_u), iv = static_cast<int>(floor_v);
  std::array<float, kRow> above, below;
  const auto across = [&](int y, std::array<float, kRow>& row) {
    const uchar* p = image.ptr(iv + y) + iu;
    for (int x = 0; x < kRow; ++x) {
      const float a = p[x], b = p[x + 1];
      row[static_cast<std::size_t>(x)] = a + fu * (b - a);
    }
  };
  across(0, above);
  for (int y = 0; y < kSide_px; ++y) {
    across(y + 1, below);
    float* to = patch.data() + y * kRow;
    for (std::size_t x = 0; x < kRow; ++x) to[x] = above[x] + fv * (below[x] - above[x]);
    std::swap(above, below);
  }
}

float Sum(const Plane& values) {
  std::array<float, kRow> columns{};
  for (int y = 0; y < kSide_px; ++y)
    for (std::size_t x = 0; x < kRow; ++x) columns[x] += values[static_cast<std::size_t>(y) * kRow + x];
  float sum = 0;
  for (const float column : columns) sum += column;
  return sum;
}

float SumOfProducts(const Plane& a, const Plane& b) {
  std::array<float, kRow> columns{};
  for (int y = 0; y < kSide_px; ++y)
    for (std::size_t x = 0; x < kRow; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * kRow + x;
      columns[x] += a[i] * b[i];
    }
  float sum = 0;
  for (const float column : columns) sum += column;
  return sum;
}

// The picture about a corner, as the image would show it.
struct Drawn {
  Plane grey{}, by_u{}, by_v{};  // gradients by px of the image; all three 0 where nothing is known
  Plane known{};                 // 1 or 0
};

// Less than half a patch known: none.
bool Draw(const cv::Mat& picture, const Eigen::Matrix3d& picture_from_image, const cv::Size& image,
          const Eigen::Vector2d& corner, const Exposure& exposure, float around, Drawn& drawn) {
  const Eigen::Vector3f step = picture_from_image.col(0).cast<float>();
  const Eigen::Vector2d first = corner.array() - (kHalf_px + 1);
  const float right = static_cast<float>(picture.cols - 1), bottom = static_cast<float>(picture.rows - 1);
  const float gain = static_cast<float>(exposure.gain), offset = static_cast<float>(exposure.offset);
  const auto stride = static_cast<std::ptrdiff_t>(picture.step);
  std::array<float, kDrawn_px * kRow> grey{};
  for (int y = 0; y < kDrawn_px; ++y) {
    const Eigen::Vector3f at =
        (picture_from_image * Eigen::Vector3d(first.x(), first.y() + y, 1)).cast<float>();
    std::array<float, kRow> u, v;
    bool inside = true;
    for (std::size_t x = 0; x < kRow; ++x) {
      const float fx = static_cast<float>(x), scale = 1 / (at.z() + fx * step.z());
      u[x] = (at.x() + fx * step.x()) * scale;
      v[x] = (at.y() + fx * step.y()) * scale;
      inside &= (u[x] >= 0) & (v[x] >= 0) & (u[x] < right) & (v[x] < bottom);
    }
    float* row = grey.data() + y * kRow;
    for (std::size_t x = 0; x < kDrawn_px; ++x) {
      float of_picture = 0;
      if (inside) {
        const int iu = static_cast<int>(u[x]), iv = static_cast<int>(v[x]);
        of_picture = Bilinear(picture.data + iv * stride + iu, stride, u[x] - static_cast<float>(iu),
                              v[x] - static_cast<float>(iv));
      } else if (!(u[x] >= -0.5f && v[x] >= -0.5f && u[x] <= right + 0.5f && v[x] <= bottom + 0.5f)) {
        row[x] = around;  // half a pixel of the rim is still of the outermost pixel
        continue;
      } else {
        of_picture = AtRim(picture, u[x], v[x]);
      }
      row[x] = std::clamp(gain * of_picture + offset, 0.0f, 255.0f);  // as far as the sensor's greys go
    }
  }
  int pixels = 0;
  for (int y = 0; y < kSide_px; ++y) {
    const double v = corner.y() - kHalf_px + y;
    if (v < 0 || v > image.height - 1) continue;
    for (int x = 0; x < kSide_px; ++x) {
      const double u = corner.x() - kHalf_px + x;
      if (u < 0 || u > image.width - 1) continue;
      const std::size_t i = static_cast<std::size_t>((y + 1) * kRow + x + 1),
                        to = static_cast<std::size_t>(y * kRow + x);
      ++pixels;
      drawn.known[to] = 1;
      drawn.grey[to] = grey[i];
      drawn.by_u[to] = 0.5f * (grey[i + 1] - grey[i - 1]);
      drawn.by_v[to] = 0.5f * (grey[i + kRow] - grey[i - kRow]);
    }
  }
  return pixels >= kMinPixels;
}

GreySums SumsOf(const Drawn& drawn, const Plane& seen) {
  return {Sum(drawn.known),
          Sum(drawn.grey),
          SumOfProducts(drawn.known, seen),
          SumOfProducts(drawn.grey, drawn.grey),
          SumOfProducts(seen, seen),
          SumOfProducts(drawn.grey, seen)};
}

CornerMatch ShiftOnto(const cv::Mat& image, const Eigen::Vector2d& corner, const Drawn& drawn) {
  CornerMatch match{false, corner, {}};
  const float uu = SumOfProducts(drawn.by_u, drawn.by_u), uv = SumOfProducts(drawn.by_u, drawn.by_v),
              vv = SumOfProducts(drawn.by_v, drawn.by_v), n = Sum(drawn.known);
  const float determinant = uu * vv - uv * uv;
  const float least = (uu + vv - std::sqrt((uu - vv) * (uu - vv) + 4 * uv * uv)) / 2;
  if (!(least > kMinGradient2 * n) || !(determinant > 0)) return match;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  // At the rim of the image only the patch itself is cut: what lies beyond its width must be numbers all the same.
  Plane seen{}, difference;
  for (int step = 0; step < kMaxSteps; ++step) {
    Cut(image, corner.x() + shift.x(), corner.y() + shift.y(), seen);
    for (std::size_t i = 0; i < seen.size(); ++i) difference[i] = seen[i] - drawn.grey[i];
    const float bu = SumOfProducts(drawn.by_u, difference), bv = SumOfProducts(drawn.by_v, difference);
    const Eigen::Vector2d move(-(vv * bu - uv * bv) / determinant, -(uu * bv - uv * bu) / determinant);
    shift += move;
    if (!(shift.cwiseAbs().maxCoeff() < kMaxShift_px)) return match;
    if (move.squaredNorm() < kLastStep_px * kLastStep_px) break;
  }
  match.found = true;
  match.at = corner + shift;
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i] *= drawn.known[i];
  match.greys = SumsOf(drawn, seen);
  return match;
}

}  // namespace

GreySums& GreySums::operator+=(const GreySums& o) {
  n += o.n, x += o.x, y += o.y, xx += o.xx, yy += o.yy, xy += o.xy;
  return *this;
}

double GreySums::Correlation() const {
  if (!(n > 0)) return 0;
  const double variance = (xx - x * x / n) * (yy - y * y / n);
  return variance > 0 ? (xy - x * y / n) / std::sqrt(variance) : 0;
}

std::vector<CornerMatch> MatchCorners(const cv::Mat& picture, const Eigen::Matrix3d& picture_from_image,
                                      const cv::Mat& image, std::span<const Eigen::Vector2d> predicted,
                                      const Exposure& exposure, double around) {
  std::vector<CornerMatch> matches;
  matches.reserve(predicted.size());
  for (const Eigen::Vector2d& corner : predicted) {
    Drawn drawn;
    CornerMatch match{false, corner, {}};
    // Between the pixels of the image is interpolated, which blurs it; the less, the smaller the shift of a patch that
    // is drawn at whole pixels.
    const Eigen::Vector2d pixel = corner.array().round();
    if (Draw(picture, picture_from_image, image.size(), pixel, exposure, static_cast<float>(around), drawn)) {
      match = ShiftOnto(image, pixel, drawn);
      match.at += corner - pixel;
    }
    matches.push_back(match);
  }
  return matches;
}

}  // namespace kestrel::vision
