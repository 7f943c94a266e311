// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/mirror.h"

#include <cmath>

namespace kestrel::vision {

BarretoParameters BarretoOf(const Mirror& mirror) {
  const double d = mirror.d, p = mirror.p, root = std::hypot(d, 2 * p);
  switch (mirror.kind) {
    case Mirror::Kind::kParabolic:
      return {1, 1 + 2 * p};
    case Mirror::Kind::kHyperbolic:
      return {d / root, (d + 2 * p) / root};
    case Mirror::Kind::kElliptical:
      return {d / root, (d - 2 * p) / root};
    case Mirror::Kind::kPlanar:
      break;
  }
  return {0, 1};
}

GeyerParameters GeyerOf(const BarretoParameters& barreto) {
  return {barreto.xi, barreto.psi - 2 * barreto.xi};
}

double GammaOf(const BarretoParameters& barreto, double f) {
  return std::abs(f * (barreto.psi - barreto.xi));
}

double HyperbolicMirror::EccentricityM() const { return std::hypot(a_m, b_m); }
double HyperbolicMirror::HeightM() const {
  return EccentricityM() + a_m / b_m * std::hypot(b_m, rim_radius_m);
}
double HyperbolicMirror::ApexM() const { return EccentricityM() + a_m; }
double HyperbolicMirror::ViewAngle() const {
  return M_PI / 2 + std::atan((HeightM() - 2 * EccentricityM()) / rim_radius_m);
}
Mirror HyperbolicMirror::Conic() const {
  return {Mirror::Kind::kHyperbolic, 2 * EccentricityM(), b_m * b_m / (2 * a_m)};
}

std::optional<HyperbolicMirror> DesignMirror(double rim_radius_m, double height_m, double ratio) {
  const double b = height_m * std::hypot(ratio, 1) - ratio * std::hypot(height_m, rim_radius_m);
  if (!(height_m > ratio * rim_radius_m && b > 0)) return std::nullopt;
  return HyperbolicMirror{ratio * b, b, rim_radius_m};
}

double FocalLengthPx(double rim_radius_m, double height_m, double rim_radius_px) {
  return height_m * rim_radius_px / rim_radius_m;
}

Unified CameraOf(const HyperbolicMirror& mirror, double focal_px, int width_px, int height_px) {
  const BarretoParameters barreto = BarretoOf(mirror.Conic());
  Unified camera;
  camera.width_px = width_px, camera.height_px = height_px;
  camera.fx = camera.fy = GammaOf(barreto, focal_px);
  camera.cx = (width_px - 1) / 2.0, camera.cy = (height_px - 1) / 2.0;
  camera.xi = barreto.xi;
  camera.max_angle_rad = mirror.ViewAngle();
  return camera;
}

}  // namespace kestrel::vision
