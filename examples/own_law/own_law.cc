// SPDX-License-Identifier: Apache-2.0
// A servo law of one's own, against one of Kestrel's: both bring a camera that looks ahead behind a balloon.
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>

#include "control/law/sphere_target.h"

namespace {

using namespace kestrel::control;

// The law: the image's error falls in a given time wherever it begins, e' = -k e / |e|^(1/2), instead of by the
// exponential that never ends. k: of an error of 1, 1/s.
Eigen::Vector3d FiniteTimeVelocity(const SphereImage& now, const SphereImage& wanted, double Z, double k) {
  const Eigen::Vector3d error = now.Vector() - wanted.Vector();
  const double size = error.norm();
  if (size < 1e-9) return Eigen::Vector3d::Zero();
  return -k / std::sqrt(size) * FollowInverse(now, Z) * error;
}

Eigen::Vector3d Exponential(const SphereImage& now, const SphereImage& wanted, double Z, double lambda) {
  return FollowVelocity(now, wanted, Z, FollowCoupling::kCoupled, Eigen::Vector3d::Constant(lambda)).velocity;
}

// How long until the image is as wanted, s: the loop closed by kinematics alone.
template <class Law>
double Settles_s(Law law, double gain) {
  constexpr double kDiameter_m = 0.5, kStep_s = 0.01, kSettled = 1e-3, kMost_s = 60;
  const SphereImage wanted{{0, 0}, 0.1};
  Eigen::Vector3d p_CT(1.0, -0.4, 8);  // of the balloon in C: x right, y down, z forward
  for (double t_s = 0; t_s < kMost_s; t_s += kStep_s) {
    const SphereImage now = SphereImageOf(p_CT, kDiameter_m);
    if ((now.Vector() - wanted.Vector()).norm() < kSettled) return t_s;
    const Eigen::Vector3d u = law(now, wanted, SphereDepth(now, kDiameter_m), gain);  // v_y, v_z, w_y
    // The balloon stands still, so in C it moves against the camera.
    p_CT -= kStep_s * (Eigen::Vector3d(0, u[0], u[1]) + Eigen::Vector3d(0, u[2], 0).cross(p_CT));
  }
  return kMost_s;
}

}  // namespace

int main() {
  const double exponential_s = Settles_s(Exponential, 0.5), finite_s = Settles_s(FiniteTimeVelocity, 0.2);
  std::printf("exponential  %5.2f s\nfinite time  %5.2f s\n", exponential_s, finite_s);
  return finite_s < exponential_s ? 0 : 1;
}
