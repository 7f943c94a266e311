// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/kannala_brandt.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vision/camera/distortion/polynomial.h"

namespace kestrel::vision {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

double Distort(const KannalaBrandt& c, double theta) {
  const double t2 = theta * theta;
  return theta * (1 + t2 * (c.k1 + t2 * (c.k2 + t2 * (c.k3 + t2 * c.k4))));
}

double Slope(const KannalaBrandt& c, double theta) {
  const double t2 = theta * theta;
  return 1 + t2 * (3 * c.k1 + t2 * (5 * c.k2 + t2 * (7 * c.k3 + t2 * 9 * c.k4)));
}

std::array<double, 5> SlopeBySquare(const KannalaBrandt& c) {
  return {1, 3 * c.k1, 5 * c.k2, 7 * c.k3, 9 * c.k4};
}

// As far as the polynomial grows.
double OwnMaxAngle(const KannalaBrandt& c) { return std::min(M_PI, std::sqrt(FirstZero(SlopeBySquare(c)))); }

}  // namespace

bool KannalaBrandt::Holds(double theta) const {
  return theta < M_PI && PositiveUpTo(SlopeBySquare(*this), theta * theta);
}

std::optional<Vector2d> KannalaBrandt::Project(const Vector3d& p_CQ, Eigen::Matrix<double, 2, 3>* d_point,
                                               Eigen::Matrix2Xd* d_parameters) const {
  const double r = std::hypot(p_CQ.x(), p_CQ.y()), z = p_CQ.z();
  if (!(r > 0 || z > 0)) return std::nullopt;
  const double theta = std::atan2(r, z);
  if (!(theta <= max_angle_rad) || !Holds(theta)) return std::nullopt;

  const double distorted = Distort(*this, theta);
  const double scale = r > 0 ? distorted / r : 1 / z;  // the plane's point over the space's (x, y)
  const Vector2d m = scale * p_CQ.head<2>(), f(fx, fy);
  if (d_point) {
    const double slope = Slope(*this, theta), square = r * r + z * z;
    const Vector2d outwards = r > 0 ? Vector2d(p_CQ.head<2>() / r) : Vector2d::Zero();
    Eigen::Matrix<double, 2, 3> d_p;  // of m
    d_p.leftCols<2>() =
        scale * Eigen::Matrix2d::Identity() + (slope * z / square - scale) * outwards * outwards.transpose();
    d_p.col(2) = -slope * r / square * outwards;
    *d_point = f.asDiagonal() * d_p;
  }
  if (d_parameters) {
    d_parameters->resize(2, 8);
    d_parameters->leftCols<4>() << m.x(), 0, 1, 0, 0, m.y(), 0, 1;
    const Vector2d outwards = r > 0 ? Vector2d(p_CQ.head<2>() / r) : Vector2d::Zero();
    double power = theta;
    for (int i = 4; i < 8; ++i) {
      power *= theta * theta;
      d_parameters->col(i) = power * f.cwiseProduct(outwards);
    }
  }
  return f.cwiseProduct(m) + Vector2d(cx, cy);
}

std::optional<Vector3d> KannalaBrandt::Ray(const Vector2d& uv, Eigen::Matrix<double, 3, 2>* d_pixel) const {
  const Vector2d m((uv.x() - cx) / fx, (uv.y() - cy) / fy);
  const double distorted = m.norm();
  const auto theta = Theta(distorted);
  if (!theta || !(*theta <= max_angle_rad)) return std::nullopt;
  Vector3d ray(0, 0, std::cos(*theta));
  if (distorted > 0) ray.head<2>() = std::sin(*theta) / distorted * m;
  if (d_pixel) {
    Eigen::Matrix<double, 2, 3> d_point;
    if (!Project(ray, &d_point)) return std::nullopt;
    *d_pixel = RayJacobian(ray, d_point);
  }
  return ray;
}

// Newton's method from the axis, with steps cut so that they stay in the domain and come nearer.
std::optional<double> KannalaBrandt::Theta(double distorted) const {
  bool reachable = false;
  double theta = 0, left = distorted;
  for (int i = 0; i < 100 && std::abs(left) > 1e-15; ++i) {
    const double step = left / Slope(*this, theta);
    double share = 1;
    for (; share > 1e-18; share /= 2) {
      const double next = theta + share * step, next_left = distorted - Distort(*this, next);
      if (!Holds(next)) {  // asked once, for it takes its time
        if (!reachable && distorted > Distort(*this, OwnMaxAngle(*this))) return std::nullopt;
        reachable = true;
        continue;
      }
      if (!(std::abs(next_left) < std::abs(left))) continue;
      theta = next, left = next_left;
      break;
    }
    if (share <= 1e-18) break;
  }
  if (!(std::abs(left) <= 1e-12)) return std::nullopt;
  return theta;
}

double KannalaBrandt::MaxAngle() const { return std::min(max_angle_rad, OwnMaxAngle(*this)); }

std::vector<std::string> KannalaBrandt::ParameterNames() const {
  return {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"};
}
Eigen::VectorXd KannalaBrandt::Parameters() const {
  return Eigen::Matrix<double, 8, 1>(fx, fy, cx, cy, k1, k2, k3, k4);
}
void KannalaBrandt::SetParameters(const Eigen::VectorXd& all) {
  fx = all[0], fy = all[1], cx = all[2], cy = all[3];
  k1 = all[4], k2 = all[5], k3 = all[6], k4 = all[7];
}

}  // namespace kestrel::vision
