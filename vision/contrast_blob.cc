// SPDX-License-Identifier: Apache-2.0
#include "vision/contrast_blob.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace kestrel {

namespace {

constexpr float kTrim = 2.5f;   // deviations of the ring, beyond which a pixel is not background
constexpr float kNoise = 1;     // grey levels, least deviation: of quantisation
constexpr float kFaint = 0.3f;  // of the strongest contrast, what still belongs to the blob
constexpr float kCoreOf = 2;    // px around, in which a pixel's own full contrast is looked for

struct Window {
  int x0 = 0, y0 = 0, side = 0, channels = 0;
  std::vector<float> difference;  // of each pixel to the background, the largest of the channels
  std::vector<cv::Vec3f> by_channel;
  std::vector<uchar> sky;  // 0: no sky, or outside the image
  std::size_t At(int x, int y) const { return static_cast<std::size_t>(y * side + x); }
  bool Inside(int x, int y) const { return x >= 0 && y >= 0 && x < side && y < side; }
};

struct Plane {
  Eigen::Matrix3f coefficients = Eigen::Matrix3f::Zero();  // a column per channel, of (1, x, y)
  float deviation = 0;
};

// Least squares over the ring, twice: the second time without what is far from the first.
std::optional<Plane> FitRing(const std::vector<Eigen::Vector3f>& at,
                             const std::vector<Eigen::Vector3f>& colour) {
  Plane plane;
  float limit2 = 0;
  for (int pass = 0; pass < 3; ++pass) {
    Eigen::Matrix3f normal = Eigen::Matrix3f::Zero(), right = Eigen::Matrix3f::Zero();
    float square = 0;
    int n = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (pass > 0 && (colour[i] - plane.coefficients.transpose() * at[i]).squaredNorm() > limit2) continue;
      normal += at[i] * at[i].transpose();
      right += at[i] * colour[i].transpose();
      ++n;
    }
    if (n < 8) return std::nullopt;
    plane.coefficients = normal.ldlt().solve(right);
    int within = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      const float e2 = (colour[i] - plane.coefficients.transpose() * at[i]).squaredNorm();
      if (pass > 0 && e2 > limit2) continue;
      square += e2, ++within;
    }
    plane.deviation = std::sqrt(square / static_cast<float>(std::max(1, within)));
    limit2 = std::max(kNoise, kTrim * plane.deviation) * std::max(kNoise, kTrim * plane.deviation);
  }
  return plane;
}

}  // namespace

const char* NameOf(BlobState state) {
  switch (state) {
    case BlobState::kMeasured:
      return "measured";
    case BlobState::kNothing:
      return "nothing";
    case BlobState::kHemmedIn:
      return "hemmed in";
    case BlobState::kConnected:
      return "connected";
    case BlobState::kNotCompact:
      return "not compact";
    case BlobState::kSoft:
      return "soft";
    case BlobState::kClutter:
      return "clutter";
  }
  return "";
}

Blob MeasureBlob(const cv::Mat& image, const cv::Mat& sky, const cv::Point& place, int inner, int outer,
                 const BlobOptions& o) {
  Blob blob;
  Window w{place.x - outer, place.y - outer, 2 * outer + 1, image.channels(), {}, {}, {}};
  const auto size = static_cast<std::size_t>(w.side * w.side);
  w.difference.assign(size, 0), w.by_channel.assign(size, {}), w.sky.assign(size, 0);
  const int k = w.channels;
  std::vector<Eigen::Vector3f> at, colour;
  int ring = 0;
  for (int y = 0; y < w.side; ++y) {
    const int v = w.y0 + y;
    for (int x = 0; x < w.side; ++x) {
      const int u = w.x0 + x, dx = x - outer, dy = y - outer, r2 = dx * dx + dy * dy;
      const bool in_ring = r2 >= inner * inner && r2 <= outer * outer;
      ring += in_ring;
      if (u < 0 || v < 0 || u >= image.cols || v >= image.rows) continue;
      const uchar* p = image.ptr<uchar>(v) + k * u;
      w.by_channel[w.At(x, y)] = k == 3 ? cv::Vec3f(p[0], p[1], p[2]) : cv::Vec3f(p[0], p[0], p[0]);
      w.sky[w.At(x, y)] = sky.at<uchar>(v, u);
      if (!in_ring || !w.sky[w.At(x, y)]) continue;
      at.emplace_back(1.0f, static_cast<float>(dx), static_cast<float>(dy));
      const cv::Vec3f& c = w.by_channel[w.At(x, y)];
      colour.emplace_back(c[0], c[1], c[2]);
    }
  }
  blob.state = BlobState::kHemmedIn;
  if (static_cast<double>(at.size()) < o.least_around * ring) return blob;
  const auto plane = FitRing(at, colour);
  if (!plane) return blob;
  // Of one channel: the deviation is of all together.
  const float deviation = std::max(kNoise, plane->deviation / std::sqrt(3.0f));

  // The strongest pixel near the place, and all that hangs together with it.
  float peak = 0;
  cv::Point seed;
  for (int y = 0; y < w.side; ++y)
    for (int x = 0; x < w.side; ++x) {
      const auto i = w.At(x, y);
      const Eigen::Vector3f background =
          plane->coefficients.transpose() *
          Eigen::Vector3f(1, static_cast<float>(x - outer), static_cast<float>(y - outer));
      for (int c = 0; c < 3; ++c) w.by_channel[i][c] -= background[c];
      w.difference[i] = std::max(
          {std::abs(w.by_channel[i][0]), std::abs(w.by_channel[i][1]), std::abs(w.by_channel[i][2])});
      const int near = std::max(2, inner / 2);
      if (std::abs(x - outer) <= near && std::abs(y - outer) <= near && w.sky[i] && w.difference[i] > peak)
        peak = w.difference[i], seed = {x, y};
    }
  blob.state = BlobState::kNothing;
  if (peak < o.least_score * deviation) return blob;
  const float threshold = std::max(kFaint * peak, 3.5f * deviation);
  std::vector<uchar> within(size, 0);
  std::vector<cv::Point> members{seed};
  within[w.At(seed.x, seed.y)] = 1;
  blob.state = BlobState::kConnected;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const cv::Point p = members[i];
    const int dx = p.x - outer, dy = p.y - outer;
    if (!w.sky[w.At(p.x, p.y)] || dx * dx + dy * dy >= inner * inner) return blob;
    for (int j = 0; j < 9; ++j) {
      const cv::Point q(p.x + j % 3 - 1, p.y + j / 3 - 1);
      if (!w.Inside(q.x, q.y)) return blob;
      if (within[w.At(q.x, q.y)] || w.difference[w.At(q.x, q.y)] < threshold) continue;
      within[w.At(q.x, q.y)] = 1;
      members.push_back(q);
    }
  }

  // How far from the members every pixel is: 1 member, 2 beside one, 3 and 4 farther.
  for (uchar step = 1; step <= 3; ++step)
    for (int y = 1; y < w.side - 1; ++y)
      for (int x = 1; x < w.side - 1; ++x) {
        uchar& here = within[w.At(x, y)];
        if (here) continue;
        for (int j = 0; j < 9 && !here; ++j)
          if (within[w.At(x + j % 3 - 1, y + j / 3 - 1)] == step) here = static_cast<uchar>(step + 1);
      }
  // The share of each pixel: its contrast in the full contrast nearby; all, where only members are around.
  double halo = 0, inside = 0;
  int halo_n = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (int y = 1; y < w.side - 1; ++y)
    for (int x = 1; x < w.side - 1; ++x) {
      const auto i = w.At(x, y);
      const uchar distance = within[i];
      if (distance == 0) continue;
      if (!w.sky[i]) {
        blob.state = BlobState::kConnected;
        return blob;
      }
      if (distance > 2) {
        halo += static_cast<double>(w.difference[i]), ++halo_n;
        continue;
      }
      bool deep = distance == 1;
      float core = 0;
      cv::Vec3f full;
      for (int v = std::max(0, y - 2); v <= std::min(w.side - 1, y + 2); ++v)
        for (int u = std::max(0, x - 2); u <= std::min(w.side - 1, x + 2); ++u) {
          if (std::abs(u - x) <= 1 && std::abs(v - y) <= 1) deep = deep && within[w.At(u, v)] == 1;
          if (within[w.At(u, v)] == 1 && w.difference[w.At(u, v)] > core)
            core = w.difference[w.At(u, v)], full = w.by_channel[w.At(u, v)];
        }
      if (core <= 0) continue;
      // Along the full difference, so that noise beside the edge cancels.
      const double share =
          deep ? 1.0 : std::clamp(static_cast<double>(w.by_channel[i].dot(full) / full.dot(full)), -0.5, 1.0);
      const Eigen::Vector2d px(x, y);
      blob.area += share;
      first += share * px;
      second += share * px * px.transpose();
      if (distance == 1) {
        inside += 1;
        for (int c = 0; c < 3; ++c) mean[c] += static_cast<double>(w.by_channel[i][c]);
      }
      blob.pixels.push_back({Eigen::Vector2d(w.x0 + x, w.y0 + y), share});
    }
  blob.state = BlobState::kNothing;
  if (blob.area < 1 || inside < 1) return blob;
  const Eigen::Vector2d middle = first / blob.area;
  blob.centre = middle + Eigen::Vector2d(w.x0, w.y0);
  // A pixel has a second moment of its own.
  const Eigen::Matrix2d moments =
      second / blob.area - middle * middle.transpose() + Eigen::Matrix2d::Identity() / 12;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(moments);
  const double small = std::max(0.05, axes.eigenvalues()[0]), large = std::max(0.05, axes.eigenvalues()[1]);
  blob.aspect = std::sqrt(large / small);
  const double ellipse = 4 * M_PI * std::sqrt(small * large);
  blob.contrast = mean.sum() / 3 / inside;
  // By the peak: that of a blob of few pixels stands in few of them.
  blob.strongest = static_cast<double>(peak);
  blob.score = static_cast<double>(peak / deviation);
  blob.state = BlobState::kNotCompact;
  if (blob.aspect > o.most_aspect || blob.area < o.least_fill * ellipse) return blob;
  blob.state = BlobState::kSoft;
  const double noise = 1.3 * static_cast<double>(deviation);  // mean of the largest of three
  if (halo_n > 0 && std::max(0.0, halo / halo_n - noise) > o.most_halo * static_cast<double>(peak))
    return blob;
  blob.state = blob.score < o.least_score ? BlobState::kClutter : BlobState::kMeasured;
  return blob;
}

}  // namespace kestrel
