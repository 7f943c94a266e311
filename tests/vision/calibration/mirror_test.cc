// SPDX-License-Identifier: Apache-2.0
// The mirrors against rays that are traced off their surfaces by the law of reflection: nothing here but the
// expectations knows the unified model.
#include "vision/calibration/mirror.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <optional>

#include "base/diagnostics.h"
#include "geometry/tait_bryan.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A surface f = 0.
using Surface = std::function<double(const Vector3d&)>;

// A ray and the mirror: where they meet, and where the ray goes from there.
struct Reflection {
  Vector3d point, direction;
};

// The first meeting beyond a distance, by marching and bisection; the normal by differences.
std::optional<Reflection> Reflect(const Surface& f, const Vector3d& from, const Vector3d& direction,
                                  double after, double until) {
  const double step = (until - after) / 4000;
  double low = after;
  while (low < until &&
         std::signbit(f(from + low * direction)) == std::signbit(f(from + (low + step) * direction))) {
    low += step;
  }
  if (low >= until) return std::nullopt;
  double high = low + step;
  const bool negative = std::signbit(f(from + low * direction));
  for (double middle = (low + high) / 2; middle > low && middle < high; middle = (low + high) / 2) {
    (std::signbit(f(from + middle * direction)) == negative ? low : high) = middle;
  }
  const Vector3d q = from + low * direction;
  Vector3d normal;
  for (int k = 0; k < 3; ++k) {
    const auto at = [&](double h) { return f(q + h * Vector3d::Unit(k)); };
    constexpr double kStep = 1e-3;
    normal[k] = (8 * (at(kStep) - at(-kStep)) - (at(2 * kStep) - at(-2 * kStep))) / (12 * kStep);
  }
  normal.normalize();
  return Reflection{q, direction - 2 * normal.dot(direction) * normal};
}

double DistanceFromLine(const Vector3d& point, const Vector3d& on_line, const Vector3d& direction) {
  return (point - on_line).cross(direction).norm();
}

const HyperbolicMirror kThesisMirror = *DesignMirror(0.02, 0.1, 2);

TEST(Mirror, ThesisDesign) {
  // Eq. (6.14) prints 39.2922 and 19.6461 mm; its own formula gives 39.29203 and 19.64602.
  EXPECT_NEAR(kThesisMirror.a_m, 39.2922e-3, 2e-7);
  EXPECT_NEAR(kThesisMirror.b_m, 19.6461e-3, 1e-7);
  EXPECT_NEAR(kThesisMirror.b_m, 0.1 * std::sqrt(5) - 2 * std::sqrt(0.1 * 0.1 + 0.02 * 0.02), 1e-15);
  EXPECT_NEAR(FocalLengthPx(0.02, 0.1, 240) * 0.01e-3, 12e-3, 1e-15);  // a 12 mm lens on pixels of 0.01 mm
}

TEST(Mirror, DesignedRimIsAtItsHeightAndOnTheSurface) {
  for (const double ratio : {0.5, 1.0, 2.0, 2.5, 3.0, 4.9}) {
    const auto mirror = DesignMirror(0.02, 0.1, ratio);
    ASSERT_TRUE(mirror) << ratio;
    EXPECT_NEAR(mirror->a_m / mirror->b_m, ratio, 1e-12);
    EXPECT_NEAR(mirror->HeightM(), 0.1, 1e-15);
    const double e = mirror->EccentricityM(), a = mirror->a_m, b = mirror->b_m;
    EXPECT_NEAR(std::pow((0.1 - e) / a, 2) - std::pow(0.02 / b, 2), 1, 1e-9);  // eq. (6.12)
    EXPECT_GT(0.1 - e, 0);  // on the sheet that is far from the camera
    EXPECT_LT(mirror->ApexM(), 0.1);
  }
  EXPECT_FALSE(DesignMirror(0.02, 0.1, 5));
  EXPECT_FALSE(DesignMirror(0.02, 0.1, 6));
}

TEST(Mirror, RaysTracedOffTheHyperboloidShowItsSingleViewpointAndTheUnifiedPixel) {
  const HyperbolicMirror& mirror = kThesisMirror;
  const double focal_px = FocalLengthPx(0.02, 0.1, 240);
  const Unified camera = CameraOf(mirror, focal_px, 640, 480);
  const double a = mirror.a_m * 1e3, b = mirror.b_m * 1e3, e = mirror.EccentricityM() * 1e3;
  // In mm and in C: F is the origin, F' at z = 2 e, eq. (6.7) with its z reversed, the sheet around F.
  const Surface hyperboloid = [&](const Vector3d& q) {
    return q.z() - e + a * std::sqrt(1 + (q.x() * q.x() + q.y() * q.y()) / (b * b));
  };
  const Vector3d camera_centre(0, 0, 2 * e);

  int traced = 0, on_mirror = 0;
  double least_cosine = 1;
  for (double v = -239; v <= 239; v += 7) {
    for (double u = -239; u <= 239; u += 7) {
      ++traced;
      // The real camera looks along -z; with x in common, its rows go down along -y.
      const Vector3d direction = Vector3d(u / focal_px, -v / focal_px, -1).normalized();
      const Vector2d raw(319.5 + u, 239.5 + v), flipped(raw.x(), 479 - raw.y());
      const auto reflection = Reflect(hyperboloid, camera_centre, direction, 50, 200);
      ASSERT_TRUE(reflection);
      const bool within_rim = reflection->point.head<2>().norm() <= 20;
      // The single viewpoint: every reflected ray goes through F when it is drawn backwards.
      EXPECT_LT(DistanceFromLine(Vector3d::Zero(), reflection->point, reflection->direction), 1e-8);
      EXPECT_GT(reflection->direction.dot(reflection->point), 0);
      // And what lies anywhere along it is seen at its pixel, if the mirror goes so far.
      for (const double distance : {0.0, 100.0, 1e5}) {
        const auto uv = camera.Project(reflection->point + distance * reflection->direction);
        ASSERT_EQ(uv.has_value(), within_rim) << u << ' ' << v;
        if (!uv) continue;
        EXPECT_LT((*uv - flipped).norm(), 1e-7);
      }
      if (!within_rim) continue;
      ++on_mirror;
      least_cosine = std::min(least_cosine, reflection->direction.z());
    }
  }
  EXPECT_EQ(traced, 69 * 69);
  EXPECT_GT(on_mirror, 3500);
  EXPECT_NEAR(std::acos(least_cosine), mirror.ViewAngle(), Radians(0.3));
  EXPECT_NEAR(Degrees(mirror.ViewAngle()), 121.26, 0.01);  // eq. (6.8): 90 deg + atan(12.14 mm / 20 mm)
}

TEST(Mirror, TheModelsFolderHasTheThesisMirror) {
  Mistakes mistakes;
  const CameraModel file = LoadCamera(
      std::filesystem::path(KESTREL_SOURCE_DIR) / "models/cameras/hyperbolic_mirror.yaml", mistakes);
  ASSERT_TRUE(mistakes.empty());
  const Unified camera = CameraOf(kThesisMirror, FocalLengthPx(0.02, 0.1, 240), 640, 480);
  EXPECT_LT((Parameters(file) - camera.Parameters()).norm(), 1e-12);
  EXPECT_NEAR(MaxAngle(file), camera.MaxAngle(), 1e-14);
}

TEST(Mirror, TheRimIsAsLargeInTheImageAsItWasAskedFor) {
  const Unified camera = CameraOf(kThesisMirror, FocalLengthPx(0.02, 0.1, 240), 640, 480);
  const double rim = kThesisMirror.ViewAngle() - 1e-12;
  EXPECT_NEAR(camera.Project({std::sin(rim), 0, std::cos(rim)})->x() - 319.5, 240, 1e-8);
}

// A conic mirror and a camera (orthographic for the parabola) at unit focal length, in C, and what table 6.1
// makes of it. Every ray of the camera must come from the direction that Barreto's model says.
void ExpectBarreto(const Mirror& mirror, const Surface& surface, bool orthographic) {
  const BarretoParameters barreto = BarretoOf(mirror);
  const GeyerParameters geyer = GeyerOf(barreto);
  int traced = 0;
  for (double x = -0.31; x < 0.31; x += 0.0413) {
    for (double y = -0.31; y < 0.31; y += 0.0417) {
      const Vector3d from = orthographic ? Vector3d(x, y, 20) : Vector3d(0, 0, mirror.d);
      const Vector3d direction = orthographic ? Vector3d(0, 0, -1) : Vector3d(x, y, -1).normalized();
      const auto reflection = Reflect(surface, from, direction, 0.01, 40);
      ASSERT_TRUE(reflection) << x << ' ' << y;
      EXPECT_LT(DistanceFromLine(Vector3d::Zero(), reflection->point, reflection->direction), 1e-9);
      ++traced;
      // Something far away in the direction from which the light came.
      const Vector3d X = 1e9 * reflection->direction;
      const double scale = (barreto.psi - barreto.xi) / (X.z() + barreto.xi * X.norm());  // eq. (6.3)
      EXPECT_LT((scale * X.head<2>() - Vector2d(x, y)).norm(), 1e-8) << x << ' ' << y;
      const double same = (geyer.l + geyer.m) / (geyer.l * X.norm() + X.z());  // eq. (6.1), its z reversed
      EXPECT_NEAR(same / scale, 1, 1e-12);
      // Mei's form is the unified camera, whose focal length has no sign.
      const double gamma = GammaOf(barreto, 1), sign = std::copysign(1, barreto.psi - barreto.xi);
      const auto uv = Unified{100, 100, gamma, gamma, 0, 0, barreto.xi}.Project(X);
      ASSERT_TRUE(uv);
      EXPECT_LT((sign * *uv - Vector2d(x, y)).norm(), 1e-8);
    }
  }
  EXPECT_EQ(traced, 16 * 15);
}

TEST(Mirror, HyperbolicMirrorIsAsTable61Says) {
  const double a = 1.3, b = 0.8, e = std::hypot(a, b);
  ExpectBarreto(
      {Mirror::Kind::kHyperbolic, 2 * e, b * b / (2 * a)},
      [&](const Vector3d& q) {
        return q.z() - e + a * std::sqrt(1 + (q.x() * q.x() + q.y() * q.y()) / (b * b));
      },
      false);
}

// The light passes the focus before it meets the far side of the ellipsoid.
TEST(Mirror, EllipticalMirrorIsAsTable61Says) {
  const double a = 1.5, b = 0.9, e = std::sqrt(a * a - b * b);
  ExpectBarreto(
      {Mirror::Kind::kElliptical, 2 * e, b * b / (2 * a)},
      [&](const Vector3d& q) {
        return std::pow((q.z() - e) / a, 2) + (q.x() * q.x() + q.y() * q.y()) / (b * b) - 1;
      },
      false);
}

TEST(Mirror, ParabolicMirrorIsAsTable61Says) {
  const double p = 0.35;  // latus rectum 4 p, focal distance p
  ExpectBarreto(
      {Mirror::Kind::kParabolic, 0, p},
      [&](const Vector3d& q) { return q.z() - p + (q.x() * q.x() + q.y() * q.y()) / (4 * p); }, true);
}

TEST(Mirror, PlanarMirrorIsAsTable61Says) {
  Mirror mirror{Mirror::Kind::kPlanar, 0.6, 0};  // half way between the camera and its image
  ExpectBarreto(
      mirror, [&](const Vector3d& q) { return q.z() - 0.3; }, false);
}

TEST(Mirror, EllipsesAndHyperbolasMeetInTheParabola) {
  // Both tend to it as the other focus goes away, when the camera's focal length grows with its distance.
  const double p = 0.35;
  const BarretoParameters parabola = BarretoOf({Mirror::Kind::kParabolic, 0, p});
  for (const auto kind : {Mirror::Kind::kHyperbolic, Mirror::Kind::kElliptical}) {
    const BarretoParameters far = BarretoOf({kind, 1e6, p});
    EXPECT_NEAR(far.xi, parabola.xi, 1e-6);
    EXPECT_NEAR(GammaOf(far, 1e6), GammaOf(parabola, 1), 1e-6);
  }
}

}  // namespace
}  // namespace kestrel::vision
