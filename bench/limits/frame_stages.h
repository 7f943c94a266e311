// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "flight/simulated/scenario.h"
#include "geometry/pose.h"
#include "sim/render/ray/lens.h"
#include "sim/render/ray/render_scene.h"
#include "sim/world/scene.h"
#include "vision/camera/camera_model.h"

namespace kestrel::bench {

// What a frame has in it, whoever draws it.
struct FrameContent {
  double pixels = 0;    // that the lens shows something in
  double textured = 0;  // of these, on a thing with a texture
  double at_edges = 0;  // of these, which the kernel draws by eight rays instead of one
};

// Of the ray renderer on one thread.
struct FrameStages {
  double set_up_ms = 0;  // things and lights into the camera's frame
  double list_ms = 0;    // what each tile may meet, and its triangles
  double rays_ms = 0;    // a ray to each pixel: what it meets, its colour and the code of edges
  double edges_ms = 0;   // pixels at edges again
  double Sum() const { return set_up_ms + list_ms + rays_ms + edges_ms; }
};

struct StagedFrame {
  FrameStages stages;
  FrameContent content;
  cv::Mat picture;  // CV_8UC3, the same as by the ray renderer
};

// A scenario's world, drawn by the ray renderer's own functions one after the other, so that each is timed.
class StagedRenderer {
 public:
  // Throws InputError.
  StagedRenderer(const std::string& scenario, const vision::CameraModel& camera);
  StagedFrame Draw(const Pose& X_NB);

 private:
  flight::LoadedScenario loaded_;
  Pose X_BC_;
  sim::ModelPtr model_;
  sim::DataPtr data_;
  std::shared_ptr<const sim::ray::Lens> lens_;
  sim::ray::RenderScene scene_;
};

// Of several frames along the path of `bench timings`: the mean, of the fastest of several tries each.
StagedFrame MeanFrame(StagedRenderer& renderer, double height_m, int frames);

}  // namespace kestrel::bench
