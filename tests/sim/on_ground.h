// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sim/aircraft/multirotor_shape.h"
#include "sim/simulator.h"
#include "tests/sim/published_layouts.h"

namespace kestrel::sim {

// The Pelican on the pad, its motors off, seen by a small camera that looks down.
inline SimulatorParameters OnGround() {
  const std::filesystem::path models = KESTREL_SOURCE_DIR "/models";
  SimulatorParameters p;
  p.scene.world = models / "worlds/airfield/airfield.xml";
  p.scene.vehicle = models / "vehicles/pelican/pelican.xml";
  p.scene.pad_texture = models / "pads/helipad/helipad.png";
  p.camera = vision::Pinhole{32, 24, 30, 30, 15.5, 11.5};
  p.image.rate_hz = 5;
  p.start.on_ground = true;
  p.start.settle_s = 0.5;
  return p;
}

// The Pelican with its rotors, or more of its kind, in a layout, listed clockwise from the front.
inline MultirotorParameters PelicanWith(const std::string& layout) {
  MultirotorParameters p;
  std::vector<PublishedMotor> motors = PublishedLayout(layout, p.arm_m);
  const auto bearing = [](const PublishedMotor& m) { return std::atan2(m.y, m.x); };
  std::ranges::sort(motors, {}, bearing);
  for (const PublishedMotor& m : motors)
    p.rotors.push_back({m.x, m.y, m.yaw > 0 ? "counterclockwise" : "clockwise"});
  return p;
}

inline SimulatorParameters OnGroundWith(const std::string& layout) {
  SimulatorParameters p = OnGround();
  if (layout == "quad-plus") return p;
  const MultirotorParameters aircraft = PelicanWith(layout);
  p.vehicle = aircraft;
  p.scene.vehicle_shape = MultirotorShape(aircraft);
  return p;
}

}  // namespace kestrel::sim
