// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "vision/landmark/features/features.h"

// What a tracker of the pad is told, and what it says of an image.
namespace kestrel::vision {

struct PadTrackerOptions {
  std::string method = "klt";
  bool registration = true;  // of klt; without it: as in the thesis
  int max_points = 90;
  int min_inliers = 10;
  double threshold_px = 1.5;
  double sigma_px = 0.08, shift_px = 0.05;
  std::string features = "sift";
};

inline void Fields(FieldVisitor& v, PadTrackerOptions& o) {
  v({"method",
     "klt: corners of the pad by Lucas-Kanade, and RANSAC; icia: its whole picture at once, by the inverse "
     "compositional algorithm"},
    o.method, {"klt", "icia"});
  v({"registration",
     "of klt: register each image to the pad's known picture; false: chain homographies between images, "
     "which drift"},
    o.registration);
  v({"max_points", "approximate number of corners of the pad that are tracked in an image"}, o.max_points, 20,
    400);
  v({"min_inliers", "minimum number of points that must agree for the pad to count as seen"}, o.min_inliers,
    6, 100);
  v({"threshold_px", "maximum symmetric transfer distance of an inlier"}, o.threshold_px, 0.2, 10.0);
  v({"sigma_px", "standard deviation of a tracked point, from which the covariance of the pose follows"},
    o.sigma_px, 0.001, 5.0);
  v({"shift_px",
     "standard deviation of an error that all points share, such as that of where the middle of a blurred "
     "image is"},
    o.shift_px, 0.0, 5.0);
  v({"features", "which features find the pad anew where only a part of it is in view; surf needs dlib"},
    o.features, FeatureDetectorNames());
}

struct PadObservation {
  Pose X_CT;
  Eigen::Matrix<double, 6, 6> covariance;  // of (translation in C, m; rotation vector in C, rad)
  Eigen::Matrix3d H_w;                     // from T, m, to the image
  int inliers = 0;                         // of icia: points of a grid on the pad that are in view
  double residual_px = 0;                  // root mean square of the inliers
  double visible = 0;  // area spanned by the inliers, or that agrees with the picture, as a share of the pad
  bool registered = false;
  bool found = false;  // by search in this frame, not by tracking
};

}  // namespace kestrel::vision
