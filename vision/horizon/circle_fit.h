// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

// The horizon is a small circle of the unit sphere about "down": ray . down = sin(dip).
namespace kestrel::vision {

// Thesis (6.15): the plane z = n_x x + n_y y + d that lies best to the points, by least squares in z. None:
// fewer than three points, or all on a line as seen along z.
struct PlaneFit {
  double n_x = 0, n_y = 0, d = 0;
  // (6.16) with its slips put right: the normal of that plane is (-n_x, -n_y, 1), not (n_x, n_y, 1).
  Eigen::Vector3d Down() const { return Eigen::Vector3d(-n_x, -n_y, 1).normalized(); }
};
std::optional<PlaneFit> FitPlane(const std::vector<Eigen::Vector3d>& points);

// A contour by azimuth and elevation about an approximate vertical, rad.
struct ContourPoint {
  double azimuth = 0, elevation = 0;
  double weight = 1;  // how far it is believed, 0 to 1
};

// How a contour strays from the horizon. Whatever stands before it raises it: most points scatter narrowly
// about the circle, the others lie above it, exponentially fewer with height, and a few are plain wrong.
struct CircleFitOptions {
  double hill_scale = 0.018, tall_scale = 0.20;  // mean heights of hills and of trees, houses, ridges, rad
  double hill_share = 0.35, tall_share = 0.25;   // of the points, beforehand
  double min_scatter = 0.001;                    // of the points on the circle, rad
  double max_scatter = 0.008;                    // rad
  double dip = 0.005;                            // expected, rad
  double dip_over_sigma = 0.008;   // rad: the horizon of a greater height; more in haze, which hides it
  double dip_under_sigma = 0.006;  // rad: hills all round
  double min_sigma = 0.0006;       // of the answer: what repeats from azimuth to azimuth, such as the lens
  double relief_share = 0.55;      // of the contour's unevenness, in the deviation of the answer
  double raised_share = 0.3;       // of what the circle stands above or below the expected, likewise
  // For a short arc: what lifts or tilts all of it leaves no trace in its own unevenness. Deviation (rad) of
  // the contour from the circle beforehand, and how much of its unevenness and of what it stands above or
  // below the expected dip adds to that; alike over about arc_correlation of azimuth (rad). 0: not a short
  // arc.
  double arc_relief = 0, arc_unevenness_share = 0.7, arc_raised_share = 0.5, arc_correlation = 0.7;
  int azimuths = 240;  // all round, of which the contour's points are some
  // Only circles whose (a, b) lies within reach of this are looked for, if it is known beforehand.
  Eigen::Vector2d near = Eigen::Vector2d::Zero();
  double reach = 0.5;         // rad
  double near_weight = 0;     // of the points, that a circle at the end of the reach must win over
  double correlation = 0.35;  // azimuth over which points err alike at most, rad
};

// The contour as elevation = -dip + a cos(azimuth) + b sin(azimuth): a and b tilt the vertical.
struct CircleFit {
  Eigen::Vector3d state = Eigen::Vector3d::Zero();  // (a, b, -dip), rad
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double scatter = 0;           // of the points on the circle, rad
  double on_circle = 0;         // share of the points within a degree of the circle, by weight
  double unevenness = 0;        // root mean square of the lower edge's residuals, arc by arc, rad
  double below = 0;             // share of the points more than a degree below the circle
  double explained = 0;         // how well the points are, 0 to 1 each, summed up by weight
  double strain = 0;            // of the dip, in its deviations beforehand
  double rival = 0;             // how nearly as good the best circle elsewhere is, 0 to 1
  std::vector<double> belongs;  // per point, 0 to 1
};
// The contour in the order of its azimuths, 0 to 2 pi. Consensus of random triples (of a fixed seed), then
// the maximum of the likelihood. None: fewer than eight points.
std::optional<CircleFit> FitCircle(const std::vector<ContourPoint>& contour,
                                   const CircleFitOptions& options = {});

}  // namespace kestrel::vision
