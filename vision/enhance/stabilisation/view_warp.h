// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/camera/camera_model.h"

namespace kestrel::vision {

// Where the pixels of a stabilised image come from. Without a camera: H alone. With one: H takes what the pinhole
// `virtual_camera` of attitude R_NV would see, as the middle row was exposed, to where it is shown.
struct ImageView {
  cv::Size size;                                    // of the view
  Eigen::Matrix3d H = Eigen::Matrix3d::Identity();  // to the view's pixels, H(2, 2) = 1
  int rows = 0;                                     // of the image
  // From where the virtual camera (without a camera: the image) has what the middle row's time shows to where it has
  // it while a row is exposed, at even times from the first row to the last. Empty: nothing moves meanwhile.
  std::vector<Eigen::Matrix3d> row_warps;
  bool turned = false;  // with the attitudes below
  Pinhole virtual_camera;
  Eigen::Quaterniond R_NV = Eigen::Quaterniond::Identity();
  std::vector<Eigen::Quaterniond> R_NC_rows;  // of the camera, from the first row to the last
};

// R_NC at a row of an image of so many rows, between the attitudes given.
Eigen::Quaterniond AttitudeOfRow(const std::vector<Eigen::Quaterniond>& R_NC_rows, int rows, double row);

// The pixel of the image that a pixel of the view shows, which may lie off the image. None: no ray of the camera, or
// none that a row saw. camera: where the view is turned.
std::optional<Eigen::Vector2d> SourceOf(const ImageView& view, const CameraModel* camera,
                                        const Eigen::Vector2d& uv);
// Where the view shows a pixel of the image.
std::optional<Eigen::Vector2d> ShownAt(const ImageView& view, const CameraModel* camera,
                                       const Eigen::Vector2d& uv);

// The view of an image of 8 bits, bilinear. shown: CV_8UC1, 255 where the image has what the view shows; elsewhere the
// view is black.
cv::Mat DrawView(const ImageView& view, const CameraModel* camera, const cv::Mat& image, cv::Mat* shown);
// The same with the rim of the image drawn on beyond it.
cv::Mat DrawViewBeyond(const ImageView& view, const CameraModel* camera, const cv::Mat& image);

}  // namespace kestrel::vision
