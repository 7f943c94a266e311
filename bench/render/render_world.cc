// SPDX-License-Identifier: Apache-2.0
#include "bench/render/render_world.h"

#include "base/random.h"
#include "bench/named_camera.h"
#include "geometry/tait_bryan.h"
#include "sim/world/frames.h"

namespace kestrel::bench {
namespace {

constexpr double kBelow_m = 0.1;  // the camera: OpenGL would cut open what is within 2 cm

}  // namespace

std::vector<BenchCamera> BenchCameras() {
  return {{"catadioptric", NamedCamera("hyperbolic_mirror"), 15, 15, 200},
          {"fisheye", NamedCamera("fisheye"), 40, 12, 0},
          {"pinhole", NamedCamera("thesis_6mm"), 78, 4, 0}};
}

Pose AircraftPose(const BenchCamera& camera, Height height, std::uint64_t seed) {
  RandomStream random(seed, "bench render");
  const double side = height == Height::kNear ? 0.5 : height == Height::kMiddle ? 4 : 25;
  const double up = height == Height::kNear ? random.Uniform(0.4, 1) : height == Height::kMiddle ? 5 : 20;
  const double tilt = height == Height::kHigh ? camera.horizon_tilt_deg : 0;
  const TaitBryan angles{.yaw = Radians(random.Uniform(-180, 180)),
                         .pitch = Radians(tilt + random.Uniform(-8, 8)),
                         .roll = Radians(random.Uniform(-8, 8))};
  return {Eigen::Quaterniond(RotationFromTaitBryan(angles)),
          {random.Uniform(-side, side), random.Uniform(-side, side), -up}};
}

World::World(const std::string& scenario)
    : loaded_(flight::LoadScenario(scenario)),
      model_(sim::MakeModel(loaded_.simulator.scene)),
      data_(sim::MakeData(model_.get())) {}

Pose World::Put(const Pose& X_NB) {
  const int joint = model_->body_jntadr[mj_name2id(model_.get(), mjOBJ_BODY, "vehicle")];
  sim::PoseToMujoco(X_NB, data_->qpos + model_->jnt_qposadr[joint]);
  mj_forward(model_.get(), data_.get());
  return X_NB * vision::MountPose({.position_m = {0, 0, kBelow_m}});
}

}  // namespace kestrel::bench
