// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/border/border_look.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vision/horizon/border/border_strip.h"

namespace kestrel::vision {

namespace {

constexpr int kRounds = 4;
constexpr int kBelow[kRounds] = {34, 26, 22, 18},
              kAbove[kRounds] = {34, 46, 46, 46};  // px, from round to round
constexpr int kGap[kRounds] = {3, 12, 6, 4};       // px on either side of the border that teach nothing
constexpr double kNearLine = 9;                    // px: hills
constexpr double kOnLine = 2.5;                    // px, about a third of a degree at 60 degrees of view

}  // namespace

std::optional<BorderLook> LookAtBorder(const PlaneView& plane, const cv::Mat& view, const SkyBorder& about,
                                       bool topmost) {
  BorderLook look;
  look.line = about;
  for (int round = 0; round < kRounds; ++round) {
    const int reach = kBelow[round];
    const Strip strip = ReadStrip(view, plane.shown(), look.line, reach, kAbove[round]);
    const bool of_sky = topmost && round > 0;
    const int n = strip.colour.rows, m = strip.colour.cols;
    std::vector<double> path(static_cast<std::size_t>(n), reach);
    for (int pass = 0; pass < 2; ++pass) {
      const std::vector<double> next = BorderPath(strip, reach, path, of_sky ? kGap[round] : kGap[0], of_sky);
      for (int i = 0; i < n; ++i)
        path[static_cast<std::size_t>(i)] =
            next[static_cast<std::size_t>(i)] < 0 ? reach : next[static_cast<std::size_t>(i)];
      if (pass == 1) path = next;
    }
    look.points.clear();
    int shown = 0;
    std::vector<double> contrasts, rough_above, rough_below, brighter, drifts;
    Eigen::Vector3d steps = Eigen::Vector3d::Zero();
    Eigen::Vector3d inner_sum = Eigen::Vector3d::Zero(), outer_sum = Eigen::Vector3d::Zero();
    double step_sum = 0;
    for (int i = 0; i < n; ++i) {
      if (path[static_cast<std::size_t>(i)] < 0) continue;
      ++shown;
      const int j = static_cast<int>(path[static_cast<std::size_t>(i)]);
      if (j < 4 || j > m - 4) continue;
      const auto* colour = strip.colour.ptr<cv::Vec3f>(i);
      const cv::Vec3f above = MeanColour(colour, std::min(m - 1, j + 1), std::min(m - 1, j + 3)),
                      below = MeanColour(colour, std::max(0, j - 4), j - 2);
      const cv::Vec3f across = above - below, middle = (above + below) * 0.5f;
      const float length2 = across.dot(across);
      double at = j - 0.5;
      if (length2 > 4) {
        double nearest = 1e9;
        float last = 0;
        for (int k = std::max(0, j - 3); k <= std::min(m - 1, j + 2); ++k) {
          const float v = (colour[k] - middle).dot(across) / length2;
          if (k > std::max(0, j - 3) && last < 0 && v >= 0) {
            const double here = k - 1 + static_cast<double>(last / (last - v));
            if (std::abs(here - j + 0.5) < nearest) nearest = std::abs(here - j + 0.5), at = here;
          }
          last = v;
        }
      }
      look.points.push_back(
          {strip.first + i * kStripSpacing, at - reach, static_cast<double>(std::sqrt(length2)), 0});
      contrasts.push_back(static_cast<double>(std::sqrt(length2)));
      const Eigen::Vector3d step(static_cast<double>(across[0]), static_cast<double>(across[1]),
                                 static_cast<double>(across[2]));
      steps += step, step_sum += step.norm();
      if (j >= 8 && j + 7 < m) {
        const cv::Vec3f inner = MeanColour(colour, j + 1, j + 2) - MeanColour(colour, j - 3, j - 2);
        const cv::Vec3f outer = MeanColour(colour, j + 5, j + 7) - MeanColour(colour, j - 8, j - 6);
        const auto add = [](Eigen::Vector3d& sum, const cv::Vec3f& c) {
          sum += Eigen::Vector3d(static_cast<double>(c[0]), static_cast<double>(c[1]),
                                 static_cast<double>(c[2]));
        };
        add(inner_sum, inner), add(outer_sum, outer);
      }
      const auto roughness = [&](int a, int b) {
        double sum = 0;
        int count = 0;
        for (int k = std::max(1, a); k <= std::min(m - 1, b); ++k) {
          const cv::Vec3f d = colour[k] - colour[k - 1];
          sum += static_cast<double>(std::abs(d[0] + 2 * d[1] + d[2]) / 4), ++count;
        }
        return count ? sum / count : 0.0;
      };
      if (j + 24 < m) {
        const cv::Vec3f drift =
            MeanColour(colour, j + 3, j + 8) - MeanColour(colour, j + 19, std::min(m - 1, j + 40));
        drifts.push_back(static_cast<double>(std::sqrt(drift.dot(drift))));
      }
      rough_above.push_back(roughness(j + 3, j + 14));
      rough_below.push_back(roughness(j - 14, j - 4));
      brighter.push_back((step[0] + 2 * step[1] + step[2]) / 4);
    }
    if (shown < kLeastStripColumns || look.points.size() < 12) return std::nullopt;
    // Robust line: Cauchy, from the median.
    Eigen::Vector2d x(0, 0);  // above = x0 + x1 * along
    {
      // Theil and Sen over pairs a third apart.
      std::vector<double> slopes;
      const std::size_t third = look.points.size() / 3;
      for (std::size_t a = 0; a + third < look.points.size(); ++a)
        for (std::size_t b = a + third; b < look.points.size(); b += 3)
          slopes.push_back((look.points[b].above - look.points[a].above) /
                           (look.points[b].along - look.points[a].along));
      std::nth_element(slopes.begin(), slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2),
                       slopes.end());
      x[1] = slopes[slopes.size() / 2];
      std::vector<double> levels;
      for (const BorderPoint& p : look.points) levels.push_back(p.above - x[1] * p.along);
      std::nth_element(levels.begin(), levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 2),
                       levels.end());
      x[0] = levels[levels.size() / 2];
    }
    for (int step = 0; step < 15; ++step) {
      Eigen::Matrix2d H = 1e-9 * Eigen::Matrix2d::Identity();
      Eigen::Vector2d g = Eigen::Vector2d::Zero();
      for (BorderPoint& p : look.points) {
        const double r = p.above - x[0] - x[1] * p.along;
        const double u = r / 1.5;
        p.weight = 1 / (1 + u * u);
        const Eigen::Vector2d row(1, p.along);
        H += p.weight * row * row.transpose();
        g += p.weight * p.above * row;
      }
      x = H.ldlt().solve(g);
    }
    double on = 0, near = 0, square = 0;
    for (BorderPoint& p : look.points) {
      p.above -= x[0] + x[1] * p.along;
      on += std::abs(p.above) < kOnLine;
      near += std::abs(p.above) < kNearLine;
      if (std::abs(p.above) < kOnLine) square += p.above * p.above;
    }
    look.shown = shown * kStripSpacing;
    look.found = static_cast<double>(look.points.size()) / shown;
    look.straight = on / shown;
    look.near = near / shown;
    look.scatter = on > 0 ? std::sqrt(square / on) : kOnLine;
    const auto median = [](std::vector<double>& v) {
      std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
      return v[v.size() / 2];
    };
    look.drift = drifts.empty() ? 0 : median(drifts);
    look.contrast = median(contrasts);
    look.sharp = inner_sum.norm() / std::max(1e-9, outer_sum.norm());
    look.steady = steps.norm() / std::max(1e-9, step_sum);
    look.rough_above = median(rough_above), look.rough_below = median(rough_below),
    look.brighter = median(brighter);
    // The new line, from the old one's frame.
    const Eigen::Vector2d middle((view.cols - 1) / 2.0, (view.rows - 1) / 2.0);
    const Eigen::Vector2d foot =
        middle + (look.line.offset - look.line.normal.dot(middle)) * look.line.normal;
    const Eigen::Vector2d along(-look.line.normal.y(), look.line.normal.x());
    const Eigen::Vector2d on_it = foot + x[0] * look.line.normal;
    const Eigen::Vector2d normal = (look.line.normal - x[1] * along).normalized();
    look.line = {normal, normal.dot(on_it)};
  }
  return look;
}

}  // namespace kestrel::vision
