// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/target/colour_model.h"

namespace kestrel::vision {

// A lamp on the aircraft: a small globe, of one of the two colours by which it is told from the others.
struct AircraftLight {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // of its centre, in B: forward, right, down
  int colour = 1;                                        // 1 or 2
};

// The lamps by which a camera on the ground knows an aircraft and its attitude: their places, their size and
// their two colours. No turn about the vertical may lay them on themselves, colours included; two of one colour
// that come before each other are to be at different heights. The default is for a quadrotor in plus layout: one
// at the end of each arm, below or above it, and one over its middle.
struct AircraftLights {
  double diameter_m = 0.06;
  ColourRange colour_1{.hue_deg = 305, .hue_half_width_deg = 35, .min_saturation = 0.5, .min_value = 0.3};
  ColourRange colour_2{.hue_deg = 145, .hue_half_width_deg = 25, .min_saturation = 0.6, .min_value = 0.4};
  std::vector<AircraftLight> lights = {{{0.21, 0, -0.09}, 1},
                                       {{0, 0.21, 0.115}, 1},
                                       {{-0.21, 0, 0.02}, 2},
                                       {{0, -0.21, 0.115}, 2},
                                       {{0, 0, -0.2}, 1}};
};

inline void Fields(FieldVisitor& v, AircraftLight& p) {
  v({"position_m", "place of the light on the aircraft: forward, right, down"}, p.position_m, -3.0, 3.0);
  v({"colour", "which of the two colours it has"}, p.colour, 1, 2);
}

inline void Fields(FieldVisitor& v, AircraftLights& p) {
  v({"diameter_m", "diameter of each light"}, p.diameter_m, 0.01, 0.5);
  v({"colour_1", "first colour, as the camera sees it"}, p.colour_1);
  v({"colour_2", "second colour, as the camera sees it"}, p.colour_2);
  v({"lights", "lights on the aircraft, at least four of them not in one plane"}, p.lights);
}

}  // namespace kestrel::vision
