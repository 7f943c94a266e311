// SPDX-License-Identifier: Apache-2.0
#include "bench/planar/planar_trackers.h"

#include <Eigen/Dense>
#include <algorithm>
#include <memory>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "bench/planar/planar_sequence.h"
#include "vision/landmark/alignment/aligner.h"
#include "vision/landmark/pad_features.h"
#include "vision/landmark/pad_tracker.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::bench {
namespace {

using Eigen::Matrix3d;

// From the picture, so many pixels wide, to T.
Matrix3d TFromPicture(const cv::Size& size) {
  Matrix3d T_from_pixel;
  T_from_pixel << 0, -kPlanarLength_m / size.height, kPlanarLength_m / 2 * (1 - 1.0 / size.height),  //
      kPlanarWidth_m / size.width, 0, -kPlanarWidth_m / 2 * (1 - 1.0 / size.width),                  //
      0, 0, 1;
  return T_from_pixel;
}

class Ecc {
 public:
  explicit Ecc(const cv::Mat& picture) : picture_(picture) {}
  void Start(const Matrix3d& H_w) { H_w_ = H_w; }

  std::optional<Matrix3d> Track(const cv::Mat& grey) {
    Matrix3d H = H_w_;
    for (const double width_px : {64.0, 128.0})
      if (!Refine(grey, width_px, H)) return std::nullopt;
    H_w_ = H;
    return H;
  }

 private:
  // At the scale at which the picture has about that width, or its own where that is less.
  bool Refine(const cv::Mat& grey, double width_px, Matrix3d& H_w) const {
    constexpr int kIterations = 40;
    constexpr double kStill = 1e-4, kMinCorrelation = 0.6;
    const double seen_px = SeenWidth_px(H_w);
    if (!(seen_px > 10)) return false;
    const double scale = std::min(1.0, width_px / seen_px);
    const cv::Size size(cvRound(std::min(width_px, seen_px)),
                        cvRound(std::min(width_px, seen_px) * picture_.rows / picture_.cols));
    cv::Mat pattern, image;
    cv::resize(picture_, pattern, size, 0, 0, cv::INTER_AREA);
    cv::resize(grey, image, {cvRound(grey.cols * scale), cvRound(grey.rows * scale)}, 0, 0, cv::INTER_AREA);
    const Matrix3d T_from_pattern = TFromPicture(size);
    Matrix3d smaller;
    const double sx = static_cast<double>(image.cols) / grey.cols,
                 sy = static_cast<double>(image.rows) / grey.rows;
    smaller << sx, 0, (sx - 1) / 2, 0, sy, (sy - 1) / 2, 0, 0, 1;
    Matrix3d W = smaller * H_w * T_from_pattern;
    W /= W(2, 2);
    cv::Mat warp;
    cv::eigen2cv(W, warp);
    warp.convertTo(warp, CV_32F);
    try {  // it throws where it does not converge
      const double correlation = cv::findTransformECC(
          pattern, image, warp, cv::MOTION_HOMOGRAPHY,
          {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kIterations, kStill}, cv::noArray(), 3);
      if (!(correlation > kMinCorrelation)) return false;
    } catch (const cv::Exception&) {
      return false;
    }
    warp.convertTo(warp, CV_64F);
    cv::cv2eigen(warp, W);
    H_w = smaller.inverse() * W * T_from_pattern.inverse();
    return H_w.allFinite();
  }
  static double SeenWidth_px(const Matrix3d& H_w) {
    const auto at = [&](double y) { return vision::Transfer(H_w, {0, y}); };
    return (at(kPlanarWidth_m / 2) - at(-kPlanarWidth_m / 2)).norm();
  }

  cv::Mat picture_;
  Matrix3d H_w_ = Matrix3d::Identity();
};

}  // namespace

PlanarTracker PadPlanarTracker(const cv::Mat& picture, const vision::PadTrackerOptions& options,
                               const std::string& name) {
  const auto reference = std::make_shared<const vision::PadReference>(
      vision::MakePadReference(picture, kPlanarLength_m, kPlanarWidth_m));
  const auto tracker = std::make_shared<std::optional<vision::PadTracker>>();
  const auto track = [tracker](const cv::Mat& grey, const std::optional<Pose>& expected) {
    const auto seen = (*tracker)->Track(grey, expected);
    return seen ? std::optional(seen->H_w) : std::nullopt;
  };
  return {name, true,
          [=](const cv::Mat& grey, const Matrix3d& H_w) {
            tracker->emplace(*reference, kPlanarCamera, options);
            track(grey, vision::PoseFromHomography(H_w, kPlanarCamera));
          },
          [=](const cv::Mat& grey) { return track(grey, std::nullopt); }};
}

PlanarTracker AlignerPlanarTracker(const cv::Mat& picture, vision::AlignmentMethod method,
                                   const std::string& name) {
  constexpr int kTemplate_px = 160, kInset_px = 2;
  const cv::Size size(kTemplate_px, kTemplate_px * picture.rows / picture.cols);
  cv::Mat small;
  cv::resize(picture, small, size, 0, 0, cv::INTER_AREA);
  struct State {
    vision::Aligner aligner;
    vision::ImagePyramid image;
    Matrix3d H_w = Matrix3d::Identity();
  };
  const cv::Rect region(kInset_px, kInset_px, size.width - 2 * kInset_px, size.height - 2 * kInset_px);
  const vision::AlignmentOptions options{
      .method = method, .loss = vision::AlignmentLoss::kTukey, .min_correlation = 0.7};
  const auto state = std::make_shared<State>(State{vision::Aligner(small, region, options), {}});
  const Matrix3d T_from_pixel = TFromPicture(size);
  return {name, true, [=](const cv::Mat&, const Matrix3d& H_w) { state->H_w = H_w; },
          [=](const cv::Mat& grey) -> std::optional<Matrix3d> {
            vision::FillPyramid(grey, state->image);
            const vision::Alignment found = state->aligner.Align(state->image, state->H_w * T_from_pixel);
            if (found.state != vision::AlignmentState::kConverged) return std::nullopt;
            return state->H_w = found.W * T_from_pixel.inverse();
          }};
}

PlanarTracker FeaturesPlanarTracker(const cv::Mat& picture, vision::FeatureDetector detector) {
  const auto features = std::make_shared<const vision::PadFeatures>(
      vision::MakePadReference(picture, kPlanarLength_m, kPlanarWidth_m), kPlanarCamera, detector);
  return {"ours, " + vision::NameOf(detector) + " alone", true, [](const cv::Mat&, const Matrix3d&) {},
          [=](const cv::Mat& grey) { return features->Find(grey, 1); }};
}

PlanarTracker EccPlanarTracker(const cv::Mat& picture) {
  const auto ecc = std::make_shared<Ecc>(picture);
  return {"OpenCV, ECC", false, [=](const cv::Mat&, const Matrix3d& H_w) { ecc->Start(H_w); },
          [=](const cv::Mat& grey) { return ecc->Track(grey); }};
}

std::vector<PlanarTracker> PlanarTrackers(const cv::Mat& picture) {
  std::vector<PlanarTracker> all = {
      PadPlanarTracker(picture, {}, "ours, klt"),
      PadPlanarTracker(picture, {.method = "icia"}, "ours, icia"),
      PadPlanarTracker(picture, {.registration = false}, "ours, chain alone"),
      AlignerPlanarTracker(picture, vision::AlignmentMethod::kInverseCompositional, "ours, ICIA alone"),
      AlignerPlanarTracker(picture, vision::AlignmentMethod::kSecondOrder, "ours, ESM alone"),
  };
  for (const std::string& name : vision::FeatureDetectorNames()) {
    const auto detector = *vision::FeatureDetectorNamed(name);
    if (vision::IsAvailable(detector)) all.push_back(FeaturesPlanarTracker(picture, detector));
  }
  all.push_back(EccPlanarTracker(picture));
  return all;
}

}  // namespace kestrel::bench
