// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <variant>

#include "vision/camera/camera_model.h"

// Other pictures of what a wide camera sees, thesis 6.2: the image is put back onto the unit sphere about the
// viewpoint, eq. (6.5), and seen anew from there. V is the frame of a view, with the axes of a camera: x
// right, y down, z forward.
namespace kestrel::vision {

// R_VC of a view that is turned out of C: yaw to the right, then pitch up, then roll clockwise, rad.
Eigen::Matrix3d ViewRotation(double yaw, double pitch, double roll);

// The image of a virtual perspective camera, eq. (6.6): K_v is that of the pinhole, R_v is R_VC.
struct PerspectiveView {
  Pinhole camera;
  Eigen::Matrix3d R_VC = Eigen::Matrix3d::Identity();
};

// All around the y axis of V, or a part of it. Eq. (6.17) takes even steps along the image's radius, which
// are no angles; here every column is an azimuth and every row an elevation.
struct Panorama {
  // Even steps of the elevation, or of its tangent: unrolled from a cylinder, on which walls stay in
  // proportion.
  enum class Rows { kElevation, kTangent };
  int width_px = 0, height_px = 0;
  // rad. Azimuth: from z towards x of V; the left edge of the first column and the right edge of the last, at
  // most a whole turn. Elevation: from the plane of z and x towards -y; the lower edge of the last row and
  // the upper edge of the first.
  double azimuth_from = 0, azimuth_to = 0;
  double elevation_from = 0, elevation_to = 0;
  Rows rows = Rows::kElevation;
  Eigen::Matrix3d R_VC = Eigen::Matrix3d::Identity();
};

// Eq. (6.17) as printed: I(alpha, R) = I_c(R cos(alpha) + u_0, R sin(alpha) + v_0). It asks nothing of the
// camera but its centre.
struct PolarUnwrapping {
  int width_px = 0, height_px = 0;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // (u_0, v_0)
  double alpha_from = 0, alpha_to = 0;               // rad, left and right edge
  double radius_top = 0, radius_bottom = 0;          // px, upper and lower edge
};

// The unit sphere with the image on it, as in figure 6.7(c): from far away, along z of V. Where the near side
// has nothing the far side shows, from within.
struct SpherePicture {
  int width_px = 0, height_px = 0;  // the sphere fills the smaller of them
  Eigen::Matrix3d R_VC = Eigen::Matrix3d::Identity();
};

using View = std::variant<PerspectiveView, Panorama, PolarUnwrapping, SpherePicture>;

cv::Size SizeOf(const View& view);

// Where a pixel of the view is found in the camera's image: a place between the centres of its pixels. None
// where the lens shows nothing.
std::optional<Eigen::Vector2d> SourceOf(const View& view, const CameraModel& camera,
                                        const Eigen::Vector2d& uv);

// The pixel of a panorama at which a direction in C is seen; none where it is off the picture.
std::optional<Eigen::Vector2d> Project(const Panorama& panorama, const Eigen::Vector3d& p_CQ);

// SourceOf every pixel, to 1/32 px, for many images of one camera.
struct ViewTable {
  cv::Mat place, fraction;  // as cv::convertMaps makes them
  cv::Mat shown;            // CV_8UC1, 255 where the lens shows something
  cv::Size source;          // size of the camera's images
};
ViewTable MakeViewTable(const View& view, const CameraModel& camera);
double ShownShare(const ViewTable& table);  // of the pixels, 0 to 1

// The view of an image of 8 bits with any number of channels and of the camera's size; black where the lens
// shows nothing. Bilinear: a view that is much coarser than the image has aliases.
cv::Mat Look(const ViewTable& table, const cv::Mat& image);

// Pixels per radian about the optical axis, the mean of both directions. The axis must be in the field.
double CentralResolution(const CameraModel& camera);

// The virtual camera along the optical axis that keeps the resolution in its middle and sees as much as the
// lens does to each side, but at most half of the given field. None: the lens does not see its own axis.
std::optional<Pinhole> CentralPinhole(const CameraModel& camera, double most_field_rad);

// Pixels per radian over the whole picture: the square root of its pixels per steradian.
double MeanResolution(const CameraModel& camera);

// The size at which a panorama has the mean resolution of the camera.
cv::Size MatchedSize(const Panorama& panorama, const CameraModel& camera);

// The least range of azimuth and elevation that holds all that the lens sees, in the matched size. Rows by
// the tangent end at 75 degrees. None: the lens sees nothing.
std::optional<Panorama> WholePanorama(const CameraModel& camera, const Eigen::Matrix3d& R_VC,
                                      Panorama::Rows rows);

}  // namespace kestrel::vision
