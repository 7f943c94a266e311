// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/enhance/canvas/blending.h"
#include "vision/enhance/canvas/canvas.h"
#include "vision/enhance/canvas/surface.h"

namespace kestrel::vision {

// How the images of one camera are put on a surface. M_WC places an image: it takes the ray of a pixel to its
// direction in W, and is a rotation where the camera turns on the spot, or the homography of a plane, thesis
// H_{1->k+1}. A homography has positive third rows of what it takes rays to, where the plane is in front.
class Projection {
 public:
  // f_px: of the surface. That of a cylinder or sphere is changed a little: its circumference, period_px(), is a
  // multiple of 64 pixels.
  Projection(const CameraModel& camera, Surface surface, double f_px);

  // From a pixel of the image to a place of the surface, and back. None: the lens shows nothing there; or the
  // surface is not met. What is found of a place may lie off the image.
  std::optional<Eigen::Vector2d> ToSurface(const Eigen::Matrix3d& M_WC, const Eigen::Vector2d& uv) const;
  std::optional<Eigen::Vector2d> ToImage(const Eigen::Matrix3d& M_CW, const Eigen::Vector2d& place) const;

  // The pixels of the surface that an image may cover. Of one that goes beyond an azimuth of half a turn they do
  // so too. Empty: none, or farther away than any mosaic goes.
  cv::Rect PartOf(const Eigen::Matrix3d& M_WC) const;

  const CameraModel& camera() const { return camera_; }
  cv::Size image_size() const { return {WidthPx(camera_), HeightPx(camera_)}; }
  Surface surface() const { return surface_; }
  double f_px() const { return f_px_; }
  int period_px() const { return period_px_; }  // 0: of a plane

 private:
  CameraModel camera_;
  Surface surface_;
  double f_px_;
  int period_px_ = 0;
};

// Between the centres of the outermost pixels, where something can be interpolated.
bool InImage(cv::Size size, const Eigen::Vector2d& uv);

// A part of an image as it lies on the surface, at the scale of a canvas.
struct ProjectedImage {
  cv::Rect part;    // of the canvas
  cv::Mat pixels;   // CV_8U
  cv::Mat weights;  // CV_32FC1, 0 where the image is not
};
// As much of it as lies within `within`, a part of the canvas; of a surface all around, at the period at which it
// is given. part: that of PartOf, moved by whole periods.
ProjectedImage ProjectImage(const Projection& projection, const cv::Mat& image, const Eigen::Matrix3d& M_WC,
                            const cv::Rect& part, int halvings, Blending blending,
                            const std::optional<cv::Rect>& within = std::nullopt);

// A part of a surface, cut at half a turn; what is beyond comes back in at the other side.
std::vector<cv::Rect> WrappedParts(const cv::Rect& part, int period_px);

// Makes room for the image and draws it.
void DrawImage(const Projection& projection, const cv::Mat& image, const Eigen::Matrix3d& M_WC,
               Canvas& canvas, Blending blending);
// The same of as much as lies within a part of the canvas, for which there is room.
void DrawImageWithin(const cv::Rect& within, const Projection& projection, const cv::Mat& image,
                     const Eigen::Matrix3d& M_WC, Canvas& canvas, Blending blending);

}  // namespace kestrel::vision
