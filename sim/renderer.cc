// SPDX-License-Identifier: Apache-2.0
#include "sim/renderer.h"

#include "sim/opengl_renderer.h"

namespace kestrel {

Renderer::Renderer(const mjModel* model, const CameraModel& camera, const RenderOptions& options)
    : opengl_(std::make_unique<OpenGlRenderer>(model, camera, options)) {}
Renderer::~Renderer() = default;

cv::Mat Renderer::Render(const mjData* data, const Pose& X_NC) { return opengl_->Render(data, X_NC); }

cv::Mat Renderer::Render(std::span<const Instant> instants, const Shutter& shutter) {
  return opengl_->Render(instants, shutter);
}

Surfaces Renderer::See(const mjData* data, const Pose& X_NC) { return opengl_->See(data, X_NC); }

const std::string& Renderer::name() const { return opengl_->name(); }

}  // namespace kestrel
