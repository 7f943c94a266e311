// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/skyline_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace kestrel::vision {

namespace {

constexpr int kCell = 10;           // of the half image, px
constexpr double kSpacing = 0.11;   // between the directions tried, rad
constexpr double kBand = 0.7;       // elevations that count, rad
constexpr double kGap = 0.03;       // cells nearer to the horizon straddle it
constexpr double kMinShare = 0.04;  // of the cells on either side
constexpr double kStrip = 0.14;     // elevations right above a horizon, rad
constexpr double kMinStrip = 2;     // mean cells
constexpr double kApart = 0.16;     // rad between candidates

// Even points on the cap about an axis: a spiral.
std::vector<Eigen::Vector3d> CapDirections(const Eigen::Vector3d& axis, double reach) {
  const Eigen::Vector3d u = axis.unitOrthogonal(), v = axis.cross(u);
  const double area = 2 * M_PI * (1 - std::cos(reach));
  const int n = std::max(1, static_cast<int>(area / (kSpacing * kSpacing)));
  std::vector<Eigen::Vector3d> out;
  for (int i = 0; i < n; ++i) {
    const double c = 1 - (1 - std::cos(reach)) * (i + 0.5) / n, s = std::sqrt(std::max(0.0, 1 - c * c));
    const double angle = 2.399963229728653 * i;
    out.emplace_back(c * axis + s * (std::cos(angle) * u + std::sin(angle) * v));
  }
  return out;
}

// Over 0: more like sky, which is as a rule bluer, brighter and smoother than ground, and never green.
double SkyLike(double blue, double green, double red, double rough) {
  return (blue - red) / 30 + ((blue + 2 * green + red) / 4 - 80) / 40 - (green - (blue + red) / 2) / 4 -
         0.2 * (rough - 2.5);
}

double LogDeterminant(const float* m, double* mean_out) {
  const double n = m[0];
  Eigen::Vector4d mean;
  for (int k = 0; k < 4; ++k) mean[k] = m[1 + k] / n;
  Eigen::Matrix4d S;
  int at = 5;
  for (int a = 0; a < 4; ++a)
    for (int b = a; b < 4; ++b, ++at) S(a, b) = S(b, a) = m[at] / n - mean[a] * mean[b];
  // Floor: the noise of the sensor and of the quantisation; of the roughness, its own.
  S.diagonal() += Eigen::Vector4d(4, 4, 4, 0.02);
  if (mean_out) Eigen::Map<Eigen::Vector4d>{mean_out} = mean;
  const Eigen::LLT<Eigen::Matrix4d> llt(S);
  return 2 * llt.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

SkylineSearch::SkylineSearch(const CameraModel& camera, const cv::Mat& forbidden,
                             const Eigen::Vector3d& down_C, double max_tilt) {
  const int width = WidthPx(camera) / 2, height = HeightPx(camera) / 2;
  for (int y = 0; y + kCell <= height; y += kCell)
    for (int x = 0; x + kCell <= width; x += kCell) {
      bool whole = true;
      std::array<Eigen::Vector3d, 4> corners;
      for (int k = 0; k < 4 && whole; ++k) {
        const Eigen::Vector2d half(x + (k % 2) * kCell, y + (k / 2) * kCell);
        const auto ray = Ray(camera, (2 * half.array() - 0.5).matrix());
        if (!ray)
          whole = false;
        else
          corners[static_cast<std::size_t>(k)] = *ray;
      }
      if (!whole) continue;
      if (!forbidden.empty()) {
        const cv::Rect there(2 * x, 2 * y, 2 * kCell, 2 * kCell);
        if (cv::countNonZero(forbidden(there)) > 0) continue;
      }
      const Eigen::Vector3d middle = (corners[0] + corners[1] + corners[2] + corners[3]).normalized();
      const double solid = (corners[3] - corners[0]).cross(corners[2] - corners[1]).norm() / 2;
      cells_.push_back({{x, y, kCell, kCell}, middle.cast<float>(), static_cast<float>(solid)});
    }
  double mean = 0;
  for (const Cell& cell : cells_) mean += cell.weight / static_cast<double>(cells_.size());
  for (Cell& cell : cells_) cell.weight = static_cast<float>(cell.weight / mean);
  for (const Eigen::Vector3d& down : CapDirections(down_C.normalized(), max_tilt)) {
    Split split{down, {}, {}};
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const double s = -down.dot(cells_[i].ray.cast<double>());
      if (std::abs(s) > std::sin(kBand) || std::abs(s) < kGap) continue;
      (s > 0 ? split.sky : split.ground).push_back(static_cast<int>(i));
    }
    const auto least = kMinShare * static_cast<double>(cells_.size());
    if (static_cast<double>(split.sky.size()) < least || static_cast<double>(split.ground.size()) < least)
      continue;
    splits_.push_back(std::move(split));
  }
}

SkylineSearch::Overview SkylineSearch::Look(const cv::Mat& half, std::size_t most) const {
  std::vector<std::array<float, kMoments>> moments(cells_.size());
  Overview out;
  std::vector<float> roughness;
  double sum = 0, sum2 = 0, mean[3] = {0, 0, 0};
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    int s[3] = {0, 0, 0}, square = 0, count = 0;
    // Every second row and column of the half image: an eighth of the pixels tells enough.
    for (int y = 0; y < kCell; y += 2) {
      const uchar* p = half.ptr<uchar>(cell.place.y + y) + 3 * cell.place.x;
      for (int x = 0; x < kCell; x += 2, p += 6) {
        s[0] += p[0], s[1] += p[1], s[2] += p[2];
        const int grey = (p[0] + 2 * p[1] + p[2]) / 4;
        square += grey * grey;
        ++count;
      }
    }
    const float n = static_cast<float>(count);
    const float b = static_cast<float>(s[0]) / n, g = static_cast<float>(s[1]) / n,
                r = static_cast<float>(s[2]) / n;
    const float grey = (b + 2 * g + r) / 4;
    const float variance = std::max(0.0f, static_cast<float>(square) / n - grey * grey);
    const float f[4] = {b, g, r, 0.5f * std::log(1 + variance)};
    roughness.push_back(std::sqrt(variance));
    out.dark += grey < 14;
    out.white += b > 248 && g > 248 && r > 248;
    sum += grey, sum2 += static_cast<double>(grey) * grey;
    mean[0] += b, mean[1] += g, mean[2] += r;
    auto& m = moments[i];
    m[0] = cell.weight;
    int at = 5;
    for (int a = 0; a < 4; ++a) {
      m[static_cast<std::size_t>(1 + a)] = cell.weight * f[a];
      for (int c = a; c < 4; ++c, ++at) m[static_cast<std::size_t>(at)] = cell.weight * f[a] * f[c];
    }
    m[15] = 0;
  }
  if (cells_.empty()) return out;
  const auto n = static_cast<double>(cells_.size());
  out.dark /= n, out.white /= n;
  out.spread = std::sqrt(std::max(0.0, sum2 / n - sum / n * sum / n));
  std::nth_element(roughness.begin(), roughness.begin() + static_cast<std::ptrdiff_t>(roughness.size() / 2),
                   roughness.end());
  out.rough = roughness[roughness.size() / 2];
  out.sky = SkyLike(mean[0] / n, mean[1] / n, mean[2] / n, out.rough);

  std::vector<Candidate> all;
  all.reserve(splits_.size());
  using Moments = Eigen::Array<float, kMoments, 1>;
  for (const Split& split : splits_) {
    Moments sky = Moments::Zero(), ground = Moments::Zero();
    for (const int i : split.sky)
      sky += Eigen::Map<const Moments>(moments[static_cast<std::size_t>(i)].data());
    for (const int i : split.ground)
      ground += Eigen::Map<const Moments>(moments[static_cast<std::size_t>(i)].data());
    const Moments both = sky + ground;
    Eigen::Vector4d above, below;
    const double gain =
        0.5 *
        (both[0] * LogDeterminant(both.data(), nullptr) - sky[0] * LogDeterminant(sky.data(), above.data()) -
         ground[0] * LogDeterminant(ground.data(), below.data())) /
        static_cast<double>(both[0]);
    // Sky is as a rule smoother, brighter and bluer than ground; each may fail, so they only vote.
    const double smoother = below[3] - above[3];
    const double brighter = (above.head<3>().sum() - below.head<3>().sum()) / 3 / 40;
    const double bluer = ((above[0] - above[2]) - (below[0] - below[2])) / 30;
    const double vote = std::tanh(smoother) + 0.6 * std::tanh(brighter) + 0.6 * std::tanh(bluer);
    // A narrow sliver on one side gains little from being told apart, whatever it is.
    all.push_back({split.down_C, gain + 0.25 * vote,
                   SkyLike(above[0], above[1], above[2], std::exp(above[3])),
                   SkyLike(below[0], below[1], below[2], std::exp(below[3]))});
  }
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  const double apart = std::cos(kApart);
  for (const Candidate& c : all) {
    if (out.candidates.size() >= most) break;
    const bool near = std::any_of(out.candidates.begin(), out.candidates.end(),
                                  [&](const Candidate& o) { return o.down_C.dot(c.down_C) > apart; });
    if (!near) out.candidates.push_back(c);
  }
  out.moments = std::move(moments);
  return out;
}

SkylineSearch::Sides SkylineSearch::SidesOf(const Overview& overview, const Eigen::Vector3d& down_C,
                                            double dip) const {
  using Moments = Eigen::Array<float, kMoments, 1>;
  Moments below = Moments::Zero(), near = Moments::Zero(), far = Moments::Zero();
  const Eigen::Vector3f down = down_C.cast<float>();
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const double s = std::asin(std::clamp(-static_cast<double>(down.dot(cells_[i].ray)), -1.0, 1.0)) + dip;
    if (std::abs(s) > kBand || std::abs(s) < kGap) continue;
    (s < 0 ? below : s < kStrip ? near : far) += Eigen::Map<const Moments>(overview.moments[i].data());
  }
  const auto like = [](const Moments& m) {
    if (m[0] <= 0) return 0.0;
    const Eigen::Vector4d mean = m.segment<4>(1).cast<double>() / static_cast<double>(m[0]);
    return SkyLike(mean[0], mean[1], mean[2], std::exp(mean[3]));
  };
  Sides out;
  const Moments above = near + far;
  out.above = like(above), out.below = like(below), out.near = like(near), out.far = like(far);
  if (near[0] > kMinStrip && far[0] > kMinStrip)
    out.strip_apart =
        0.5 *
        (above[0] * LogDeterminant(above.data(), nullptr) - near[0] * LogDeterminant(near.data(), nullptr) -
         far[0] * LogDeterminant(far.data(), nullptr)) /
        static_cast<double>(above[0]);
  return out;
}

double SkylineSearch::ShareAbove(const Eigen::Vector3d& down_C) const {
  double above = 0, all = 1e-9;
  for (const Cell& cell : cells_) {
    const float s = -cell.ray.dot(down_C.cast<float>());
    if (std::abs(s) < kGap) continue;
    all += cell.weight;
    if (s > 0) above += cell.weight;
  }
  return above / all;
}

}  // namespace kestrel::vision
