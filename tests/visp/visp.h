// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/pose.h"

// What ViSP 3.5 answers, as Eigen values. Its headers are of C++17, hence this wrapper, which is compiled so;
// for the tests alone.
namespace kestrel::visp {

enum class Matrix { kCurrent, kDesired, kMean };

// vpFeaturePoint of (x, y, Z): its interaction matrix; and the velocity (v, w) of vpServo for several.
Eigen::MatrixXd PointInteraction(const Eigen::Vector3d& xyZ);
Eigen::VectorXd PointVelocity(const std::vector<Eigen::Vector3d>& now,
                              const std::vector<Eigen::Vector3d>& wanted, Matrix matrix, double lambda);

// The velocity for vpFeatureTranslation of c*Mc and for that of cMo, each with vpFeatureThetaU of c*Rc.
Eigen::VectorXd PoseVelocity(const Pose& X_DC, double lambda);
Eigen::VectorXd TargetPoseVelocity(const Pose& X_CO, const Pose& X_DO, double lambda);
Eigen::MatrixXd ThetaUInteraction(const Pose& X_DC);  // 3 x 6

// The velocity of 2 1/2-D servoing: vpFeaturePoint, vpFeatureDepth and vpFeatureThetaU.
Eigen::VectorXd HybridVelocity(const Eigen::Vector3d& now_xyZ, const Eigen::Vector3d& wanted_xyZ,
                               const Pose& X_DC, double lambda);

// vpMomentGravityCenterNormalized and vpMomentAreaNormalized of points (x, y) in a plane across the optical axis
// at the depth Z: (xn, yn, an), and their interaction matrix, 3 x 6.
struct Moments {
  Eigen::Vector3d value;
  Eigen::MatrixXd interaction;
};
Moments NormalisedMoments(const std::vector<Eigen::Vector2d>& points, double Z, double area_wanted,
                          double Z_wanted);

}  // namespace kestrel::visp
