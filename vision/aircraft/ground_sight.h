// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/aircraft/aircraft_lights.h"
#include "vision/aircraft/ground_camera.h"
#include "vision/camera/camera_model.h"

namespace kestrel::vision {

// A camera on the ground with all that flight code knows of it.
struct GroundSight {
  GroundCamera* stream = nullptr;  // outlives the flight; null: nobody gives frames
  CameraModel camera;
  GroundPlace place;
  AircraftLights lights;
};

}  // namespace kestrel::vision
