// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/border/border_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "geometry/tait_bryan.h"

namespace kestrel::vision {

namespace {

constexpr int kCellPx = 4;
constexpr double kTurn = Radians(3);   // between the lines tried
constexpr double kLeastShare = 0.015;  // of the cells on either side
constexpr double kEdgeScale = 6;       // grey levels from cell to cell: a plain edge
constexpr double kEdgeWeight = 1.6, kVoteWeight = 0.25;
constexpr double kMostGain = 3;
constexpr double kApartTurn = Radians(7), kApartOffset = 4;  // between candidates; cells

// Sums over cells: 1; blue, green, red, roughness; their products; the grey's slope, squashed.
using Sums = Eigen::Array<float, 20, 1>;
constexpr int kSlope = 15;

struct Cells {
  std::vector<Eigen::Vector2f> places;  // cells
  std::vector<Sums> sums;
  int columns = 0, rows = 0;
};

Cells CellsOf(const cv::Mat& view, const cv::Mat& shown) {
  Cells out;
  out.columns = view.cols / kCellPx, out.rows = view.rows / kCellPx;
  cv::Mat mean(out.rows, out.columns, CV_32FC3), rough(out.rows, out.columns, CV_32FC1);
  cv::Mat whole(out.rows, out.columns, CV_8UC1);
  for (int r = 0; r < out.rows; ++r)
    for (int c = 0; c < out.columns; ++c) {
      const cv::Rect place(c * kCellPx, r * kCellPx, kCellPx, kCellPx);
      whole.at<uchar>(r, c) = cv::countNonZero(shown(place)) == kCellPx * kCellPx;
      float sum[3] = {0, 0, 0}, grey_sum = 0, square = 0;
      for (int y = 0; y < kCellPx; ++y) {
        const uchar* p = view.ptr<uchar>(place.y + y) + 3 * place.x;
        for (int x = 0; x < kCellPx; ++x, p += 3) {
          for (int k = 0; k < 3; ++k) sum[k] += p[k];
          const float grey = static_cast<float>(p[0] + 2 * p[1] + p[2]) / 4;
          grey_sum += grey, square += grey * grey;
        }
      }
      constexpr float n = kCellPx * kCellPx;
      mean.at<cv::Vec3f>(r, c) = {sum[0] / n, sum[1] / n, sum[2] / n};
      rough.at<float>(r, c) = 0.5f * std::log(1 + std::max(0.0f, square / n - grey_sum * grey_sum / n / n));
    }
  cv::Mat smooth;
  cv::GaussianBlur(mean, smooth, {3, 3}, 0);
  for (int r = 1; r + 1 < out.rows; ++r)
    for (int c = 1; c + 1 < out.columns; ++c) {
      if (!whole.at<uchar>(r, c)) continue;
      Sums s = Sums::Zero();
      const cv::Vec3f& colour = mean.at<cv::Vec3f>(r, c);
      const float f[4] = {colour[0], colour[1], colour[2], rough.at<float>(r, c)};
      s[0] = 1;
      int at = 5;
      for (int a = 0; a < 4; ++a) {
        s[1 + a] = f[a];
        for (int b = a; b < 4; ++b, ++at) s[at] = f[a] * f[b];
      }
      if (whole.at<uchar>(r - 1, c) && whole.at<uchar>(r + 1, c) && whole.at<uchar>(r, c - 1) &&
          whole.at<uchar>(r, c + 1)) {
        const auto grey = [&](int y, int x) {
          const cv::Vec3f& v = smooth.at<cv::Vec3f>(y, x);
          return (v[0] + 2 * v[1] + v[2]) / 4;
        };
        const Eigen::Vector2f slope((grey(r, c + 1) - grey(r, c - 1)) / 2,
                                    (grey(r + 1, c) - grey(r - 1, c)) / 2);
        const float size = slope.norm();
        const Eigen::Vector2f squashed =
            slope * (size > 0 ? std::tanh(size / static_cast<float>(kEdgeScale)) / size : 0.0f);
        s[kSlope] = squashed.x(), s[kSlope + 1] = squashed.y();
      }
      out.places.emplace_back(static_cast<float>(c), static_cast<float>(r));
      out.sums.push_back(s);
    }
  return out;
}

double LogRootDeterminant(const Sums& m, Eigen::Vector4d* mean_out) {
  const double n = m[0];
  Eigen::Vector4d mean;
  for (int k = 0; k < 4; ++k) mean[k] = static_cast<double>(m[1 + k]) / n;
  Eigen::Matrix4d S;
  int at = 5;
  for (int a = 0; a < 4; ++a)
    for (int b = a; b < 4; ++b, ++at) S(a, b) = S(b, a) = static_cast<double>(m[at]) / n - mean[a] * mean[b];
  S.diagonal() += Eigen::Vector4d(9, 9, 9, 0.03);
  if (mean_out) *mean_out = mean;
  return S.llt().matrixLLT().diagonal().array().log().sum();
}

}  // namespace

std::vector<BorderCandidate> SearchBorders(const cv::Mat& view, const cv::Mat& shown,
                                           const Eigen::Vector2d& up, double reach, std::size_t most) {
  const Cells cells = CellsOf(view, shown);
  const auto n = static_cast<double>(cells.places.size());
  std::vector<BorderCandidate> all;
  if (n < 100) return all;
  const int half = static_cast<int>(std::ceil(std::hypot(cells.columns, cells.rows))) + 2,
            bins = 2 * half + 1;
  const double first = std::atan2(up.y(), up.x());
  std::vector<Sums> at(static_cast<std::size_t>(bins));
  Sums total = Sums::Zero();
  for (const Sums& s : cells.sums) total += s;
  const double whole = LogRootDeterminant(total, nullptr);
  const int turns = std::max(0, static_cast<int>(reach / kTurn));
  for (int turn = -turns; turn <= turns; ++turn) {
    const double angle = first + turn * kTurn;
    const Eigen::Vector2f normal(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
    std::fill(at.begin(), at.end(), Sums::Zero());
    for (std::size_t i = 0; i < cells.places.size(); ++i)
      at[static_cast<std::size_t>(std::lround(normal.dot(cells.places[i])) + half)] += cells.sums[i];
    Sums below = Sums::Zero();
    for (int k = 1; k + 1 < bins; ++k) {
      const auto here = static_cast<std::size_t>(k);
      below += at[here - 1];
      // The line runs between bins k - 1 and k; their cells straddle it.
      const Sums straddle = at[here - 1] + at[here];
      const Sums ground = below - at[here - 1], sky = total - below - at[here];
      if (ground[0] < kLeastShare * n || sky[0] < kLeastShare * n || straddle[0] < 8) continue;
      Eigen::Vector4d above_mean, below_mean;
      const double gain = whole - (LogRootDeterminant(sky, &above_mean) * sky[0] +
                                   LogRootDeterminant(ground, &below_mean) * ground[0]) /
                                      (sky[0] + ground[0]);
      const double edge =
          static_cast<double>(normal.x() * straddle[kSlope] + normal.y() * straddle[kSlope + 1]) /
          static_cast<double>(straddle[0]);
      const double smoother = below_mean[3] - above_mean[3];
      const double brighter = (above_mean.head<3>().sum() - below_mean.head<3>().sum()) / 3 / 40;
      const double bluer = ((above_mean[0] - above_mean[2]) - (below_mean[0] - below_mean[2])) / 30;
      const double vote = std::tanh(smoother) + 0.6 * std::tanh(brighter) + 0.6 * std::tanh(bluer);
      BorderCandidate candidate;
      candidate.line.normal = normal.cast<double>();
      // From cells to pixels.
      const double centre = (kCellPx - 1) / 2.0;
      candidate.line.offset = kCellPx * (k - half - 0.5) + centre * (candidate.line.normal.sum());
      candidate.score =
          std::min(kMostGain, gain) + kVoteWeight * vote + kEdgeWeight * (edge > 0 ? edge : -0.7 * edge);
      all.push_back(candidate);
    }
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  std::vector<BorderCandidate> out;
  const Eigen::Vector2d middle(view.cols / 2.0, view.rows / 2.0);
  for (const BorderCandidate& c : all) {
    if (out.size() >= most) break;
    const bool near = std::any_of(out.begin(), out.end(), [&](const BorderCandidate& o) {
      return o.line.normal.dot(c.line.normal) > std::cos(kApartTurn) &&
             std::abs((o.line.offset - o.line.normal.dot(middle)) -
                      (c.line.offset - c.line.normal.dot(middle))) < kApartOffset * kCellPx;
    });
    if (!near) out.push_back(c);
  }
  return out;
}

BorderSides SidesOf(const cv::Mat& view, const cv::Mat& shown, const SkyBorder& line) {
  const Cells cells = CellsOf(view, shown);
  Sums above = Sums::Zero(), below = Sums::Zero();
  const double centre = (kCellPx - 1) / 2.0;
  for (std::size_t i = 0; i < cells.places.size(); ++i) {
    const double height =
        line.normal.dot(kCellPx * cells.places[i].cast<double>() + Eigen::Vector2d(centre, centre)) -
        line.offset;
    if (std::abs(height) > kCellPx) (height > 0 ? above : below) += cells.sums[i];
  }
  BorderSides out;
  const double n = std::max(1.0, static_cast<double>(cells.places.size()));
  out.share_above = static_cast<double>(above[0]) / n, out.share_below = static_cast<double>(below[0]) / n;
  if (above[0] < 1 || below[0] < 1) return out;
  Eigen::Vector4d a, b;
  const double whole = LogRootDeterminant(above + below, nullptr);
  out.gain = whole - (LogRootDeterminant(above, &a) * static_cast<double>(above[0]) +
                      LogRootDeterminant(below, &b) * static_cast<double>(below[0])) /
                         static_cast<double>(above[0] + below[0]);
  out.rough_above = a[3], out.rough_below = b[3];
  out.bright_above = (a[0] + 2 * a[1] + a[2]) / 4, out.bright_below = (b[0] + 2 * b[1] + b[2]) / 4;
  out.blue_above = a[0] - a[2], out.blue_below = b[0] - b[2];
  out.green_above = a[1] - (a[0] + a[2]) / 2, out.green_below = b[1] - (b[0] + b[2]) / 2;
  return out;
}

}  // namespace kestrel::vision
