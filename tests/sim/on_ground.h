// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/simulator.h"

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

}  // namespace kestrel::sim
