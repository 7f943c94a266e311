// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace kestrel::control {

struct PlaneDepthOptions {
  double depth_m = 3;                // where it begins
  double share = 0.5;                // its standard deviation then, of the inverse depth
  double baseline_m = 0.15;          // way after which two images are compared
  double velocity_sigma_m_s = 0.05;  // of the own velocity, over that way
  double image_sigma = 5e-4;         // of a point, a ratio to the focal length
  double change_per_s = 0.05;        // growth of the standard deviation in a second, a share
};

// The depth of a level plane below a level camera, from how its points move and how far the camera went by its
// own reckoning: the adaptive estimate of thesis 5.2.3 (Hutchinson, Hager and Corke, 1996). Depths that are
// seen in two images are a stereo pair's: with s in axes that do not turn, and d the way between them,
//
//   s_now - s_then = (1/Z_now) (s_then d_z - d_xy)
//
// which is linear in the inverse depth, the state of a Kalman filter. No size of the target is in it. While
// the camera stands still it learns nothing, and keeps what it has.
class PlaneDepth {
 public:
  explicit PlaneDepth(const PlaneDepthOptions& options);

  // The same points in each image, in order. s: on the image plane of a level camera that looks straight down
  // with x to the north; v: of the camera, north, east, down, m/s. An image after a gap of a second begins anew.
  void Add(double t_s, std::span<const Eigen::Vector2d> s, const Eigen::Vector3d& v);

  double depth_m() const { return 1 / inverse_; }
  double sigma_m() const;  // of it

 private:
  PlaneDepthOptions options_;
  double inverse_ = 0, variance_ = 0;              // 1/m and its square
  double t_s_ = 0, then_s_ = 0;                    // of the last image, and of that which is compared
  Eigen::Vector3d way_ = Eigen::Vector3d::Zero();  // m, since then
  std::vector<Eigen::Vector2d> then_;              // empty: none
};

}  // namespace kestrel::control
