// SPDX-License-Identifier: Apache-2.0
#include "vision/target/contrast_blob.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace kestrel::vision {

namespace {

constexpr float kTrim = 2.5f;                    // sigmas of the ring, beyond which a pixel is not background
constexpr float kNoise = 1;                      // grey levels, least sigma: of quantisation
constexpr float kFaint = 0.3f, kStrong = 0.55f;  // of the strongest contrast, what belongs to the blob
constexpr int kCore_px = 2;  // px around, in which a pixel's own full contrast is looked for

struct Plane {
  Eigen::Matrix3f coefficients = Eigen::Matrix3f::Zero();  // a row per channel, columns of 1, x, y
  float sigma = 0;
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
      if (pass > 0 && (colour[i] - plane.coefficients * at[i]).squaredNorm() > limit2) continue;
      normal += at[i] * at[i].transpose();
      right += at[i] * colour[i].transpose();
      ++n;
    }
    if (n < 8) return std::nullopt;
    plane.coefficients = normal.ldlt().solve(right).transpose();
    int within = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      const float e2 = (colour[i] - plane.coefficients * at[i]).squaredNorm();
      if (pass > 0 && e2 > limit2) continue;
      square += e2, ++within;
    }
    plane.sigma = std::sqrt(square / static_cast<float>(std::max(1, within)));
    limit2 = std::max(kNoise, kTrim * plane.sigma) * std::max(kNoise, kTrim * plane.sigma);
  }
  return plane;
}

// The surroundings of a place, each pixel less the background once it is asked for; x and y from the place.
class Window {
 public:
  Window(const cv::Mat& image, const cv::Mat& sky, const cv::Point& place, int reach)
      : image_(image),
        sky_(sky),
        place_(place),
        reach_(reach),
        side_(2 * reach + 1),
        pixels_(static_cast<std::size_t>(side_ * side_)) {}

  bool Inside(int x, int y) const {
    return std::abs(x) <= reach_ && std::abs(y) <= reach_ &&
           cv::Rect(0, 0, image_.cols, image_.rows).contains(place_ + cv::Point(x, y));
  }
  bool Sky(int x, int y) const { return sky_.at<uchar>(place_.y + y, place_.x + x) != 0; }
  Eigen::Vector3f Colour(int x, int y) const {
    const int k = image_.channels();
    const uchar* p = image_.ptr<uchar>(place_.y + y) + k * (place_.x + x);
    return k == 3 ? Eigen::Vector3f(p[0], p[1], p[2]) : Eigen::Vector3f::Constant(static_cast<float>(p[0]));
  }
  void SetBackground(const Plane& plane) { plane_ = plane; }

  struct Pixel {
    Eigen::Vector3f difference;  // of each channel to the background
    float largest = 0;           // of them, without sign
    bool known = false;
    uchar part = 0;  // 1: of the blob, 2: beside it
  };
  Pixel& At(int x, int y) {
    Pixel& p = pixels_[static_cast<std::size_t>((y + reach_) * side_ + x + reach_)];
    if (!p.known) {
      p.difference = Colour(x, y) - plane_.coefficients.col(0) -
                     static_cast<float>(x) * plane_.coefficients.col(1) -
                     static_cast<float>(y) * plane_.coefficients.col(2);
      p.largest = p.difference.cwiseAbs().maxCoeff();
      p.known = true;
    }
    return p;
  }

 private:
  const cv::Mat &image_, &sky_;
  cv::Point place_;
  int reach_, side_;
  std::vector<Pixel> pixels_;
  Plane plane_;
};

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
    case BlobState::kClutter:
      return "clutter";
  }
  return "";
}

Blob MeasureBlob(const cv::Mat& image, const cv::Mat& sky, const cv::Point& place, int inner, int outer,
                 const BlobOptions& o) {
  Blob blob;
  Window w(image, sky, place, outer);
  const int stride = std::max(1, inner / 5);  // about as many pixels of a large ring as of a small one
  std::vector<Eigen::Vector3f> at, colour;
  int ring = 0;
  for (int y = -outer / stride * stride; y <= outer; y += stride)
    for (int x = -outer / stride * stride; x <= outer; x += stride) {
      const int r2 = x * x + y * y;
      if (r2 < inner * inner || r2 > outer * outer) continue;
      ++ring;
      if (!w.Inside(x, y) || !w.Sky(x, y)) continue;
      at.emplace_back(1.0f, static_cast<float>(x), static_cast<float>(y));
      colour.push_back(w.Colour(x, y));
    }
  blob.state = BlobState::kHemmedIn;
  if (static_cast<double>(at.size()) < o.min_around * ring) return blob;
  const auto plane = FitRing(at, colour);
  if (!plane) return blob;
  w.SetBackground(*plane);
  // Of one channel: the sigma is of all together.
  const float sigma = std::max(kNoise, plane->sigma / std::sqrt(3.0f));

  // The strongest pixel near the place.
  float peak = 0;
  cv::Point seed;
  const int near = std::max(2, inner / 2);
  for (int y = -near; y <= near; ++y)
    for (int x = -near; x <= near; ++x)
      if (w.Inside(x, y) && w.Sky(x, y) && w.At(x, y).largest > peak)
        peak = w.At(x, y).largest, seed = {x, y};
  blob.state = BlobState::kNothing;
  if (peak < o.min_score * sigma) return blob;
  // All that hangs together with it. If that goes on and on, as into a cloud behind something dark, its
  // strong part; that of something light would be the middle of a cloud.
  std::vector<cv::Point> members;
  const auto grow = [&](float share) {
    const float threshold = std::max(share * peak, 3.5f * sigma);
    for (const cv::Point& p : members) w.At(p.x, p.y).part = 0;
    members.assign(1, seed);
    w.At(seed.x, seed.y).part = 1;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const cv::Point p = members[i];
      if (!w.Sky(p.x, p.y) || p.x * p.x + p.y * p.y >= inner * inner) return false;
      for (int j = 0; j < 9; ++j) {
        const cv::Point q(p.x + j % 3 - 1, p.y + j / 3 - 1);
        if (!w.Inside(q.x, q.y)) return false;
        Window::Pixel& pixel = w.At(q.x, q.y);
        if (pixel.part || pixel.largest < threshold) continue;
        pixel.part = 1;
        members.push_back(q);
      }
    }
    return true;
  };
  blob.state = BlobState::kConnected;
  const bool dark = w.At(seed.x, seed.y).difference.sum() < 0;
  if (!grow(kFaint) && !(dark && grow(kStrong))) return blob;
  const std::size_t inside = members.size();
  for (std::size_t i = 0; i < inside; ++i)
    for (int j = 0; j < 9; ++j) {
      const cv::Point q(members[i].x + j % 3 - 1, members[i].y + j / 3 - 1);
      if (w.At(q.x, q.y).part) continue;
      if (!w.Sky(q.x, q.y)) return blob;
      w.At(q.x, q.y).part = 2;
      members.push_back(q);
    }

  // The share of each pixel: its contrast in the full contrast nearby; all, where only members are around.
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < members.size(); ++i) {
    const cv::Point p = members[i];
    bool deep = i < inside;
    const Window::Pixel* full = nullptr;
    for (int v = p.y - kCore_px; v <= p.y + kCore_px; ++v)
      for (int u = p.x - kCore_px; u <= p.x + kCore_px; ++u) {
        if (!w.Inside(u, v)) continue;
        const Window::Pixel& there = w.At(u, v);
        if (std::abs(u - p.x) <= 1 && std::abs(v - p.y) <= 1) deep = deep && there.part == 1;
        if (there.part == 1 && (!full || there.largest > full->largest)) full = &there;
      }
    // Along the full difference, so that noise across it cancels.
    const Eigen::Vector3f& here = w.At(p.x, p.y).difference;
    const double share =
        deep ? 1.0
             : std::clamp(static_cast<double>(here.dot(full->difference) / full->difference.squaredNorm()),
                          -0.5, 1.0);
    const Eigen::Vector2d px(p.x, p.y);
    blob.area += share;
    first += share * px;
    second += share * px * px.transpose();
    if (i < inside) mean += here / static_cast<float>(inside);
    blob.pixels.push_back({px + Eigen::Vector2d(place.x, place.y), share});
  }
  blob.state = BlobState::kNothing;
  if (blob.area < 1) return blob;
  const Eigen::Vector2d middle = first / blob.area;
  blob.centre = middle + Eigen::Vector2d(place.x, place.y);
  // A pixel has a second moment of its own.
  const Eigen::Matrix2d moments =
      second / blob.area - middle * middle.transpose() + Eigen::Matrix2d::Identity() / 12;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(moments);
  const double small = std::max(0.05, axes.eigenvalues()[0]), large = std::max(0.05, axes.eigenvalues()[1]);
  blob.aspect = std::sqrt(large / small);
  const double ellipse = 4 * M_PI * std::sqrt(small * large);
  blob.contrast = static_cast<double>(mean.mean());
  // By the peak: that of a blob of few pixels stands in few of them.
  blob.strongest = static_cast<double>(peak);
  blob.score = static_cast<double>(peak / sigma);
  blob.sigma = static_cast<double>(sigma);
  blob.background = plane->coefficients.col(0).cast<double>();
  blob.state = BlobState::kNotCompact;
  if (blob.aspect > o.max_aspect || blob.area < o.min_fill * ellipse) return blob;
  blob.state = blob.score < o.min_score ? BlobState::kClutter : BlobState::kMeasured;
  return blob;
}

double SharpnessOf(const cv::Mat& image, const Eigen::Vector2d& centre, double radius, double strongest,
                   double sigma) {
  constexpr int kRays = 16;
  constexpr double kDrop_px = 3, kStep_px = 0.5;
  constexpr int kDrop = static_cast<int>(kDrop_px / kStep_px);
  const int k = image.channels();
  const auto at = [&](const Eigen::Vector2d& p) -> std::optional<cv::Vec3f> {
    const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
    if (x < 0 || y < 0 || x + 1 >= image.cols || y + 1 >= image.rows) return std::nullopt;
    const auto fx = static_cast<float>(p.x() - x), fy = static_cast<float>(p.y() - y);
    const uchar* top = image.ptr<uchar>(y) + k * x;
    const uchar* low = image.ptr<uchar>(y + 1) + k * x;
    cv::Vec3f c;
    for (int i = 0; i < 3; ++i) {
      const int a = k == 3 ? i : 0;
      const float upper = static_cast<float>(top[a]) + fx * static_cast<float>(top[a + k] - top[a]);
      const float lower = static_cast<float>(low[a]) + fx * static_cast<float>(low[a + k] - low[a]);
      c[i] = upper + fy * (lower - upper);
    }
    return c;
  };
  double sum = 0;
  int rays = 0;
  std::vector<cv::Vec3f> along;
  for (int i = 0; i < kRays; ++i) {
    const double angle = 2 * M_PI * i / kRays;
    const Eigen::Vector2d towards(std::cos(angle), std::sin(angle));
    along.clear();
    for (double r = 0.3 * radius; r < 2 * radius + kDrop_px; r += kStep_px) {
      const auto c = at(centre + r * towards);
      if (!c) break;
      along.push_back(*c);
    }
    if (static_cast<int>(along.size()) <= kDrop) continue;
    float drop = 0;
    for (std::size_t j = kDrop; j < along.size(); ++j)
      for (int c = 0; c < 3; ++c) drop = std::max(drop, std::abs(along[j][c] - along[j - kDrop][c]));
    sum += std::max(0.0, static_cast<double>(drop) - 3 * sigma), ++rays;
  }
  return rays > 0 ? sum / rays / strongest : 0;
}

}  // namespace kestrel::vision
