// SPDX-License-Identifier: Apache-2.0
#include "vision/skyline_profile.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace kestrel {

namespace {

constexpr int kSectors = 16;
constexpr float kMost = 3;       // nats that one sample may say: clouds and windows are no proof
constexpr float kLeastGain = 4;  // nats of a step
constexpr float kNoise2 = 3;     // of the sensor and of the quantisation, grey levels squared

struct Body {
  float n = 0;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f square = Eigen::Matrix3f::Zero();

  void Add(const cv::Vec3f& c) {
    const Eigen::Vector3f x(c[0], c[1], c[2]);
    n += 1;
    sum += x;
    square += x * x.transpose();
  }
  void Add(const Body& o, float share) {
    n += share * o.n;
    sum += share * o.sum;
    square += share * o.square;
  }
  Eigen::Vector3f Mean() const { return sum / std::max(n, 1e-3f); }
  Eigen::Matrix3f Scatter() const {  // n times the covariance
    return square - sum * sum.transpose() / std::max(n, 1e-3f);
  }
};

// Log of the odds that a colour is sky: linear, for two bodies that scatter alike (Fisher 1936).
struct Judge {
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();
  float offset = 0, high = 0;  // high: the odds of the mean of the sky
  bool knows = false;
  float Odds(const cv::Vec3f& c) const {
    return direction[0] * c[0] + direction[1] * c[1] + direction[2] * c[2] - offset;
  }
};

Judge Learn(const Body& sky, const Body& ground) {
  Judge judge;
  if (sky.n < 12 || ground.n < 12) return judge;
  const Eigen::Vector3f apart = sky.Mean() - ground.Mean();
  Eigen::Matrix3f within = (sky.Scatter() + ground.Scatter()) / (sky.n + ground.n);
  within.diagonal().array() += kNoise2;
  judge.direction = within.ldlt().solve(apart);
  judge.offset = judge.direction.dot(sky.Mean() + ground.Mean()) / 2;
  judge.high = judge.direction.dot(apart) / 2;
  judge.knows = judge.high > 0.1f;
  return judge;
}

using Sectors = std::array<std::array<Body, 2>, kSectors>;

Sectors Gather(const BandSamples& band, const BandGrid& grid, const std::vector<double>& contour,
               const ProfileOptions& o) {
  Sectors sectors;
  const int gap = std::max(1, static_cast<int>(std::lround(o.gap / grid.step)));
  const int reach = std::max(gap + 2, static_cast<int>(std::lround(o.reach / grid.step)));
  for (int i = 0; i < grid.azimuths; ++i) {
    const auto* colour = band.colour.ptr<cv::Vec3f>(i);
    const auto* shown = band.shown.ptr<uchar>(i);
    auto& [sky, ground] = sectors[static_cast<std::size_t>(i * kSectors / grid.azimuths)];
    const int middle =
        static_cast<int>(std::lround((contour[static_cast<std::size_t>(i)] - grid.lowest) / grid.step));
    for (int j = std::max(0, middle - reach); j <= std::min(grid.elevations - 1, middle + reach); ++j) {
      if (!shown[j]) continue;
      if (j >= middle + gap) sky.Add(colour[j]);
      if (j <= middle - gap) ground.Add(colour[j]);
    }
  }
  return sectors;
}

ProfilePoint Judged(const cv::Vec3f* colour, const uchar* shown, const BandGrid& grid, const Judge& judge,
                    std::vector<float>& odds) {
  ProfilePoint point;
  int first = -1, last = -1, seen = 0;
  for (int j = 0; j < grid.elevations; ++j)
    if (shown[j]) {
      if (first < 0) first = j;
      last = j;
      ++seen;
    }
  point.shown = seen > grid.elevations / 2 && seen == last - first + 1;
  if (!point.shown || !judge.knows) return point;
  float total = 0;
  for (int j = first; j <= last; ++j) {
    odds[static_cast<std::size_t>(j)] = judge.Odds(colour[j]);
    total += std::clamp(odds[static_cast<std::size_t>(j)], -kMost, kMost);
  }
  // The sum of the odds above the step less that below it, by a running sum.
  float best = total, value = total;
  int step = first;  // the lowest sample that is sky
  for (int j = first; j <= last; ++j) {
    value -= 2 * std::clamp(odds[static_cast<std::size_t>(j)], -kMost, kMost);
    if (value > best) best = value, step = j + 1;
  }
  point.gain = static_cast<double>(best - std::abs(total)) / 2;
  if (step <= first || step > last || point.gain < kLeastGain) return point;
  const float above = odds[static_cast<std::size_t>(step)], below = odds[static_cast<std::size_t>(step - 1)];
  const float part = above > 0 && below < 0 ? below / (below - above) : 0.5f;
  point.found = true;
  // From the step to where the odds are those of the middle half of either body.
  int up = step, down = step - 1;
  const float sky = judge.high / 2, ground = -judge.high / 2;
  while (up < last && odds[static_cast<std::size_t>(up)] < sky) ++up;
  while (down > first && odds[static_cast<std::size_t>(down)] > ground) --down;
  point.blur = (up - down) * grid.step;
  point.elevation = grid.Elevation(step - 1) + static_cast<double>(part) * grid.step;
  return point;
}

}  // namespace

std::vector<ProfilePoint> FindContour(const BandSamples& band, const BandGrid& grid,
                                      const std::vector<double>& contour, const ProfileOptions& options) {
  std::vector<double> now = contour;
  std::vector<ProfilePoint> points(static_cast<std::size_t>(grid.azimuths));
  std::vector<float> odds(static_cast<std::size_t>(grid.elevations));
  for (int pass = 0; pass < options.passes; ++pass) {
    const Sectors sectors = Gather(band, grid, now, options);
    std::array<Judge, kSectors> judges;
    for (int s = 0; s < kSectors; ++s) {
      std::array<Body, 2> wide;
      for (int d = -1; d <= 1; ++d)
        for (std::size_t k = 0; k < 2; ++k)
          wide[k].Add(sectors[static_cast<std::size_t>((s + d + kSectors) % kSectors)][k], d ? 0.5f : 1.0f);
      judges[static_cast<std::size_t>(s)] = Learn(wide[0], wide[1]);
    }
    for (int i = 0; i < grid.azimuths; ++i) {
      auto& point = points[static_cast<std::size_t>(i)];
      point = Judged(band.colour.ptr<cv::Vec3f>(i), band.shown.ptr<uchar>(i), grid,
                     judges[static_cast<std::size_t>(i * kSectors / grid.azimuths)], odds);
      if (point.found) now[static_cast<std::size_t>(i)] = point.elevation;
    }
  }
  return points;
}

}  // namespace kestrel
