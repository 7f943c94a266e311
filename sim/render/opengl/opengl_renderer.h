// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "sim/render/opengl/gl_context.h"
#include "sim/render/opengl/lens_faces.h"
#include "sim/render/opengl/lens_lookup.h"
#include "sim/render/rendering.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

struct DepthRange {
  double near_m, far_m;  // along the axis of a picture
};

// Draws what a camera sees, by OpenGL, from 2 cm to 500 m in front of it. A pinhole with square pixels is
// drawn as it is; any other lens is looked up in its faces (sim/render/opengl/lens_faces.h), between whose
// pixels it is interpolated, and 2 cm and 500 m count along the axis of each face. An OpenGlRenderer belongs
// to the thread that made it, and one thread holds one at a time: its context is current there. Several on
// several threads may share the model. The same state gives the same image, bit for bit, with the same
// name().
class OpenGlRenderer {
 public:
  // The model must outlive it. Throws std::runtime_error if no context can be had, or if the image is empty
  // or larger than the context draws. faces: instead of those that are planned for the lens.
  OpenGlRenderer(const mjModel* model, const vision::CameraModel& camera, const RenderOptions& options,
                 std::optional<LensFaces> faces = std::nullopt);
  ~OpenGlRenderer();
  OpenGlRenderer(const OpenGlRenderer&) = delete;
  OpenGlRenderer& operator=(const OpenGlRenderer&) = delete;

  // See Renderer. Where rows are exposed one after the other, bands of 16 share the times of their middle.
  cv::Mat Render(const mjData* data, const Pose& X_NC);
  cv::Mat Render(std::span<const SceneState> states, const Shutter& shutter);
  // Depth is that of the depth buffer: good to 1e-4 of itself, but at the edge of a thing seen aslant only to
  // half a pixel of a face. What light shines through counts like any other thing.
  Surfaces Trace(const mjData* data, const Pose& X_NC);

  // The backend, what draws, and its version.
  const std::string& name() const { return name_; }

 private:
  struct Rows {
    int first, end;
  };
  void SetScene(const mjData* data, const Pose& X_NC);
  void SetScene(std::span<const SceneState> states, double t_s);
  void Draw(const Face& face, DepthRange range);
  void DrawRows(Rows rows, cv::Mat& image);

  const mjModel* model_;
  bool direct_;  // the lens is its only face
  LensFaces lens_;
  bool shadows_;
  std::unique_ptr<GlContext> context_;
  std::string name_;
  mjvScene scene_;
  mjvOption visible_;
  mjrContext gpu_;
  std::unique_ptr<LensLookup> lookup_;  // unless direct
  Pose X_NC_;                           // of the scene
  std::vector<mjvGeom> geoms_;          // of the scene, of which each face draws those before it
  std::vector<unsigned char> rgb_;      // all faces, bottom row first, as read back
};

}  // namespace kestrel::sim
