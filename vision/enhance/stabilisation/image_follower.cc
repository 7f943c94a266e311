// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/image_follower.h"

#include <Eigen/LU>
#include <utility>

#include "vision/camera/views.h"
#include "vision/enhance/motion/ray_rotation.h"
#include "vision/enhance/stabilisation/view_warp.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kKeyframeInliers = 0.5;  // a keyframe serves until so few of its points agree
constexpr double kSeen = 0.75;            // share of a keyframe in the image that goes back to it
constexpr double kRetry_s = 1;            // after one that was not found again
constexpr std::size_t kMostKeyframes = 12;

Quaterniond Middle(const std::vector<Quaterniond>& R_NC_rows) { return AttitudeOfRow(R_NC_rows, 3, 1); }

}  // namespace

ImageFollower::ImageFollower(const StabiliserOptions& options, const std::optional<CameraModel>& camera,
                             const Pinhole& virtual_camera, bool keyframes)
    : options_(options),
      camera_(camera),
      virtual_(virtual_camera),
      by_keyframes_(keyframes &&
                    (options.by != "sphere" || (camera && std::holds_alternative<Pinhole>(*camera)))),
      turned_(options.by != "vision") {}

void ImageFollower::Begin(MotionImage now, double t_s, const FollowedImage& followed) {
  from_ = {std::move(now), t_s, t_s, followed.R_NC_rows, followed.R_NC};
  G_last_ = H_last_ = Matrix3d::Identity();
  keyframes_.clear(), keyframe_ = 0;
  if (by_keyframes_) keyframes_.push_back(from_);
}

void ImageFollower::Anchor() {
  from_ = last_;
  G_last_ = H_last_ = from_.G = from_.H = Matrix3d::Identity();
  keyframes_.clear(), keyframe_ = 0;
  if (by_keyframes_) keyframes_.push_back(from_);
}

// The last image, by the keyframe that it was compared with.
void ImageFollower::AddKeyframe() {
  if (keyframes_.size() == kMostKeyframes) keyframes_.erase(keyframes_.begin() + 1);
  from_ = last_;
  keyframes_.push_back(from_), keyframe_ = keyframes_.size() - 1;
  G_last_ = H_last_ = Matrix3d::Identity();
}

void ImageFollower::CompareWith(std::size_t keyframe) {
  const Matrix3d G = G_last_ * from_.G, H = H_last_ * from_.H;
  from_ = keyframes_[keyframe], keyframe_ = keyframe;
  G_last_ = G * from_.G.inverse(), H_last_ = H * from_.H.inverse();
}

std::size_t ImageFollower::Seen(std::size_t until, double t_s) const {
  constexpr int kSteps = 8;
  const Matrix3d H = H_last_ * from_.H;
  const cv::Rect2d image(0, 0, last_.image.grey().cols - 1, last_.image.grey().rows - 1);
  for (std::size_t i = 0; i < until; ++i) {
    if (i == keyframe_ || t_s < keyframes_[i].not_before_s) continue;
    const Matrix3d to_last = H * keyframes_[i].H.inverse();
    int seen = 0;
    for (int y = 0; y < kSteps; ++y)
      for (int x = 0; x < kSteps; ++x) {
        const Vector3d at =
            to_last * Vector3d((x + 0.5) * image.width / kSteps, (y + 0.5) * image.height / kSteps, 1);
        seen += at.z() > 0 && image.contains({at.x() / at.z(), at.y() / at.z()});
      }
    if (seen >= kSeen * kSteps * kSteps) return i;
  }
  return until;
}

bool ImageFollower::HalfAgree(std::size_t inliers) const {
  return static_cast<double>(inliers) >=
         kKeyframeInliers * static_cast<double>(from_.image.Corners(options_.motion.max_points).size());
}

ImageFollower::Measured ImageFollower::Measure(MotionImage& now, double t_s, const FollowedImage& followed,
                                               double readout_s) const {
  Measured measured;
  ImageMotionOptions options = options_.motion;
  std::optional<Matrix3d> H_expected;
  if (by_keyframes_) H_expected = H_last_;
  if (options_.by == "both" && std::holds_alternative<Pinhole>(*camera_)) {
    const Matrix3d K = virtual_.K(), turn = (followed.R_NC.conjugate() * last_.R_NC).toRotationMatrix();
    H_expected = K * turn * K.inverse() * H_last_;
  }
  // What rows that were exposed one after the other, or a wide lens, do to an image is no plane's motion: pairs are
  // only sifted by it here, and judged as directions. By images alone the fit evens out what the rows do.
  constexpr double kSift_px = 6, kRows_px = 4;
  if (turned_)
    options.threshold_px += kSift_px, options.model = NameOf(MotionModel::kHomography);
  else if (readout_s != 0)
    options.threshold_px += kRows_px;
  measured.motion = MotionBetween(from_.image, now, H_expected, options);
  ImageMotion& motion = measured.motion;
  measured.R_NC = followed.R_NC;
  measured.G = motion.H;
  if (!motion.Known() || !turned_) return measured;

  std::vector<RayPair> rays;  // in N, but of sphere in C
  std::vector<PointPair> sifted;
  for (const PointPair& pair : motion.inliers) {
    const auto a = Ray(*camera_, pair.from), b = Ray(*camera_, pair.to);
    if (!a || !b) continue;
    const int rows = HeightPx(*camera_);
    if (options_.by == "sphere")
      rays.push_back({*b, *a});
    else
      rays.push_back({AttitudeOfRow(from_.R_NC_rows, rows, pair.from.y()) * *a,
                      AttitudeOfRow(followed.R_NC_rows, rows, pair.to.y()) * *b});
    sifted.push_back(pair);
  }
  std::vector<int> inliers;
  if (options_.by == "sphere") {
    const auto fit = FitRobustRotation(rays, options_.motion.threshold_px / CentralResolution(*camera_),
                                       options_.motion.min_inliers);
    if (fit) measured.R_NC = from_.R_NC * fit->R, inliers = fit->inliers;
    measured.G = Matrix3d::Identity();
  } else {
    std::vector<PointPair> seen;  // by the virtual camera, turned as the camera was
    std::vector<PointPair> seen_from;
    const Quaterniond R_VN = from_.R_NC.conjugate();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto a = virtual_.Project(R_VN * rays[i].from), b = virtual_.Project(R_VN * rays[i].to);
      if (a && b) seen.push_back({*a, *b}), seen_from.push_back(sifted[i]);
    }
    sifted = std::move(seen_from);
    const RobustMotionOptions robust{.threshold_px = options_.motion.threshold_px,
                                     .min_inliers = options_.motion.min_inliers};
    const MotionModel model = *MotionModelNamed(options_.motion.model);
    auto fit = FitRobustMotion(seen, model, robust);
    if (fit && readout_s != 0 && t_s > from_.t_s) {
      // Rows are of other times than the middle one's, and what moves goes on meanwhile.
      const Matrix3d drift_per_s = (fit->H - Matrix3d::Identity()) / (t_s - from_.t_s);
      const int rows = HeightPx(*camera_);
      const auto to_middle = [&](const Eigen::Vector2d& p, double row) {
        return Transfer((Matrix3d::Identity() + readout_s * (row / (rows - 1) - 0.5) * drift_per_s).inverse(),
                        p);
      };
      for (std::size_t i = 0; i < seen.size(); ++i)
        seen[i] = {to_middle(seen[i].from, sifted[i].from.y()), to_middle(seen[i].to, sifted[i].to.y())};
      fit = FitRobustMotion(seen, model, robust);
    }
    if (fit) {
      const Matrix3d N_from_V = from_.R_NC.toRotationMatrix() * virtual_.K().inverse();
      measured.G = N_from_V * fit->H * N_from_V.inverse();
      motion.rms_px = fit->rms_px, inliers = fit->inliers;
    }
  }
  if (inliers.empty()) motion.state = MotionState::kCut;
  motion.inliers.clear();
  for (const int i : inliers) motion.inliers.push_back(sifted[static_cast<std::size_t>(i)]);
  return measured;
}

// By the first keyframe that is seen again, else by the one at hand, else by the last image.
ImageFollower::Measured ImageFollower::MeasureByKeyframes(MotionImage& now, double t_s,
                                                          const FollowedImage& followed, double readout_s) {
  const std::size_t at_hand = keyframe_, earlier = Seen(at_hand, t_s);
  if (earlier < at_hand) {
    CompareWith(earlier);
    Measured again = Measure(now, t_s, followed, readout_s);
    if (again.motion.Known() && HalfAgree(again.motion.inliers.size())) return again;
    for (std::size_t i = earlier; i < at_hand; ++i) keyframes_[i].not_before_s = t_s + kRetry_s;
    CompareWith(at_hand);
  }
  Measured measured = Measure(now, t_s, followed, readout_s);
  const bool last_known = last_.image.grey().data != from_.image.grey().data && last_is_known_;
  if (measured.motion.Known() || !by_keyframes_ || !last_known) return measured;
  AddKeyframe();
  return Measure(now, t_s, followed, readout_s);
}

FollowedImage ImageFollower::Step(const cv::Mat& grey, double t_s, const ImageAttitudes& attitudes) {
  FollowedImage followed;
  const bool has_attitudes = !attitudes.R_NC_rows.empty(),
             wants = options_.by == "gyro" || options_.by == "both";
  if (wants && has_attitudes)
    followed.R_NC_rows = attitudes.R_NC_rows, followed.R_NC = Middle(attitudes.R_NC_rows);
  else
    followed.R_NC = last_.R_NC, followed.R_NC_rows = {last_.R_NC};
  inliers_.clear();
  MotionImage now(grey, options_.by != "gyro" && options_.motion.method == "lk", options_.motion.opencl);
  const bool first = !any_, resized = any_ && grey.size() != last_.image.grey().size();
  any_ = true;
  if (first || resized) {
    followed.state = resized ? StabilisedState::kResized : StabilisedState::kFirst;
    if (wants && !has_attitudes) followed.state = StabilisedState::kNoAttitude;
    Begin(now, t_s, followed);
  } else if (options_.by == "gyro") {
    followed.begins = false;
    followed.state = has_attitudes ? StabilisedState::kGyro : StabilisedState::kNoAttitude;
  } else {
    const Measured measured = MeasureByKeyframes(now, t_s, followed, attitudes.readout_s);
    const ImageMotion& motion = measured.motion;
    inliers_ = motion.inliers;
    followed.points = motion.points, followed.inliers = static_cast<int>(motion.inliers.size());
    followed.rms_px = motion.rms_px;
    followed.begins = false;
    if (motion.Known()) {
      followed.state =
          motion.state == MotionState::kFollowed ? StabilisedState::kFollowed : StabilisedState::kRecovered;
      if (options_.by == "sphere") followed.R_NC = measured.R_NC, followed.R_NC_rows = {measured.R_NC};
      followed.G = measured.G * G_last_.inverse();
      followed.G /= followed.G(2, 2);
      G_last_ = measured.G, H_last_ = motion.H;
      if (!by_keyframes_) Begin(now, t_s, followed);
    } else if (motion.state == MotionState::kTextureless) {
      followed.state = wants ? StabilisedState::kGyroAlone : StabilisedState::kTextureless;
      // What has texture is waited for; what has none, such as a video's black beginning, is of no use.
      if (static_cast<int>(from_.image.Corners(options_.motion.max_points).size()) <
          options_.motion.min_inliers)
        Begin(now, t_s, followed);
    } else {
      followed.state = wants ? StabilisedState::kGyroAlone : StabilisedState::kCut;
      followed.begins = !wants;
      Begin(now, t_s, followed);
    }
    if (wants && !has_attitudes) followed.state = StabilisedState::kNoAttitude;
  }
  last_is_known_ = followed.inliers > 0;
  last_ = {now, t_s, t_s, followed.R_NC_rows, followed.R_NC, G_last_ * from_.G, H_last_ * from_.H};
  if (by_keyframes_ && last_is_known_ && !HalfAgree(inliers_.size())) {
    const std::size_t other = Seen(keyframes_.size(), t_s);
    if (other < keyframes_.size())
      CompareWith(other);
    else
      AddKeyframe();
  }
  if (attitudes.down_C && turned_) followed.down_N = followed.R_NC * *attitudes.down_C;
  if (!turned_) followed.R_NC_rows.clear();
  return followed;
}

}  // namespace kestrel::vision
