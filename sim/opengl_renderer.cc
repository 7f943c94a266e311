// SPDX-License-Identifier: Apache-2.0
#include "sim/opengl_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <shared_mutex>
#include <stdexcept>

#include "sim/frames.h"

namespace kestrel {
namespace {

constexpr double kNear_m = 0.02, kFar_m = 500;
constexpr int kMaxSide_px = 8192;
constexpr int kSceneRoom = 2000;  // drawn things beyond the geoms of the model

// MuJoCo fills its process-wide table of OpenGL functions anew for each context: nobody may draw meanwhile.
std::shared_mutex gl_functions;

// The camera of MuJoCo's scene. It takes top and bottom of the frustum at the near plane, and the middle
// between left and right; half the width it derives from the height and the aspect of the viewport, so pixels
// must be square. The image ends half a pixel beyond the centres of its outer pixels.
mjvGLCamera FrustumOf(const Pinhole& c) {
  mjvGLCamera g{};
  g.frustum_near = static_cast<float>(kNear_m);
  g.frustum_far = static_cast<float>(kFar_m);
  g.frustum_top = static_cast<float>(kNear_m * (c.cy + 0.5) / c.fy);
  g.frustum_bottom = static_cast<float>(kNear_m * (c.cy + 0.5 - c.height_px) / c.fy);
  g.frustum_center = static_cast<float>(kNear_m * ((c.width_px - 1) / 2.0 - c.cx) / c.fx);
  return g;
}

void Check(const Pinhole& c, const RenderOptions& options) {
  if (c.width_px < 1 || c.height_px < 1 || c.width_px > kMaxSide_px || c.height_px > kMaxSide_px)
    throw std::runtime_error(
        fmt::format("The renderer cannot draw an image of {} x {} pixels: each side from 1 to {}.",
                    c.width_px, c.height_px, kMaxSide_px));
  if (!(c.fx > 0) || !(c.fy > 0) || !std::isfinite(c.fx + c.fy + c.cx + c.cy))
    throw std::runtime_error(
        fmt::format("The renderer needs positive focal lengths and a finite principal point, "
                    "but fx = {}, fy = {}, cx = {}, cy = {}.",
                    c.fx, c.fy, c.cx, c.cy));
  if (std::abs(c.fx - c.fy) > 1e-9 * c.fx)
    throw std::runtime_error(
        fmt::format("The OpenGL renderer draws square pixels only, but fx = {} and fy = {}.", c.fx, c.fy));
  if (options.samples < 0)
    throw std::runtime_error(
        fmt::format("The renderer cannot take {} samples for each pixel.", options.samples));
}

}  // namespace

OpenGlRenderer::OpenGlRenderer(const mjModel* model, const Pinhole& camera, const RenderOptions& options)
    : model_(model), camera_(camera), shadows_(options.shadows) {
  Check(camera, options);
  context_ = MakeGlContext(options.backend);
  name_ = context_->RendererName();

  mjv_defaultOption(&visible_);
  std::fill(visible_.flags, visible_.flags + mjNVISFLAG, 0);
  visible_.flags[mjVIS_TEXTURE] = visible_.flags[mjVIS_STATIC] = 1;
  std::fill(visible_.sitegroup, visible_.sitegroup + mjNGROUP, 0);  // marks for the program, not for the eye

  mjModel shown = *model;  // shares the arrays: only these numbers are read from the copy
  shown.vis.global.offwidth = camera.width_px;
  shown.vis.global.offheight = camera.height_px;
  shown.vis.quality.offsamples = options.samples;
  if (!options.shadows) shown.vis.quality.shadowsize = 0;
  mjr_defaultContext(&gpu_);
  {
    const std::unique_lock lock(gl_functions);
    mjr_makeContext(&shown, &gpu_, mjFONTSCALE_50);
  }
  mjr_setBuffer(mjFB_OFFSCREEN, &gpu_);
  if (gpu_.currentBuffer != mjFB_OFFSCREEN || gpu_.offWidth != camera.width_px ||
      gpu_.offHeight != camera.height_px) {
    mjr_freeContext(&gpu_);
    throw std::runtime_error(fmt::format("{} cannot draw off screen at {} x {} pixels.", name_,
                                         camera.width_px, camera.height_px));
  }
  mjv_defaultScene(&scene_);
  mjv_makeScene(model, &scene_, model->ngeom + kSceneRoom);
  rgb_.create(camera.height_px, camera.width_px, CV_8UC3);
}

OpenGlRenderer::~OpenGlRenderer() {
  const std::shared_lock lock(gl_functions);
  mjv_freeScene(&scene_);
  mjr_freeContext(&gpu_);
}

cv::Mat OpenGlRenderer::Render(const mjData* data, const Pose& X_NC) {
  const std::shared_lock lock(gl_functions);
  // MuJoCo asks for the state to be writable to draw the perturbations of a mouse, of which there are none.
  mjvCamera unused;
  mjv_defaultCamera(&unused);
  mjv_updateScene(model_, const_cast<mjData*>(data), &visible_, nullptr, &unused, mjCAT_ALL, &scene_);
  scene_.flags[mjRND_SHADOW] = shadows_;
  scene_.flags[mjRND_REFLECTION] = 0;
  scene_.flags[mjRND_SKYBOX] = scene_.flags[mjRND_HAZE] = 1;

  mjvGLCamera eye = FrustumOf(camera_);
  const Eigen::Vector3d p_MC = SwapNedNwu(X_NC.p);
  const Eigen::Vector3d forward_M = SwapNedNwu(X_NC.R * Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d up_M = SwapNedNwu(X_NC.R * -Eigen::Vector3d::UnitY());
  for (int i = 0; i < 3; ++i) {
    eye.pos[i] = static_cast<float>(p_MC[i]);
    eye.forward[i] = static_cast<float>(forward_M[i]);
    eye.up[i] = static_cast<float>(up_M[i]);
  }
  scene_.camera[0] = scene_.camera[1] = eye;  // the two eyes of a stereo view, which MuJoCo averages

  const mjrRect whole{0, 0, camera_.width_px, camera_.height_px};
  mjr_setBuffer(mjFB_OFFSCREEN, &gpu_);
  mjr_render(whole, &scene_, &gpu_);
  mjr_readPixels(rgb_.data, nullptr, whole, &gpu_);
  cv::Mat image;
  cv::cvtColor(rgb_, image, cv::COLOR_RGB2BGR);
  cv::flip(image, image, 0);
  return image;
}

}  // namespace kestrel
