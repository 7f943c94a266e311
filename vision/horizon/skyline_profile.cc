// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/skyline_profile.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace kestrel::vision {

namespace {

constexpr int kSectors = 16;
constexpr float kMax = 3;            // nats that one sample may say: clouds and windows are no proof
constexpr float kMinGain = 4;        // nats of a step
constexpr float kMinApart = 0.08f;   // Bhattacharyya's distance of two bodies
constexpr float kSkyReach2 = 9;      // squared distance from the sky's mean, in its scatter
constexpr float kElsewhere = 0.08f;  // weight of the other sectors
constexpr float kNoise2 = 3;         // of the sensor and of the quantisation, grey levels squared

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

// Log of the odds that a colour is sky: two normal distributions, each with its own scatter. Sky is compact:
// what is far from it is no sky, whatever the ground is like.
struct Judge {
  Eigen::Vector3f sky = Eigen::Vector3f::Zero(), ground = Eigen::Vector3f::Zero();
  Eigen::Matrix3f sky_root = Eigen::Matrix3f::Zero(), ground_root = Eigen::Matrix3f::Zero();
  float offset = 0;
  bool knows = false;

  float SkyDistance2(const cv::Vec3f& c) const {
    return (sky_root * (Eigen::Vector3f(c[0], c[1], c[2]) - sky)).squaredNorm();
  }
  float Odds(const cv::Vec3f& c) const {
    const Eigen::Vector3f x(c[0], c[1], c[2]);
    return 0.5f * ((ground_root * (x - ground)).squaredNorm() - (sky_root * (x - sky)).squaredNorm()) +
           offset;
  }
};

// The inverse of the lower Cholesky factor: whitens.
Eigen::Matrix3f Whitener(const Eigen::Matrix3f& covariance, float& log_root_determinant) {
  const Eigen::LLT<Eigen::Matrix3f> llt(covariance);
  const Eigen::Matrix3f L = llt.matrixL();
  log_root_determinant = L.diagonal().array().log().sum();
  return L.inverse();
}

Judge Learn(const Body& sky, const Body& ground) {
  Judge judge;
  if (sky.n < 12 || ground.n < 12) return judge;
  judge.sky = sky.Mean(), judge.ground = ground.Mean();
  Eigen::Matrix3f of_sky = sky.Scatter() / sky.n, of_ground = ground.Scatter() / ground.n;
  of_sky.diagonal().array() += kNoise2;
  of_ground.diagonal().array() += kNoise2;
  // Bhattacharyya's distance: whether the two can be told apart at all.
  float half, one, two;
  const Eigen::Matrix3f middle = Whitener((of_sky + of_ground) / 2, half);
  judge.sky_root = Whitener(of_sky, one);
  judge.ground_root = Whitener(of_ground, two);
  judge.offset = two - one;
  const float apart = (middle * (judge.sky - judge.ground)).squaredNorm() / 8 + half - (one + two) / 2;
  judge.knows = apart > kMinApart;
  return judge;
}

using Sectors = std::array<std::array<Body, 2>, kSectors>;
using Judges = std::array<Judge, kSectors>;

// judges: of the pass before, if any. What they take for something else than sky, such as a tree, is not
// learnt from as sky.
Sectors Gather(const BandSamples& band, const BandGrid& grid, const std::vector<double>& contour,
               const ProfileOptions& o, const Judges* judges) {
  Sectors sectors;
  const int gap = std::max(1, static_cast<int>(std::lround(o.gap / grid.step)));
  const int below = std::max(gap + 2, static_cast<int>(std::lround(o.ground_reach / grid.step)));
  const int above = std::max(gap + 2, static_cast<int>(std::lround(o.sky_reach / grid.step)));
  for (int i = 0; i < grid.azimuths; ++i) {
    const auto* colour = band.colour.ptr<cv::Vec3f>(i);
    const auto* shown = band.shown.ptr<uchar>(i);
    const int s = i * kSectors / grid.azimuths;
    auto& [sky, ground] = sectors[static_cast<std::size_t>(s)];
    const Judge* judge = judges ? &(*judges)[static_cast<std::size_t>(s)] : nullptr;
    if (judge && !judge->knows) judge = nullptr;
    const int middle =
        static_cast<int>(std::lround((contour[static_cast<std::size_t>(i)] - grid.lowest) / grid.step));
    for (int j = std::max(0, middle - below); j <= std::min(grid.elevations - 1, middle + above); ++j) {
      if (!shown[j]) continue;
      if (j >= middle + gap && (!judge || judge->SkyDistance2(colour[j]) < kSkyReach2)) sky.Add(colour[j]);
      if (j <= middle - gap) ground.Add(colour[j]);
    }
  }
  return sectors;
}

Judges LearnAll(const Sectors& sectors) {
  Body all[2];
  for (const auto& sector : sectors)
    for (std::size_t k = 0; k < 2; ++k) all[k].Add(sector[k], 1);
  Judges judges;
  for (int s = 0; s < kSectors; ++s) {
    std::array<Body, 2> wide;
    for (int d = -1; d <= 1; ++d)
      for (std::size_t k = 0; k < 2; ++k)
        wide[k].Add(sectors[static_cast<std::size_t>((s + d + kSectors) % kSectors)][k], d ? 0.5f : 1.0f);
    // A sector that is full of trees still knows what sky is like elsewhere.
    for (std::size_t k = 0; k < 2; ++k) wide[k].Add(all[k], kElsewhere);
    judges[static_cast<std::size_t>(s)] = Learn(wide[0], wide[1]);
  }
  return judges;
}

// Where the colour crosses the middle between what is just above the step and what is just below it.
double Crossing(const cv::Vec3f* colour, int first, int last, int step, const BandGrid& grid, double& blur,
                double& contrast) {
  const auto mean = [&](int from, int to) {
    cv::Vec3f sum(0, 0, 0);
    for (int j = from; j <= to; ++j) sum += colour[j];
    return sum * (1.0f / static_cast<float>(to - from + 1));
  };
  const cv::Vec3f above = mean(std::min(last, step + 1), std::min(last, step + 3));
  const cv::Vec3f below = mean(std::max(first, step - 4), std::max(first, step - 2));
  const cv::Vec3f across = above - below, middle = (above + below) * 0.5f;
  const float length2 = across.dot(across);
  blur = 2 * grid.step;
  contrast = std::sqrt(length2);
  double best = step - 0.5, nearest = 1e9;
  if (length2 < 1) return best;
  float steepest = 0;
  float last_value = 0;
  const int from = std::max(first, step - 3), to = std::min(last, step + 2);
  for (int j = from; j <= to; ++j) {
    const float value = (colour[j] - middle).dot(across) / length2;  // -0.5 below to 0.5 above
    if (j > from) {
      steepest = std::max(steepest, value - last_value);
      if (last_value < 0 && value >= 0) {
        const double at = j - 1 + static_cast<double>(last_value / (last_value - value));
        if (std::abs(at - step + 0.5) < nearest) nearest = std::abs(at - step + 0.5), best = at;
      }
    }
    last_value = value;
  }
  if (steepest > 0) blur = grid.step / static_cast<double>(std::max(steepest, 0.05f));
  return best;
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
  point.shown = seen > grid.elevations / 3 && seen == last - first + 1;
  if (!point.shown || !judge.knows) return point;
  float total = 0;
  for (int j = first; j <= last; ++j) {
    odds[static_cast<std::size_t>(j)] = std::clamp(judge.Odds(colour[j]), -kMax, kMax);
    total += odds[static_cast<std::size_t>(j)];
  }
  // The sum of the odds above the step less that below it, by a running sum.
  float best = total, value = total;
  int step = first;  // the lowest sample that is sky
  for (int j = first; j <= last; ++j) {
    value -= 2 * odds[static_cast<std::size_t>(j)];
    if (value > best) best = value, step = j + 1;
  }
  point.gain = static_cast<double>(best - std::abs(total)) / 2;
  // Ground all the way up, or sky all the way down: the contour is elsewhere.
  if (step < first + 2 || step > last - 2 || point.gain < kMinGain) return point;
  point.found = true;
  point.elevation =
      grid.lowest + grid.step * Crossing(colour, first, last, step, grid, point.blur, point.contrast);
  return point;
}

}  // namespace

std::vector<ProfilePoint> FindContour(const BandSamples& band, const BandGrid& grid,
                                      const std::vector<double>& contour, const ProfileOptions& options) {
  std::vector<double> now = contour;
  std::vector<ProfilePoint> points(static_cast<std::size_t>(grid.azimuths));
  std::vector<float> odds(static_cast<std::size_t>(grid.elevations));
  Judges judges;
  for (int pass = 0; pass < options.passes; ++pass) {
    judges = LearnAll(Gather(band, grid, now, options, pass > 0 ? &judges : nullptr));
    for (int i = 0; i < grid.azimuths; ++i) {
      auto& point = points[static_cast<std::size_t>(i)];
      point = Judged(band.colour.ptr<cv::Vec3f>(i), band.shown.ptr<uchar>(i), grid,
                     judges[static_cast<std::size_t>(i * kSectors / grid.azimuths)], odds);
      if (point.found) now[static_cast<std::size_t>(i)] = point.elevation;
    }
  }
  return points;
}

double ContourSeparation(const BandSamples& band, const BandGrid& grid,
                         const std::vector<ProfilePoint>& points) {
  Body sky, ground;
  for (int i = 0; i < grid.azimuths; ++i) {
    const ProfilePoint& point = points[static_cast<std::size_t>(i)];
    if (!point.found) continue;
    const auto* colour = band.colour.ptr<cv::Vec3f>(i);
    const auto* shown = band.shown.ptr<uchar>(i);
    const double middle = (point.elevation - grid.lowest) / grid.step;
    for (int j = 0; j < grid.elevations; ++j) {
      if (!shown[j] || std::abs(j - middle) < 1) continue;
      (j > middle ? sky : ground).Add(colour[j]);
    }
  }
  if (sky.n < 12 || ground.n < 12) return 0;
  Body both = sky;
  both.Add(ground, 1);
  const auto volume = [](const Body& body) {
    Eigen::Matrix3f covariance = body.Scatter() / body.n;
    covariance.diagonal().array() += kNoise2;
    return 0.5f * std::log(covariance.determinant());
  };
  return static_cast<double>(volume(both) - (sky.n * volume(sky) + ground.n * volume(ground)) / both.n);
}

}  // namespace kestrel::vision
