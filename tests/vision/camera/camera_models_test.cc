// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "geometry/tait_bryan.h"
#include "vision/camera/camera_model.h"
#include "vision/camera/extended_unified.h"
#include "vision/camera/fov.h"
#include "vision/camera/rational.h"

namespace kestrel::vision {
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
  return {
      {"pinhole", Pinhole{640, 480, 810, 790, 300, 250}},
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
      {"spheres_pinhole", spheres(0, 0)},
      {"fov_narrow", AddedModel(Fov{640, 480, 400, 401, 322, 238, 0.2})},
      {"fov_wide", AddedModel(Fov{640, 480, 334, 333, 322, 238, 0.96})},
      {"extended_usual", AddedModel(ExtendedUnified{640, 480, 300, 301, 322, 238, 0.6, 1.12})},
      {"extended_flat", AddedModel(ExtendedUnified{640, 480, 300, 301, 322, 238, 0.4, 0.8})},
      {"extended_half", AddedModel(ExtendedUnified{640, 480, 200, 201, 322, 238, 0.5, 1.5})},
      {"rational_usual",
       AddedModel(Rational{640, 480, 458, 457, 330, 245, {0.2, -0.1, 1e-3, -1e-3, 0.01, 0.4, 0.05, 0.02}})},
      {"rational_folding",
       AddedModel(Rational{640, 480, 458, 457, 330, 245, {-0.28, 0.07, 2e-4, 1e-5, 0, 0.05, 0.02, 0.01}})},
      {"rational_pole", AddedModel(Rational{640, 480, 458, 457, 330, 245, {0.1, 0, 0, 0, 0, -0.3, 0, 0}})}};
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

TEST_P(CameraModels, APixelHasARayJustWhenItLiesInThePictureOfTheDomain) {
  // The rim of the picture as the outermost circle of directions, except where the picture has no end.
  const double limit = MaxAngle(camera());
  std::vector<cv::Point2f> rim;
  bool bounded = true;
  for (int j = 0; j < 720 && bounded; ++j) {
    const auto uv = Project(camera(), Direction(limit * (1 - 1e-9), 2 * M_PI * j / 720));
    bounded = uv && uv->norm() < 1e5;
    if (bounded) rim.emplace_back(static_cast<float>(uv->x()), static_cast<float>(uv->y()));
  }
  int with_ray = 0, tried = 0;
  for (double v = -1000; v < 1500; v += 39.7) {
    for (double u = -1000; u < 1700; u += 41.3) {
      const double inside = bounded ? cv::pointPolygonTest(rim, cv::Point2f(u, v), true) : 1;
      if (std::abs(inside) < 0.05) continue;  // the rim is a polygon
      ++tried;
      const auto ray = Ray(camera(), {u, v});
      EXPECT_EQ(ray.has_value(), inside > 0) << u << ' ' << v;
      if (!ray) continue;
      ++with_ray;
      EXPECT_LE(AngleFromAxis(*ray), limit);
      const auto back = Project(camera(), 3 * *ray);
      ASSERT_TRUE(back) << u << ' ' << v;
      EXPECT_LT((*back - Vector2d(u, v)).norm(), 1e-9) << u << ' ' << v;
    }
  }
  EXPECT_GT(tried, 4000);
  EXPECT_GT(with_ray, 100);
}

// The derivative of f at x by central differences of fourth order.
template <class Function>
auto Derivative(const Function& f, double h) {
  return ((8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h)).eval();
}

TEST_P(CameraModels, TheJacobiansAreTheNumericDerivatives) {
  const double limit = MaxAngle(camera());
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 8; ++j) {
      const Vector3d p_CQ = 2 * Direction(0.9 * limit * i / 20, 2 * M_PI * (j + 0.3) / 8);
      Eigen::Matrix<double, 2, 3> d_point;
      Eigen::Matrix2Xd d_parameters;
      const auto uv = Project(camera(), p_CQ, &d_point, &d_parameters);
      ASSERT_TRUE(uv);
      // Differences lose eps |uv| / h to rounding.
      const double tolerance = 1e-8 * (1 + uv->norm());
      for (int k = 0; k < 3; ++k) {
        const Vector2d numeric = Derivative(
            [&](double h) { return Project(camera(), p_CQ + h * Vector3d::Unit(k)).value(); }, 1e-4);
        EXPECT_LT((d_point.col(k) - numeric).norm(), tolerance * (1 + d_point.norm())) << "point " << k;
      }
      const Eigen::VectorXd parameters = Parameters(camera());
      const auto names = ParameterNames(camera());
      ASSERT_EQ(d_parameters.cols(), parameters.size());
      ASSERT_EQ(names.size(), static_cast<std::size_t>(parameters.size()));
      for (int k = 0; k < parameters.size(); ++k) {
        const Vector2d numeric = Derivative(
            [&](double h) {
              CameraModel changed = camera();
              SetParameters(changed, parameters + h * Eigen::VectorXd::Unit(parameters.size(), k));
              return Project(changed, p_CQ).value();
            },
            1e-6);
        EXPECT_LT((d_parameters.col(k) - numeric).norm(), tolerance * (1 + d_parameters.col(k).norm()))
            << names[static_cast<std::size_t>(k)];
      }
      Eigen::Matrix<double, 3, 2> d_pixel;
      ASSERT_TRUE(Ray(camera(), *uv, &d_pixel));
      for (int k = 0; k < 2; ++k) {
        const Vector3d numeric =
            Derivative([&](double h) { return Ray(camera(), *uv + h * Vector2d::Unit(k)).value(); }, 1e-2);
        EXPECT_LT((d_pixel.col(k) - numeric).norm(), 1e-9) << "pixel " << k;
      }
    }
  }
}

TEST_P(CameraModels, TheDomainEndsWhereItSaysIt) {
  const double limit = MaxAngle(camera());
  for (int j = 0; j < 12; ++j) {
    const double azimuth = 2 * M_PI * j / 12;
    EXPECT_TRUE(Project(camera(), Direction(limit - 1e-7, azimuth)));
    EXPECT_FALSE(Project(camera(), Direction(std::min(limit + 1e-7, M_PI), azimuth)));
  }
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Project(camera(), Vector3d(0, 0, 0)));
  EXPECT_FALSE(Project(camera(), Vector3d(0, 0, -1)));
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(Project(camera(), Vector3d(1, 1, 5) + kNan * Vector3d::Unit(k)));
  EXPECT_FALSE(Ray(camera(), {kNan, 0}));
  EXPECT_FALSE(Ray(camera(), {0, kNan}));
}

TEST_P(CameraModels, ALensWithoutLimitShowsAllUntilThePictureFoldsOrEndsOrMeetsBehind) {
  CameraModel open = camera();
  std::visit(
      [](auto& c) {
        if constexpr (requires { c.max_angle_rad; }) c.max_angle_rad = kNoLimit;
      },
      open);
  const double limit = MaxAngle(open);
  if (limit == M_PI) return;
  // Its plane at unit distance ends at a right angle, and its picture there before infinity.
  if (std::string(NameOf(open)) == Fov::kName) {
    EXPECT_EQ(limit, M_PI / 2);
    return;
  }
  double least_slope = kNoLimit, least_radius = kNoLimit;
  const Vector2d centre = *Project(open, {0, 0, 1});
  for (int j = 0; j < 720; ++j) {
    Eigen::Matrix<double, 2, 3> d_point;
    const double azimuth = 2 * M_PI * j / 720;
    const auto uv = Project(open, Direction(limit - 1e-7, azimuth), &d_point);
    ASSERT_TRUE(uv);
    least_slope = std::min(least_slope, (d_point * Direction(limit + M_PI / 2, azimuth)).norm());
    least_radius = std::min(least_radius, (*uv - centre).norm());
  }
  // Within 1e-7 rad of a fold the slope is some 1e-7 of the focal length, or its root. A picture that ends
  // goes to infinity there, at least as the inverse of the root.
  EXPECT_TRUE(least_slope < 0.5 || least_radius > 1e5) << least_slope << ' ' << least_radius;
}

TEST_P(CameraModels, TheCentreIsOnTheAxis) {
  const Eigen::VectorXd parameters = Parameters(camera());
  EXPECT_EQ(*Project(camera(), {0, 0, 7}), Vector2d(parameters[2], parameters[3]));
  EXPECT_LT((*Ray(camera(), {parameters[2], parameters[3]}) - Vector3d(0, 0, 1)).norm(), 1e-15);
}

TEST_P(CameraModels, ThePixelDoesNotDependOnTheDistance) {
  const Vector3d direction = Direction(0.7 * MaxAngle(camera()), 1);
  const Vector2d uv = *Project(camera(), direction);
  for (const double distance : {1e-3, 1.0, 1e4}) {
    EXPECT_LT((*Project(camera(), distance * direction) - uv).norm(), 1e-12 * (1 + uv.norm()));
  }
}

// So that the round trip above is known to have gone beyond 180 degrees.
TEST(CameraModelCases, HalfOfThemSeeMoreThanHalfOfTheSphere) {
  int wide = 0, all_around = 0;
  for (const Case& each : Cases()) {
    wide += MaxAngle(each.camera) > Radians(91);
    all_around += MaxAngle(each.camera) == M_PI;
  }
  EXPECT_EQ(wide, 17);
  EXPECT_EQ(all_around, 5);
}

INSTANTIATE_TEST_SUITE_P(All, CameraModels, testing::ValuesIn(Cases()),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace kestrel::vision
