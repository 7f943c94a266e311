// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "control/law/servo_law.h"

// Image-based visual servoing on points of a pinhole image, thesis 5.2.3, eqs. (5.1) to (5.7).
// Deviations: (5.4) has lost a sign of w_x and turned that of w_y in its first line, and (5.7) that of w_y in
// its last point; (5.5) is right.
namespace kestrel::control {

struct ImagePoint {
  Eigen::Vector2d s = Eigen::Vector2d::Zero();  // (X/Z, Y/Z) in C, eq. (5.1)
  double Z = 0;                                 // depth, m
};

// ds/dt by the twist (v, w) of C, eq. (5.5). Z > 0.
Eigen::Matrix<double, 2, 6> PointInteraction(const Eigen::Vector2d& s, double Z);

// Of n points, one below the other, 2n x 6, eq. (5.7).
Eigen::MatrixXd PointInteraction(std::span<const ImagePoint> points);

// The twist that brings points from where they are to where they are wanted, in the same order and number,
// eq. (5.6). The depths wanted are not used with the current matrix, nor the present ones with the desired
// matrix, but both must be positive where they are used. Three points leave four solutions and a singular
// cylinder; four in a plane do not.
ServoStep PointServo(std::span<const ImagePoint> now, std::span<const ImagePoint> wanted,
                     InteractionChoice choice, double lambda_per_s, const Inversion& inversion = {});

}  // namespace kestrel::control
