// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>

#include "base/yaml/fields.h"

namespace kestrel::sim {

// Worlds with a true horizon, made from numbers and a seed: round ground to beyond the horizon, hills,
// fields, woods, water and snow, trees, buildings, sky, sun, clouds and haze. Angles of azimuth are clockwise
// from north.
//
// Colours are red, green, blue, 0 to 1, as they show in the image.

// A ridge that hides part of the skyline.
struct RidgeParameters {
  double azimuth_deg = 0;    // of its middle
  double height_deg = 0;     // of its crest above the horizontal, from the ground at the origin; 0: none
  double width_deg = 60;     // as seen from the origin; 360: all round
  double distance_m = 5000;  // of its crest
};

inline void Fields(FieldVisitor& v, RidgeParameters& p) {
  v("azimuth_deg", p.azimuth_deg, -360.0, 360.0);
  v("height_deg", p.height_deg, 0.0, 40.0);
  v("width_deg", p.width_deg, 0.0, 360.0);
  v("distance_m", p.distance_m, 1000.0, 40000.0);
}

struct LandscapeParameters {
  std::uint64_t seed = 0;  // 0: the run's

  double sun_azimuth_deg = 150, sun_elevation_deg = 45;
  double light = 1;                            // of everything: 1 day, 0.1 dusk
  Eigen::Vector3d sun{1.0, 0.97, 0.90};        // its glow in the sky
  Eigen::Vector3d sunlight{0.55, 0.53, 0.48};  // on ground that faces it
  Eigen::Vector3d ambient{0.40, 0.43, 0.48};   // from the whole sky

  Eigen::Vector3d zenith{0.25, 0.45, 0.78};
  Eigen::Vector3d horizon{0.75, 0.84, 0.92};          // and the haze
  Eigen::Vector3d horizon_sunward{0.85, 0.88, 0.90};  // the same below the sun
  double haze_m = 30000;                              // how far one sees: contrast fades to 2 % there
  double cloud_cover = 0.3;
  Eigen::Vector3d cloud_bright{0.98, 0.98, 0.98}, cloud_dark{0.62, 0.66, 0.72};

  Eigen::Vector3d grass{0.36, 0.46, 0.20}, crop{0.62, 0.56, 0.30}, soil{0.42, 0.33, 0.24};
  Eigen::Vector3d forest{0.14, 0.24, 0.11};
  Eigen::Vector3d leaves{0.18, 0.32, 0.12}, leaves_other{0.26, 0.38, 0.14};  // each tree is between the two
  double forest_share = 0.25, water_share = 0.05, snow_share = 0;

  // Hills round the flight: their greatest angle above the horizontal, from the ground at the origin. To be
  // one-sided is to be lower on the other side, by up to all.
  double hills_deg = 1.5, hills_azimuth_deg = 0, hills_one_sided = 0;
  RidgeParameters ridge;
  int trees = 300, buildings = 25;
};

inline void Fields(FieldVisitor& v, LandscapeParameters& p) {
  v("seed", p.seed);
  v("sun_azimuth_deg", p.sun_azimuth_deg, -360.0, 360.0);
  v("sun_elevation_deg", p.sun_elevation_deg, -10.0, 90.0);
  v("light", p.light, 0.02, 1.2);
  v("sun", p.sun, 0.0, 1.0);
  v("sunlight", p.sunlight, 0.0, 1.0);
  v("ambient", p.ambient, 0.0, 1.0);
  v("zenith", p.zenith, 0.0, 1.0);
  v("horizon", p.horizon, 0.0, 1.0);
  v("horizon_sunward", p.horizon_sunward, 0.0, 1.0);
  v("haze_m", p.haze_m, 200.0, 1e6);
  v("cloud_cover", p.cloud_cover, 0.0, 1.0);
  v("cloud_bright", p.cloud_bright, 0.0, 1.0);
  v("cloud_dark", p.cloud_dark, 0.0, 1.0);
  v("grass", p.grass, 0.0, 1.0);
  v("crop", p.crop, 0.0, 1.0);
  v("soil", p.soil, 0.0, 1.0);
  v("forest", p.forest, 0.0, 1.0);
  v("leaves", p.leaves, 0.0, 1.0);
  v("leaves_other", p.leaves_other, 0.0, 1.0);
  v("forest_share", p.forest_share, 0.0, 1.0);
  v("water_share", p.water_share, 0.0, 1.0);
  v("snow_share", p.snow_share, 0.0, 1.0);
  v("hills_deg", p.hills_deg, 0.0, 30.0);
  v("hills_azimuth_deg", p.hills_azimuth_deg, -360.0, 360.0);
  v("hills_one_sided", p.hills_one_sided, 0.0, 1.0);
  v("ridge", p.ridge);
  v("trees", p.trees, 0, 2000);
  v("buildings", p.buildings, 0, 300);
}

// A landscape for the compiler of MuJoCo: a plane "ground" at height 0, 300 m to each side, that bears what
// stands on it, and meshes to 120 km, seen alone. Its pictures are still to be painted.
//
// The ground is a sphere of kEarth_m that touches the plane at the origin: from a height h the horizon lies
// lower than the horizontal by sqrt(2 h / kEarth_m), the same all round, where no hill stands before it.
// Light, haze and the shadows of clouds are painted into the pictures as seen from near the origin.
struct LandscapeModel {
  std::string mjcf;
  std::map<std::string, std::string> files;  // that the MJCF names
};
inline constexpr double kEarth_m = 6371e3;
LandscapeModel MakeLandscape(const LandscapeParameters& parameters, std::uint64_t run_seed);

// Paints the pictures of a model that holds a landscape of the same parameters and seed.
void PaintLandscape(const LandscapeParameters& parameters, std::uint64_t run_seed, mjModel* model);

}  // namespace kestrel::sim
