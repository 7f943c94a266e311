// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/simulator.h"

namespace kestrel::sim {

inline const std::filesystem::path kModels = KESTREL_SOURCE_DIR "/models";

// A hover over the helipad in a gusty wind, seen by a small camera.
inline SimulatorParameters Hover() {
  SimulatorParameters p;
  p.scene.world = kModels / "worlds/airfield/airfield.xml";
  p.scene.vehicle = kModels / "vehicles/pelican/pelican.xml";
  p.scene.pad_texture = kModels / "pads/helipad/helipad.png";
  p.camera = vision::Pinhole{160, 120, 202.7, 202.7, 79.5, 59.5};
  p.start.height_m = 4;
  p.start.settle_s = 0.5;
  p.wind.mean_m_s = 3, p.wind.turbulence = true;
  p.wind.gusts = {30, 2, 2};
  p.duration_s = 0.5;
  return p;
}

inline bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

// Without a word from the flight code, so that what the camera does cannot change the flight.
struct Watched {
  std::uint64_t state_hash, image_hash;
  std::vector<vision::Frame> frames;
  std::vector<double> given_s;  // when Next() gave them
  double end_s;
};

inline Watched Watch(const SimulatorParameters& p) {
  Simulator simulator(p);
  Watched run{};
  while (const auto frame = simulator.Next()) {
    run.frames.push_back(*frame);
    run.given_s.push_back(simulator.truth().t_s);
    EXPECT_EQ(frame->t_s, simulator.exposure().t_s);
  }
  EXPECT_FALSE(simulator.Next());
  run.end_s = simulator.truth().t_s;
  run.state_hash = simulator.state_hash(), run.image_hash = simulator.image_hash();
  return run;
}

}  // namespace kestrel::sim
