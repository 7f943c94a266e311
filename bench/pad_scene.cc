// SPDX-License-Identifier: Apache-2.0
#include "bench/pad_scene.h"

#include <mujoco/mujoco.h>

#include <cmath>

#include "base/random.h"
#include "geometry/tait_bryan.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::bench {
namespace {

sim::DataPtr WithoutAircraft(const mjModel* model) {
  sim::DataPtr data = sim::MakeData(model);
  data->qpos[2] = 100;  // the aircraft itself, out of the picture
  mj_forward(model, data.get());
  return data;
}

}  // namespace

PadScene::PadScene()
    : loaded_(flight::LoadScenario("pose")),
      model_(sim::MakeModel(loaded_.simulator.scene)),
      data_(WithoutAircraft(model_.get())),
      X_NT_(sim::PadPose(model_.get(), data_.get())),
      renderer_(model_.get(), loaded_.simulator.camera, loaded_.simulator.render) {}

sim::ImageSensor PadScene::Sensor(std::uint64_t seed) const {
  return {sim::DrawScatter(loaded_.simulator.image, seed), loaded_.simulator.camera, seed};
}

PadSway::PadSway(std::uint64_t seed, std::string_view stream) {
  RandomStream random(seed, stream);
  for (int i = 0; i < 6; ++i) phase_(i) = random.Uniform(0, 6.28);
}

Pose PadSway::X_TC(double height_m, double t_s) const {
  const auto sway = [&](int i, double hz) { return std::sin(6.283 * hz * t_s + phase_(i)); };
  return Pose{Eigen::Quaterniond(
                  RotationFromTaitBryan({0.2 * sway(0, 0.1), 0.06 * sway(1, 0.5), 0.06 * sway(2, 0.4)})),
              {0.06 * height_m * sway(3, 0.3), 0.06 * height_m * sway(4, 0.25),
               -height_m * (1 + 0.03 * sway(5, 0.2))}} *
         vision::MountPose({.position_m = Eigen::Vector3d::Zero()});
}

}  // namespace kestrel::bench
