// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "geometry/tait_bryan.h"
#include "vision/camera_model.h"

namespace kestrel {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

struct Case {
  std::string name;
  CameraModel camera;
};
std::ostream& operator<<(std::ostream& out, const Case& each) { return out << each.name; }

// Every model over the range of its own parameters. Images of 640 x 480.
std::vector<Case> Cases() {
  const auto brown = [](double k1, double k2, double p1, double p2, double k3) {
    return BrownConrady{640, 480, 458, 457, 330, 245, k1, k2, p1, p2, k3};
  };
  const auto unified = [](double f, double xi) { return Unified{640, 480, f, f + 2, 325, 236, xi}; };
  const auto fisheye = [](double k1, double k2, double k3, double k4) {
    return KannalaBrandt{640, 480, 190, 191, 322, 238, k1, k2, k3, k4};
  };
  const auto spheres = [](double xi, double alpha) {
    return DoubleSphere{640, 480, 180, 181, 318, 243, xi, alpha};
  };
  Pinhole narrow{640, 480, 810, 790, 300, 250};
  narrow.max_angle_rad = Radians(25);
  Unified distorted = unified(400, 1.6), mirror = unified(200, 0.9), skewed = unified(250, 0.8);
  distorted.k1 = -0.2, distorted.k2 = 0.05, distorted.p1 = 1e-3, distorted.p2 = -2e-3;
  mirror.max_angle_rad = Radians(110);
  skewed.skew = 3;
  KannalaBrandt lens = fisheye(-0.01, 0.002, -0.001, 0.0001);
  lens.max_angle_rad = Radians(95);
  return {{"pinhole", Pinhole{640, 480, 810, 790, 300, 250}},
          {"pinhole_narrow", narrow},
          {"brown_none", brown(0, 0, 0, 0, 0)},
          {"brown_barrel", brown(-0.283, 0.0739, 2e-4, 1.8e-5, 0)},
          {"brown_folding", brown(-0.3, 0, 0, 0, 0)},
          {"brown_folding_tangential", brown(-0.3, 0.02, 3e-3, -2e-3, 0)},
          {"brown_pincushion", brown(0.2, 0.1, -1e-3, 1e-3, 0.05)},
          {"brown_k3", brown(-0.35, 0.15, 0, 0, -0.03)},
          {"unified_pinhole", unified(500, 0)},
          {"unified_hyperbolic", unified(220, 0.7)},
          {"unified_parabolic", unified(150, 1)},
          {"unified_beyond", unified(400, 1.8)},
          {"unified_distorted", distorted},
          {"unified_limited", mirror},
          {"unified_skewed", skewed},
          {"kannala_none", fisheye(0, 0, 0, 0)},
          {"kannala_usual", fisheye(-0.013, 0.02, -0.012, 0.0025)},
          {"kannala_folding", fisheye(-0.05, 0, 0, 0)},
          {"kannala_limited", lens},
          {"spheres_usual", spheres(-0.18, 0.59)},
          {"spheres_apart", spheres(0.3, 0.7)},
          {"spheres_flat", spheres(-0.2, 0.4)},
          {"spheres_half", spheres(0.1, 0.5)},
          {"spheres_pinhole", spheres(0, 0)}};
}

Vector3d Direction(double theta, double azimuth) {
  return {std::sin(theta) * std::cos(azimuth), std::sin(theta) * std::sin(azimuth), std::cos(theta)};
}

double AngleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

class CameraModels : public testing::TestWithParam<Case> {
 protected:
  const CameraModel& camera() const { return GetParam().camera; }
};

TEST_P(CameraModels, TheRayOfAProjectedPointIsItsDirectionOverTheWholeDomain) {
  const double limit = MaxAngle(camera());
  ASSERT_GT(limit, Radians(20));
  int tried = 0, returned = 0;
  for (int i = 0; i < 250; ++i) {
    for (int j = 0; j < 24; ++j) {
      const Vector3d direction = Direction(limit * (i + 0.5) / 250, 2 * M_PI * (j + 0.3) / 24);
      ++tried;
      const auto uv = Project(camera(), (0.01 + i) * direction);
      if (!uv) continue;
      Eigen::Matrix<double, 3, 2> d_pixel;
      const auto ray = Ray(camera(), *uv, &d_pixel);
      if (!ray) continue;
      ++returned;
      EXPECT_NEAR(ray->norm(), 1, 1e-14);
      // What the rounding of the pixel itself does to the ray, and that of a unit vector.
      const double rounding = 1e-13 + 20 * kEpsilon * (1 + uv->norm()) * d_pixel.norm();
      EXPECT_LT(AngleBetween(*ray, direction), rounding)
          << "at " << Degrees(limit * (i + 0.5) / 250) << " deg";
    }
  }
  EXPECT_EQ(tried, 6000);
  EXPECT_EQ(returned, tried);
}

INSTANTIATE_TEST_SUITE_P(All, CameraModels, testing::ValuesIn(Cases()),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace kestrel
