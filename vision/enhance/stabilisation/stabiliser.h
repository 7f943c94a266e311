// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/enhance/stabilisation/image_follower.h"
#include "vision/enhance/stabilisation/path_weights.h"
#include "vision/enhance/stabilisation/stabiliser_options.h"
#include "vision/enhance/stabilisation/view_warp.h"

// Video whose view stands still, or goes smoothly, thesis 4.2. The thesis multiplies the homographies between images
// back to the first one, which drifts; here a reference is followed by keyframes, each of which many images are
// compared with.
namespace kestrel::vision {

struct StabilisedImage {
  cv::Mat image;  // of the input's channels
  double t_s = 0;
  std::int64_t number = 0;  // of the image, from 0
  StabilisedState state = StabilisedState::kFirst;
  int points = 0, inliers = 0;
  double rms_px = 0;  // of the inliers
  double strength =
      1;           // 1: as the path asks for; less: drawn back to the image, so that the view stays within it
  ImageView view;  // where its pixels come from
};

class Stabiliser {
 public:
  // camera: none, by vision in pixels. rate_hz: of the images, about. Throws std::invalid_argument where the options
  // need a camera that is not given, or that does not see along its own axis.
  Stabiliser(const StabiliserOptions& options, const std::optional<CameraModel>& camera, double rate_hz);

  // Takes the next image (CV_8UC1 or CV_8UC3), and gives the one that is due: of mode reference this one, of the
  // others the one that is Lag() images older. None: not so many have come yet.
  std::optional<StabilisedImage> Step(const cv::Mat& image, double t_s, const ImageAttitudes& attitudes = {});
  // After the last image the rest of them, one by one. None: that was all.
  std::optional<StabilisedImage> Finish();

  int Lag() const { return lag_; }  // images
  // The pairs of points that the last Step() found to agree, from the image that it was compared with.
  const std::vector<PointPair>& last_inliers() const { return follower_.last_inliers(); }

 private:
  struct Plan {
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();  // from R_NC to the smooth attitude, in C
    std::vector<PointPair> corners;                  // of what is shown, and where the smooth path has them
    std::vector<Eigen::Matrix3d> row_warps;          // as of ImageView, but of the directions in N
    Eigen::Vector2d lower{0, 0}, upper{0, 0};        // shifts with which the view stays within the image, px
    double most = 1;  // the greatest strength with which the view stays within the image
  };
  struct Image {
    cv::Mat pixels;  // until it is shown
    double t_s = 0, readout_s = 0;
    std::int64_t number = 0;
    FollowedImage followed;
    std::optional<Plan> plan;
  };

  Image& At(std::int64_t number) {
    return images_[static_cast<std::size_t>(number - images_.front().number)];
  }
  void AnchorIfLost(Image& now);
  void MakePlan(Image& image, std::int64_t newest);
  void MakePlans(std::int64_t newest);
  std::vector<Eigen::Matrix3d> RowWarpsOf(const Image& image, int before, int after);
  void Bound(Image& image);
  Eigen::Vector2d Shift(const Image& image);
  double MostStrength(const Image& image, double strength, const Eigen::Vector2d& shift) const;
  double Strength(const Image& image);
  ImageView ViewOf(const Image& image, double strength, const Eigen::Vector2d& shift) const;
  double ShareInside(const ImageView& view, const cv::Size& size, int steps) const;
  StabilisedImage Show(Image& image);
  void DrawBorder(const Image& image, const cv::Mat& shown, StabilisedImage& result);
  Eigen::Matrix3d FromDirections(const Eigen::Quaterniond& R_NV) const;
  Eigen::Quaterniond Level(const Eigen::Quaterniond& R_NV, const Eigen::Vector3d& down_N) const;

  StabiliserOptions options_;
  std::optional<CameraModel> camera_;
  Pinhole virtual_;
  bool turned_, reference_;
  // Images that count for one: for its path, for its bound, and for its strength.
  int before_, lag_, ahead_, around_;
  double cutoff_;  // cycles an image
  ImageFollower follower_;
  PathWeights weights_;
  std::deque<Image> images_;
  std::int64_t taken_ = 0, planned_ = 0, shown_ = 0;
  bool finishing_ = false;
  std::array<Eigen::Vector2d, 2> last_shifts_{Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0)};
  // Mode reference: from the directions that the last image shows to those of the reference.
  Eigen::Matrix3d G_to_reference_ = Eigen::Matrix3d::Identity();
  Eigen::Quaterniond R_NC_reference_ = Eigen::Quaterniond::Identity();
  // Border filled: what was shown last, where it is known, and how directions come to its pixels.
  cv::Mat earlier_, earlier_known_;
  Eigen::Matrix3d earlier_H_ = Eigen::Matrix3d::Identity();
};

}  // namespace kestrel::vision
