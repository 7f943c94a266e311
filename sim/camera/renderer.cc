// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/renderer.h"

#include "sim/render/opengl/opengl_renderer.h"
#include "sim/render/ray/ray_renderer.h"

namespace kestrel::sim {

Renderer::Renderer(const mjModel* model, const vision::CameraModel& camera, const RenderOptions& options,
                   SharedLoop* shared) {
  if (options.backend == "ray" || options.backend == "auto") {
    by_ = std::make_unique<RayRenderer>(model, camera, options, shared);
  } else {
    by_ = std::make_unique<OpenGlRenderer>(model, camera, options);
  }
}
Renderer::~Renderer() = default;

cv::Mat Renderer::Render(const mjData* data, const Pose& X_NC) {
  return std::visit([&](auto& r) { return r->Render(data, X_NC); }, by_);
}

cv::Mat Renderer::Render(std::span<const SceneState> states, const Shutter& shutter) {
  return std::visit([&](auto& r) { return r->Render(states, shutter); }, by_);
}

Surfaces Renderer::Trace(const mjData* data, const Pose& X_NC) {
  return std::visit([&](auto& r) { return r->Trace(data, X_NC); }, by_);
}

cv::Mat Renderer::Flow(const Surfaces& seen_now, const SceneState& now, const SceneState& next) {
  auto* ray = std::get_if<std::unique_ptr<RayRenderer>>(&by_);
  return ray ? (*ray)->Flow(seen_now, now, next) : cv::Mat();
}

const std::string& Renderer::name() const {
  return std::visit([](auto& r) -> const std::string& { return r->name(); }, by_);
}

}  // namespace kestrel::sim
