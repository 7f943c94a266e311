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

// A keyframe serves until so few of its points agree.
constexpr double kKeyframeInliers = 0.5;

Quaterniond Middle(const std::vector<Quaterniond>& R_NC_rows) { return AttitudeOfRow(R_NC_rows, 3, 1); }

}  // namespace

const char* NameOf(StabilisedState state) {
  switch (state) {
    case StabilisedState::kFirst:
      return "first";
    case StabilisedState::kFollowed:
      return "followed";
    case StabilisedState::kRecovered:
      return "recovered";
    case StabilisedState::kTextureless:
      return "textureless";
    case StabilisedState::kCut:
      return "cut";
    case StabilisedState::kResized:
      return "resized";
    case StabilisedState::kReanchored:
      return "reanchored";
    case StabilisedState::kGyro:
      return "gyro";
    case StabilisedState::kGyroAlone:
      return "gyro_alone";
    case StabilisedState::kNoAttitude:
      return "no_attitude";
  }
  return "";
}

ImageFollower::ImageFollower(const StabiliserOptions& options, const std::optional<CameraModel>& camera,
                             const Pinhole& virtual_camera, bool keyframes)
    : options_(options),
      camera_(camera),
      virtual_(virtual_camera),
      keyframes_(keyframes && options.by != "sphere"),
      turned_(options.by != "vision") {}

void ImageFollower::Begin(MotionImage now, double t_s, const FollowedImage& followed) {
  from_t_s_ = t_s;
  from_ = std::move(now);
  from_rows_ = followed.R_NC_rows, R_NC_from_ = followed.R_NC;
  G_last_ = H_last_ = Matrix3d::Identity();
}

ImageFollower::Measured ImageFollower::Measure(MotionImage& now, double t_s, const FollowedImage& followed,
                                               double readout_s) const {
  Measured measured;
  ImageMotionOptions options = options_.motion;
  std::optional<Matrix3d> H_expected;
  if (keyframes_) H_expected = H_last_;
  if (options_.by == "both" && std::holds_alternative<Pinhole>(*camera_)) {
    const Matrix3d K = virtual_.K(), turn = (followed.R_NC.conjugate() * R_NC_last_).toRotationMatrix();
    H_expected = K * turn * K.inverse() * H_last_;
  }
  // What rows that were exposed one after the other, or a wide lens, do to an image is no plane's motion: pairs are
  // only sifted by it here, and judged as directions.
  constexpr double kSift_px = 6;
  if (turned_) options.threshold_px += kSift_px, options.model = NameOf(MotionModel::kHomography);
  measured.motion = MotionBetween(from_, now, H_expected, options);
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
      rays.push_back({AttitudeOfRow(from_rows_, rows, pair.from.y()) * *a,
                      AttitudeOfRow(followed.R_NC_rows, rows, pair.to.y()) * *b});
    sifted.push_back(pair);
  }
  std::vector<int> inliers;
  if (options_.by == "sphere") {
    const auto fit = FitRobustRotation(rays, options_.motion.threshold_px / CentralResolution(*camera_),
                                       options_.motion.min_inliers);
    if (fit) measured.R_NC = R_NC_from_ * fit->R, inliers = fit->inliers;
    measured.G = Matrix3d::Identity();
  } else {
    std::vector<PointPair> seen;  // by the virtual camera, turned as the camera was
    std::vector<PointPair> seen_from;
    const Quaterniond R_VN = R_NC_from_.conjugate();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto a = virtual_.Project(R_VN * rays[i].from), b = virtual_.Project(R_VN * rays[i].to);
      if (a && b) seen.push_back({*a, *b}), seen_from.push_back(sifted[i]);
    }
    sifted = std::move(seen_from);
    const RobustMotionOptions robust{.threshold_px = options_.motion.threshold_px,
                                     .min_inliers = options_.motion.min_inliers};
    const MotionModel model = *MotionModelNamed(options_.motion.model);
    auto fit = FitRobustMotion(seen, model, robust);
    if (fit && readout_s != 0 && t_s > from_t_s_) {
      // Rows are of other times than the middle one's, and what moves goes on meanwhile.
      const Matrix3d drift_per_s = (fit->H - Matrix3d::Identity()) / (t_s - from_t_s_);
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
      const Matrix3d N_from_V = R_NC_from_.toRotationMatrix() * virtual_.K().inverse();
      measured.G = N_from_V * fit->H * N_from_V.inverse();
      motion.rms_px = fit->rms_px, inliers = fit->inliers;
    }
  }
  if (inliers.empty()) motion.state = MotionState::kCut;
  motion.inliers.clear();
  for (const int i : inliers) motion.inliers.push_back(sifted[static_cast<std::size_t>(i)]);
  return measured;
}

FollowedImage ImageFollower::Step(const cv::Mat& grey, double t_s, const ImageAttitudes& attitudes) {
  FollowedImage followed;
  const bool has_attitudes = !attitudes.R_NC_rows.empty(),
             wants = options_.by == "gyro" || options_.by == "both";
  if (wants && has_attitudes)
    followed.R_NC_rows = attitudes.R_NC_rows, followed.R_NC = Middle(attitudes.R_NC_rows);
  else
    followed.R_NC = R_NC_last_, followed.R_NC_rows = {R_NC_last_};
  inliers_.clear();
  MotionImage now(grey, options_.by != "gyro" && options_.motion.method == "lk");
  const bool first = !any_, resized = any_ && grey.size() != last_.grey().size();
  any_ = true;
  if (first || resized) {
    followed.state = resized ? StabilisedState::kResized : StabilisedState::kFirst;
    if (wants && !has_attitudes) followed.state = StabilisedState::kNoAttitude;
    Begin(now, t_s, followed);
  } else if (options_.by == "gyro") {
    followed.begins = false;
    followed.state = has_attitudes ? StabilisedState::kGyro : StabilisedState::kNoAttitude;
  } else {
    Measured measured = Measure(now, t_s, followed, attitudes.readout_s);
    if (!measured.motion.Known() && keyframes_ && from_.grey().data != last_.grey().data) {
      from_ = last_, from_rows_ = last_rows_, R_NC_from_ = R_NC_last_, from_t_s_ = last_t_s_;
      G_last_ = H_last_ = Matrix3d::Identity();
      measured = Measure(now, t_s, followed, attitudes.readout_s);
    }
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
      const bool renew =
          !keyframes_ ||
          followed.inliers <
              kKeyframeInliers * static_cast<double>(from_.Corners(options_.motion.max_points).size());
      if (renew) Begin(now, t_s, followed);
    } else if (motion.state == MotionState::kTextureless) {
      followed.state = wants ? StabilisedState::kGyroAlone : StabilisedState::kTextureless;
    } else {
      followed.state = wants ? StabilisedState::kGyroAlone : StabilisedState::kCut;
      followed.begins = !wants;
      Begin(now, t_s, followed);
    }
    if (wants && !has_attitudes) followed.state = StabilisedState::kNoAttitude;
  }
  R_NC_last_ = followed.R_NC;
  last_ = now, last_t_s_ = t_s, last_rows_ = followed.R_NC_rows;
  if (attitudes.down_C && turned_) followed.down_N = followed.R_NC * *attitudes.down_C;
  if (!turned_) followed.R_NC_rows.clear();
  return followed;
}

}  // namespace kestrel::vision
