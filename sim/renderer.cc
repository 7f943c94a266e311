// SPDX-License-Identifier: Apache-2.0
#include "sim/renderer.h"

#include <stdexcept>

#include "sim/opengl_renderer.h"

namespace kestrel {

Renderer::Renderer(const mjModel* model, const CameraModel& camera, const RenderOptions& options)
    : opengl_(std::make_unique<OpenGlRenderer>(model, std::get<Pinhole>(camera), options)) {}
Renderer::~Renderer() = default;

cv::Mat Renderer::Render(const mjData* data, const Pose& X_NC) { return opengl_->Render(data, X_NC); }

cv::Mat Renderer::Render(std::span<const Instant> instants, const Shutter&) {
  return opengl_->Render(instants.front().data, instants.front().X_NC);
}

Surfaces Renderer::See(const mjData*, const Pose&) { throw std::runtime_error("not yet"); }

const std::string& Renderer::name() const { return opengl_->name(); }

}  // namespace kestrel
