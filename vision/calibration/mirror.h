// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "vision/camera/unified.h"

// Mirrors that keep one viewpoint in front of a camera, thesis 6.2, and the design of a hyperbolic
// one, 6.2.1.
//
// F, the focus inside the mirror, is the effective viewpoint and the origin of C, whose z points out of the
// mirror, to the camera at the other focus F'. A real camera there sees the world reversed: its rows count
// the other way than C's. The cameras here give the image after that flip (an elliptical mirror's also turned
// by half a turn), so all their focal lengths are positive.
namespace kestrel::vision {

// A conic mirror by what table 6.1 asks for.
struct Mirror {
  enum class Kind { kParabolic, kHyperbolic, kElliptical, kPlanar };
  Kind kind = Kind::kHyperbolic;
  double d = 0;  // between the foci, m; parabolic and planar mirrors have none
  double p = 0;  // a quarter of the latus rectum, m; a planar mirror has none
};

// Barreto's parameters, table 6.1: the projection is (psi - xi) (x, -y) / (z + xi r), in focal lengths.
struct BarretoParameters {
  double xi = 0, psi = 1;
};
BarretoParameters BarretoOf(const Mirror& mirror);

// Geyer's parameters, eq. (6.1): the projection is (l + m) (x, y) / (l r - z), in focal lengths, with z into
// the mirror: l = xi and m = psi - 2 xi.
struct GeyerParameters {
  double l = 0, m = 1;
};
GeyerParameters GeyerOf(const BarretoParameters& barreto);

// Mei's gamma = f (psi - xi), without its sign: the focal length of the unified model, in the unit of f.
// Under a parabolic mirror, f is the orthographic camera's magnification, px/m.
double GammaOf(const BarretoParameters& barreto, double f);

// A hyperbolic mirror (z + e)^2 / a^2 - (x^2 + y^2) / b^2 = 1, eq. (6.7), here with z away from the camera,
// up to a rim.
struct HyperbolicMirror {
  double a_m = 0, b_m = 0;
  double rim_radius_m = 0;

  double EccentricityM() const;  // e = sqrt(a^2 + b^2), half the distance between the foci
  double HeightM() const;        // h, from the camera's centre to the rim, eq. (6.9)
  double ApexM() const;          // from the camera's centre to the nearest point of the mirror
  double ViewAngle() const;      // alpha, of the rim from the axis to the camera, rad, eq. (6.8)
  Mirror Conic() const;
};

// The mirror with that rim at that height and a / b, eq. (6.13). None: height <= ratio * rim_radius, when no
// hyperboloid of that ratio is so flat and so wide.
std::optional<HyperbolicMirror> DesignMirror(double rim_radius_m, double height_m, double ratio);

// The focal length that shows the rim with a radius in px, eq. (6.11), solved for K(1,1).
double FocalLengthPx(double rim_radius_m, double height_m, double rim_radius_px);

// What a camera with square pixels and its axis through the middle of the image sees in the mirror, up to the
// rim.
Unified CameraOf(const HyperbolicMirror& mirror, double focal_px, int width_px, int height_px);

}  // namespace kestrel::vision
