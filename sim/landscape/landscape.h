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
  v({"azimuth_deg", "direction of the middle of the ridge, clockwise from north"}, p.azimuth_deg, -360.0,
    360.0);
  v({"height_deg", "elevation of its crest as seen from the ground at the origin; 0: no ridge"}, p.height_deg,
    0.0, 40.0);
  v({"width_deg", "angle that it takes up as seen from the origin; 360: all round"}, p.width_deg, 0.0, 360.0);
  v({"distance_m", "distance of its crest from the origin"}, p.distance_m, 1000.0, 40000.0);
}

// Streaks over the horizon, as clouds and layers of air have them at sunset: each has edges as straight as a skyline.
struct BandsParameters {
  int count = 0;
  double top_deg = 8;     // below which they lie
  double contrast = 0.7;  // of the clearest
};

inline void Fields(FieldVisitor& v, BandsParameters& p) {
  v({"count", "number of them; 0: none"}, p.count, 0, 50);
  v({"top_deg", "elevation below which they lie"}, p.top_deg, 1.0, 45.0);
  v({"contrast", "share of the sky's colour that the clearest of them hides"}, p.contrast, 0.0, 1.0);
}

// Air that is thick up to a height, and ends there: an edge in the sky that is no horizon.
struct HazeLayerParameters {
  double top_deg = 0;    // elevation of its upper edge; 0: there is none
  double density = 0.6;  // share of the sky's colour that it hides
};

inline void Fields(FieldVisitor& v, HazeLayerParameters& p) {
  v({"top_deg", "elevation of its upper edge; 0: there is none"}, p.top_deg, 0.0, 20.0);
  v({"density", "share of the sky's colour that it hides"}, p.density, 0.0, 1.0);
}

// What water looks like that is more than a ruffled mirror.
struct WavesParameters {
  double slope = 0;                         // standard deviation of the facets'; 0: a mirror of the sky
  Eigen::Vector3d water{0.03, 0.13, 0.17};  // what is seen where a facet mirrors little
  double glitter = 1;                       // brightness of the facets that mirror the sun
};

inline void Fields(FieldVisitor& v, WavesParameters& p) {
  v({"slope",
     "standard deviation of their slope: 0.1 of a breeze, 0.25 of a gale; 0: water is a mirror of the sky"},
    p.slope, 0.0, 0.4);
  v({"water", "colour of the water where it mirrors little: red, green, blue"}, p.water, 0.0, 1.0);
  v({"glitter", "brightness of the facets that mirror the sun"}, p.glitter, 0.0, 4.0);
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

  // Hills round the flight: their maximum angle above the horizontal, from the ground at the origin. To be
  // one-sided is to be lower on the other side, by up to all.
  double hills_deg = 1.5, hills_azimuth_deg = 0, hills_one_sided = 0;
  RidgeParameters ridge;
  int trees = 300, buildings = 25;
  int towers = 0;  // of a city, from 800 m to 4 km away
  BandsParameters bands;
  HazeLayerParameters haze_layer;
  WavesParameters waves;
};

inline void Fields(FieldVisitor& v, LandscapeParameters& p) {
  v({"seed", "seed of fields, hills, clouds, trees and buildings; 0: that of the run"}, p.seed);
  v({"sun_azimuth_deg", "direction of the sun, clockwise from north"}, p.sun_azimuth_deg, -360.0, 360.0);
  v({"sun_elevation_deg", "elevation of the sun above the horizontal"}, p.sun_elevation_deg, -10.0, 90.0);
  v({"light", "brightness of everything: 1 day, 0.1 dusk"}, p.light, 0.02, 1.2);
  v({"sun", "colour of the glow around the sun: red, green, blue"}, p.sun, 0.0, 1.0);
  v({"sunlight", "colour of direct light on ground that faces the sun: red, green, blue"}, p.sunlight, 0.0,
    1.0);
  v({"ambient", "colour of the light from the whole sky: red, green, blue"}, p.ambient, 0.0, 1.0);
  v({"zenith", "colour of the sky at the zenith: red, green, blue"}, p.zenith, 0.0, 1.0);
  v({"horizon", "colour of the sky at the horizon, and of the haze: red, green, blue"}, p.horizon, 0.0, 1.0);
  v({"horizon_sunward", "colour of the horizon below the sun: red, green, blue"}, p.horizon_sunward, 0.0,
    1.0);
  v({"haze_m", "visibility: the distance at which contrast fades to 2 %"}, p.haze_m, 200.0, 1e6);
  v({"cloud_cover", "share of the sky that clouds cover"}, p.cloud_cover, 0.0, 1.0);
  v({"cloud_bright", "colour of the bright parts of clouds: red, green, blue"}, p.cloud_bright, 0.0, 1.0);
  v({"cloud_dark", "colour of the dark parts of clouds: red, green, blue"}, p.cloud_dark, 0.0, 1.0);
  v({"grass", "colour of meadows: red, green, blue"}, p.grass, 0.0, 1.0);
  v({"crop", "colour of fields with crops: red, green, blue"}, p.crop, 0.0, 1.0);
  v({"soil", "colour of bare fields: red, green, blue"}, p.soil, 0.0, 1.0);
  v({"forest", "colour of forests: red, green, blue"}, p.forest, 0.0, 1.0);
  v({"leaves", "one end of the range of the trees' colours: red, green, blue"}, p.leaves, 0.0, 1.0);
  v({"leaves_other", "the other end of the range of the trees' colours: red, green, blue"}, p.leaves_other,
    0.0, 1.0);
  v({"forest_share", "share of the ground that is forest"}, p.forest_share, 0.0, 1.0);
  v({"water_share", "share of the ground that is water"}, p.water_share, 0.0, 1.0);
  v({"snow_share", "share of the ground that is under snow"}, p.snow_share, 0.0, 1.0);
  v({"hills_deg", "maximum elevation of the hills around, as seen from the ground at the origin"},
    p.hills_deg, 0.0, 30.0);
  v({"hills_azimuth_deg", "direction in which the hills are highest, clockwise from north"},
    p.hills_azimuth_deg, -360.0, 360.0);
  v({"hills_one_sided",
     "by how much the hills on the other side are lower; 0: all round alike, 1: none there"},
    p.hills_one_sided, 0.0, 1.0);
  v({"ridge", "a single ridge in one direction"}, p.ridge);
  v({"trees", "number of trees"}, p.trees, 0, 2000);
  v({"buildings", "number of buildings"}, p.buildings, 0, 300);
  v({"towers", "number of high buildings, a city's, from 0.8 to 4 km away"}, p.towers, 0, 400);
  v({"bands", "streaks over the horizon, as of a sunset"}, p.bands);
  v({"haze_layer", "air that is thick up to a height and ends there: an edge in the sky that is no horizon"},
    p.haze_layer);
  v({"waves", "waves of the water, and the sun's glitter on them"}, p.waves);
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
