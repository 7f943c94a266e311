// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "control/law/twist.h"

// The law of image-based visual servoing, thesis 5.2.3, eq. (5.6): velocity = -lambda L^+ e.
namespace kestrel::control {

enum class ServoState {
  kRegular,           // L has the rank that its size allows
  kSingular,          // it has not: the velocity leaves out the directions that the features do not see
  kNoFeatures,        // no velocity
  kDepthNotPositive,  // a point behind the camera: no velocity
  kNotFinite,         // of the features, lambda or the velocity: no velocity
};
const char* NameOf(ServoState state);

// Singular values below ratio times the largest count as zero. Those above are inverted as
// s / (s^2 + (damping * largest)^2): with a damping the velocity stays bounded on the way into a
// singularity, and the decrease of the error is no longer quite exponential.
struct Inversion {
  double ratio = 1e-6;
  double damping = 0;
};

struct ServoStep {
  ServoState state = ServoState::kNoFeatures;
  Eigen::VectorXd velocity;  // one for each column of L; zero where the state says that there is none
  int rank = 0;
  double conditioning = 0;  // minimum over maximum singular value
  // The share of the error that any velocity can change, |L L^+ e| / |e|: near 0 in a local minimum, where
  // the features stand still away from their goal. 1 where there is no error.
  double reach = 0;
};

// L: the interaction matrix, n x m, de/dt = L velocity; e: the error s - s*, n. Never throws.
ServoStep ServoVelocity(const Eigen::MatrixXd& L, const Eigen::VectorXd& e, double lambda_per_s,
                        const Inversion& inversion = {});

// A step for all six degrees of freedom as a twist.
Twist TwistOf(const ServoStep& step);

// Which matrix stands for L: the current one needs the depths now; the desired one is constant and needs
// those at the goal; their mean (Malis) is of second order, and lessens the camera's retreat.
enum class InteractionChoice { kCurrent, kDesired, kMean };
Eigen::MatrixXd Choose(InteractionChoice choice, const Eigen::MatrixXd& L_now,
                       const Eigen::MatrixXd& L_wanted);

}  // namespace kestrel::control
