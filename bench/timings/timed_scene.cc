// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/timed_scene.h"

#include <cmath>

#include "geometry/tait_bryan.h"
#include "sim/camera/skyline/horizon.h"
#include "sim/world/frames.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::bench {

TimedScene::TimedScene(const std::string& scenario, const std::optional<vision::CameraModel>& camera)
    : loaded_(flight::LoadScenario(scenario)),
      camera_(camera ? *camera : loaded_.simulator.camera),
      X_BC_(vision::MountPose(loaded_.simulator.mount)),
      model_(sim::MakeModel(loaded_.simulator.scene)),
      data_(sim::MakeData(model_.get())),
      renderer_(model_.get(), camera_, {.backend = "ray"}) {}

cv::Mat TimedScene::Draw(const Pose& X_NB) {
  const int joint = model_->body_jntadr[mj_name2id(model_.get(), mjOBJ_BODY, "vehicle")];
  sim::PoseToMujoco(X_NB, data_->qpos + model_->jnt_qposadr[joint]);
  mj_forward(model_.get(), data_.get());
  return renderer_.Render(data_.get(), X_NB * X_BC_);
}

cv::Mat TimedScene::OwnParts() const { return sim::OwnParts(model_.get(), camera_, X_BC_); }

Pose PathPose(double height_m, int step) {
  const TaitBryan angles{.yaw = Radians(7.0 * step),
                         .pitch = Radians(6 * std::sin(0.8 * step)),
                         .roll = Radians(6 * std::sin(1.1 * step + 1))};
  return {Eigen::Quaterniond(RotationFromTaitBryan(angles)), {0.5 * step - 2, 0.3 * step, -height_m}};
}

}  // namespace kestrel::bench
