// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

// The warps W(x; mu) of thesis 3.2.1 as groups of 3 x 3 matrices on homogeneous points.
namespace kestrel::vision {

enum class WarpModel { kTranslation, kEuclidean, kSimilarity, kAffine, kHomography };

// 2, 3, 4, 6 and 8. The parameters of a smaller group are the first of every larger one: translation along x
// and y, turn from x to y, growth, stretch of x against y, shear, and the lines at infinity along x and y.
int ParameterCount(WarpModel warp);

using WarpParameters = Eigen::Matrix<double, 8, 1>;  // those beyond ParameterCount() are zero
using WarpDerivative = Eigen::Matrix<double, 2, 8>;  // of a point, columns as the parameters
inline const WarpParameters kNoWarp = WarpParameters::Zero();

// The element of the group with these coordinates in its Lie algebra, exp(sum p_i G_i), with last element 1:
// its inverse is that of -p.
Eigen::Matrix3d ExponentialWarp(const WarpParameters& p);
// Of ExponentialWarp(p) x with respect to p at p = 0.
WarpDerivative ExponentialDerivative(const Eigen::Vector2d& x);

// The parameters of Baker and Matthews (2004), which add: the matrix is the identity plus sum p_i A_i, with
// the A_i the generators at the identity; the turn of a Euclidean warp alone is by an angle.
Eigen::Matrix3d AdditiveWarp(WarpModel warp, const WarpParameters& p);
// Of AdditiveWarp(warp, p) x with respect to p.
WarpDerivative AdditiveDerivative(WarpModel warp, const WarpParameters& p, const Eigen::Vector2d& x);

// Of W x with respect to x.
Eigen::Matrix2d PlaceDerivative(const Eigen::Matrix3d& W, const Eigen::Vector2d& x);

}  // namespace kestrel::vision
