// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string_view>

#include "flight/simulated/scenario.h"
#include "geometry/pose.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/renderer.h"
#include "sim/world/scene.h"

namespace kestrel::bench {

// The pad of the scenario "pose" without a flight: its camera sees it from anywhere, and no aircraft.
class PadScene {
 public:
  PadScene();
  const flight::LoadedScenario& loaded() const { return loaded_; }
  cv::Mat Render(const Pose& X_TC) { return renderer_.Render(data_.get(), X_NT_ * X_TC); }
  sim::ImageSensor Sensor(std::uint64_t seed) const;  // of a run with this seed

 private:
  flight::LoadedScenario loaded_;
  sim::ModelPtr model_;
  sim::DataPtr data_;
  Pose X_NT_;
  sim::Renderer renderer_;
};

// How a camera sways that looks down on the pad: each of its angles and coordinates by a wave of its own.
class PadSway {
 public:
  PadSway(std::uint64_t seed, std::string_view stream);  // of which the phases are drawn
  Pose X_TC(double height_m, double t_s) const;

 private:
  Eigen::Matrix<double, 6, 1> phase_;
};

}  // namespace kestrel::bench
