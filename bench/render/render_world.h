// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "flight/simulated/scenario.h"
#include "geometry/pose.h"
#include "sim/world/scene.h"
#include "vision/camera/camera_model.h"

// What the benchmarks of rendering look at, and through what.
namespace kestrel::bench {

struct BenchCamera {
  std::string name;
  vision::CameraModel camera;
  double horizon_tilt_deg;  // nose up, so that the horizon is well in view of this camera that looks down
  // What is asked: times as fast as the peers, and frames a second.
  double times, frames_s;
};

// A mirror, a fisheye and a pinhole, of 640 x 480 pixels.
std::vector<BenchCamera> BenchCameras();

// Where the aircraft is: near the ground, at 5 m, at 20 m with the horizon in view.
enum class Height { kNear, kMiddle, kHigh };
constexpr std::array kHeights{Height::kNear, Height::kMiddle, Height::kHigh};
constexpr std::array kHeightNames{"0.4 to 1 m", "5 m", "20 m, horizon"};

Pose AircraftPose(const BenchCamera& camera, Height height, std::uint64_t seed);

// A scenario's world with the aircraft somewhere in it.
class World {
 public:
  explicit World(const std::string& scenario);
  const mjModel* model() const { return model_.get(); }
  const mjData* data() const { return data_.get(); }
  Pose Put(const Pose& X_NB);  // gives the pose of the camera

 private:
  flight::LoadedScenario loaded_;
  sim::ModelPtr model_;
  sim::DataPtr data_;
};

}  // namespace kestrel::bench
