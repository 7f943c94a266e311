// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/camera/camera_model.h"
#include "vision/target/colour_model.h"

namespace kestrel::vision {

// The rays of C that touch a sphere: around the direction of its centre, for any central camera; the image of
// the cone is the sphere's outline. sin(half_angle) = radius / distance.
struct OutlineCone {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  // unit vector in C
  double half_angle = 0;                            // rad
};

struct BalloonFitOptions {
  double min_radius_px = 3;
  double min_contrast = 12;
  double min_outline = 0.35;
  double sigma_px = 0.1;
  double bias_px = 0.05;
};

inline void Fields(FieldVisitor& v, BalloonFitOptions& o) {
  v(Renamed("min_radius_px", "least_radius_px", "minimum radius of the outline that is fitted"),
    o.min_radius_px, 1.0, 100.0);
  v(Renamed("min_contrast", "least_contrast",
            "minimum contrast between inside and outside, in grey levels of 255 over all channels together"),
    o.min_contrast, 1.0, 200.0);
  v(Renamed("min_outline", "least_outline", "minimum share of the outline that must be seen, 0 to 1"),
    o.min_outline, 0.1, 1.0);
  v({"sigma_px", "minimum standard deviation of an edge point"}, o.sigma_px, 0.001, 5.0);
  v({"bias_px", "standard deviation of the error that all edge points share, in the measured radius"},
    o.bias_px, 0.0, 5.0);
}

enum class FitState {
  kFitted,
  kTooSmall,          // its radius is under that of the options
  kTooLittleOutline,  // hidden, cut by the image's edge, without contrast, or not round
  kOffLens,           // where it should be, the camera shows nothing
  kBadImage           // not CV_8UC3 of the camera's size
};
const char* NameOf(FitState state);

struct BalloonFit {
  FitState state = FitState::kBadImage;
  OutlineCone cone;                                           // of use only if fitted, as all that follows
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();       // of axis (rank 2) and half-angle, rad
  double half_angle_sigma = 0;                                // rad
  double outline = 0;                                         // share of all round that agrees
  double residual_px = 0;                                     // root mean square of what agrees
  std::vector<Eigen::Vector2d> edge_points, agreeing_points;  // px, for the overlay
};

// The balloon's outline near a guess, px, such as CamShift's: edge points to a fraction of a pixel on lines
// across it, where the colour is halfway between inside and outside, and the cone through their rays,
// robustly. A string, a pole before it or things of its colour behind it are but outliers, as long as enough
// outline is left.
BalloonFit FitBalloon(const cv::Mat& bgr, const CameraModel& camera, const ColourModel& model,
                      const Eigen::Vector2d& centre_px, double diameter_px,
                      const BalloonFitOptions& options = {});
// The same near an expected cone, off by less than a third of its half-angle or 20 px: also where the colour
// of what is behind it does not tell it.
BalloonFit FitBalloonNear(const cv::Mat& bgr, const CameraModel& camera, const ColourModel& model,
                          const OutlineCone& expected, const BalloonFitOptions& options = {});

// Thesis (5.16): x = X/Z, y = Y/Z, diameter = D/Z of the sphere behind a cone, whatever its size, with their
// covariance. None unless the sphere's centre is before the camera, Z > 0.
struct SphereFeatures {
  Eigen::Vector3d xyd = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};
std::optional<SphereFeatures> FeaturesOf(const OutlineCone& cone, const Eigen::Matrix4d& covariance);

// The cone of a sphere with the centre p_CT, m; none if C is within it.
std::optional<OutlineCone> ConeOfSphere(const Eigen::Vector3d& p_CT, double radius);

// The outline in the image, px, all round; and its box, whose first pixel spans 0 to 1, as in OpenCV. Where
// the lens shows nothing there are no points; none at all: no box. It may reach beyond the image.
std::vector<Eigen::Vector2d> DrawOutline(const CameraModel& camera, const OutlineCone& cone,
                                         int points = 180);
std::optional<cv::Rect2d> OutlineBox(const CameraModel& camera, const OutlineCone& cone);

}  // namespace kestrel::vision
