// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/camera/snapshots.h"
#include "sim/view/view_camera.h"
#include "sim/view/view_parameters.h"

namespace kestrel::sim {

// Draws a view by the ray renderer with light from sun and sky (RenderOptions::light). From outside of a
// flight:
//
//   ViewParameters parameters{.kind = "orbit"};
//   ViewCamera camera(simulator.model(), parameters);
//   ViewRenderer renderer(simulator.model(), parameters);
//   while (simulator.Next()) {
//     cv::Mat bgr = renderer.Draw(simulator.snapshot(), camera.At(simulator.truth()));
//   }
//
// A snapshot is a copy: it may be drawn on another thread while the simulator goes on.
class ViewRenderer {
 public:
  // threads: 0: one for each core; the picture is the same. samples: along each side of a pixel, for pictures
  // of high quality. The model must outlive it. Throws std::runtime_error that names what cannot be drawn.
  ViewRenderer(const mjModel* model, const ViewParameters& parameters, int threads = 1, int samples = 1);
  ~ViewRenderer();

  cv::Mat Draw(const Snapshot& world, const ViewAim& aim);  // CV_8UC3: blue, green, red
  // Between two instants: worlds are around t_s, with X_NC.
  cv::Mat Draw(const std::vector<Snapshot>& worlds, double t_s, double fov_rad);

 private:
  struct Stage;
  std::unique_ptr<Stage> stage_;
};

}  // namespace kestrel::sim
