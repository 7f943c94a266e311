// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/image_registration.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "vision/enhance/canvas/pixel_map.h"
#include "vision/enhance/canvas/projection.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

cv::Size SizeOf(const CameraModel& camera) { return {WidthPx(camera), HeightPx(camera)}; }

// Where a pixel of one image is in another.
std::optional<Vector2d> Moved(const CameraModel& camera, const Matrix3d& M, const Vector2d& uv) {
  const auto ray = Ray(camera, uv);
  return ray ? Project(camera, M * *ray) : std::nullopt;
}

// Whether windows of Lucas-Kanade, which are moved but not turned, would still fit.
bool IsNearlyMovedOnly(const CameraModel& camera, const Matrix3d& M_BA) {
  constexpr double kStep_px = 20, kMost = 0.12;
  const Vector2d middle((WidthPx(camera) - 1) / 2.0, (HeightPx(camera) - 1) / 2.0);
  const auto at = Moved(camera, M_BA, middle), right = Moved(camera, M_BA, middle + Vector2d(kStep_px, 0)),
             below = Moved(camera, M_BA, middle + Vector2d(0, kStep_px));
  if (!at || !right || !below) return false;
  return ((*right - *at) / kStep_px - Vector2d(1, 0)).norm() < kMost &&
         ((*below - *at) / kStep_px - Vector2d(0, 1)).norm() < kMost;
}

// Where a place of an image would be seen from the centre.
std::optional<Vector2d> FromCentre(const CameraModel& camera, const RegisteredImage& image,
                                   const Vector2d& uv) {
  if (!image.parallax) return uv;
  const auto ray = Ray(camera, uv);
  if (!ray) return std::nullopt;
  const double falls = image.parallax->down_C.dot(*ray);
  return falls > 0 ? Project(camera, *ray + falls * image.parallax->moved_C) : uv;
}

void AddPair(const CameraModel& camera, const RegisteredImage& a, const RegisteredImage& b,
             const Vector2d& in_a, const Vector2d& in_b, std::vector<PixelPair>& pairs) {
  const auto of_a = FromCentre(camera, a, in_a), of_b = FromCentre(camera, b, in_b);
  if (of_a && of_b) pairs.push_back({*of_a, *of_b});
}

cv::Point2f AsPoint(const Vector2d& v) { return {static_cast<float>(v.x()), static_cast<float>(v.y())}; }

}  // namespace

const std::vector<cv::Point2f>& RegisteredImage::corners() {
  if (!has_corners_) {
    constexpr double kQuality = 0.005;
    const double apart_px = std::sqrt(grey_.size().area() / (3.0 * max_corners_));
    cv::goodFeaturesToTrack(grey_, corners_, max_corners_, kQuality, apart_px);
    has_corners_ = true;
  }
  return corners_;
}

FlowOptions RegisteredImage::flow() const {
  return {.window = {21, 21}, .levels = 3, .least_eigenvalue = 1e-4, .opencl = opencl_};
}

const FlowPyramid& RegisteredImage::pyramid() {
  if (pyramid_.empty()) pyramid_ = FlowPyramid(grey_, flow());
  return pyramid_;
}

const Features& RegisteredImage::features() {
  if (!has_features_) {
    features_ = Detect(grey_, {.detector = FeatureDetector::kOrb, .max_features = 700});
    has_features_ = true;
  }
  return features_;
}

void RegisteredImage::ForgetPyramid() { pyramid_ = {}; }

std::vector<PixelPair> FollowedPairs(const CameraModel& camera, RegisteredImage& a, RegisteredImage& b,
                                     const Matrix3d& M_AB) {
  constexpr double kMargin_px = 4;
  const Matrix3d M_BA = M_AB.inverse();
  const cv::Size size = SizeOf(camera);
  std::vector<cv::Point2f> from, guess;
  for (const cv::Point2f& corner : a.corners()) {
    const auto at = Moved(camera, M_BA, {corner.x, corner.y});
    if (!at || at->x() < kMargin_px || at->y() < kMargin_px || at->x() > size.width - 1 - kMargin_px ||
        at->y() > size.height - 1 - kMargin_px)
      continue;
    from.push_back(corner);
    guess.push_back(AsPoint(*at));
  }
  if (from.empty()) return {};
  const bool as_it_is = IsNearlyMovedOnly(camera, M_BA);
  FlowPyramid drawn;
  if (!as_it_is) {
    const PixelMap map =
        MakePixelMap({cv::Point(), size}, 16, [&](const Vector2d& uv) { return Moved(camera, M_BA, uv); });
    cv::Mat as_a;
    cv::remap(b.grey(), as_a, map.u, map.v, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    drawn = FlowPyramid(as_a, b.flow());
    guess = from;
  }
  const std::vector<std::uint8_t> found =
      FollowPoints(a.pyramid(), as_it_is ? b.pyramid() : drawn, from, guess);
  std::vector<PixelPair> pairs;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!found[i]) continue;
    std::optional<Vector2d> to(Vector2d(guess[i].x, guess[i].y));
    if (!as_it_is) to = Moved(camera, M_BA, *to);
    if (to && InImage(size, *to)) AddPair(camera, a, b, {from[i].x, from[i].y}, *to, pairs);
  }
  return pairs;
}

std::vector<PixelPair> FeaturePairs(const CameraModel& camera, RegisteredImage& a, RegisteredImage& b) {
  const Features &of_a = a.features(), &of_b = b.features();
  if (of_a.points.size() < 2 || of_b.points.size() < 2) return {};
  std::vector<PixelPair> pairs;
  for (const Match& match : MatchFeatures(of_a, of_b, {.ratio = 0.8F, .mutual = true})) {
    const cv::Point2f p = of_a.points[static_cast<std::size_t>(match.a)].pt,
                      q = of_b.points[static_cast<std::size_t>(match.b)].pt;
    AddPair(camera, a, b, {p.x, p.y}, {q.x, q.y}, pairs);
  }
  return pairs;
}

std::optional<MotionEstimate> RegisterNear(MosaicModel model, const CameraModel& camera, RegisteredImage& a,
                                           RegisteredImage& b, const Matrix3d& M_AB,
                                           const RegistrationOptions& options) {
  const std::vector<PixelPair> pairs = FollowedPairs(camera, a, b, M_AB);
  const int least =
      std::max(options.min_pairs, static_cast<int>(options.min_share * static_cast<double>(pairs.size())));
  return EstimateMotion(model, camera, pairs, options.threshold_px, least);
}

std::optional<MotionEstimate> RegisterFar(MosaicModel model, const CameraModel& camera, RegisteredImage& a,
                                          RegisteredImage& b, const RegistrationOptions& options) {
  constexpr double kOfFeatures = 2;  // their places are that much less certain
  const auto rough = EstimateMotion(model, camera, FeaturePairs(camera, a, b),
                                    kOfFeatures * options.threshold_px, options.min_pairs);
  return rough ? RegisterNear(model, camera, a, b, rough->M_AB, options) : std::nullopt;
}

double SharedWith(const CameraModel& camera, const Matrix3d& M_AB) {
  constexpr int kAcross = 12, kDown = 9;
  const cv::Size size = SizeOf(camera);
  int of_b = 0, shared = 0;
  for (int i = 0; i < kDown; ++i)
    for (int j = 0; j < kAcross; ++j) {
      const Vector2d uv((j + 0.5) * size.width / kAcross, (i + 0.5) * size.height / kDown);
      if (!Ray(camera, uv)) continue;
      ++of_b;
      const auto at = Moved(camera, M_AB, uv);
      shared += at && InImage(size, *at);
    }
  return of_b > 0 ? static_cast<double>(shared) / of_b : 0;
}

}  // namespace kestrel::vision
