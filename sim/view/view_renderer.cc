// SPDX-License-Identifier: Apache-2.0
#include "sim/view/view_renderer.h"

#include <cmath>
#include <span>
#include <vector>

#include "geometry/tait_bryan.h"
#include "sim/render/ray/ray_renderer.h"
#include "sim/render/rendering.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {
namespace {

// shift: of the picture, px.
vision::CameraModel LensOf(const ViewParameters& p, double fov_rad, const Eigen::Vector2d& shift) {
  const double f = p.width_px / (2 * std::tan(fov_rad / 2));
  return vision::Pinhole{
      p.width_px, p.height_px, f, f, (p.width_px - 1) / 2.0 + shift.x(), (p.height_px - 1) / 2.0 + shift.y()};
}

RenderOptions OptionsOf(int threads) {
  RenderOptions options;
  options.backend = "ray";
  options.light = "sky";
  options.threads = threads;
  return options;
}

}  // namespace

struct ViewRenderer::Stage {
  ViewParameters parameters;
  int samples;
  double fov_rad;
  RayRenderer renderer;
  SnapshotInterpolator worlds;
};

ViewRenderer::ViewRenderer(const mjModel* model, const ViewParameters& parameters, int threads, int samples)
    : stage_(new Stage{
          parameters, samples, Radians(parameters.fov_deg),
          RayRenderer(model, LensOf(parameters, Radians(parameters.fov_deg), {0, 0}), OptionsOf(threads)),
          SnapshotInterpolator(model, {}, Vibration({}, 0))}) {}
ViewRenderer::~ViewRenderer() = default;

cv::Mat ViewRenderer::Draw(const Snapshot& world, const ViewAim& aim) {
  Snapshot seen = world;
  seen.X_NC = aim.X_NC;
  return Draw(std::vector{seen}, world.t_s, aim.fov_rad);
}

cv::Mat ViewRenderer::Draw(const std::vector<Snapshot>& worlds, double t_s, double fov_rad) {
  Stage& s = *stage_;
  const std::span<const SceneState> states = s.worlds.Of(worlds, t_s, t_s);
  const Shutter shutter{.row_0_s = t_s};
  if (s.samples <= 1) {
    if (fov_rad != s.fov_rad) s.renderer.SetCamera(LensOf(s.parameters, fov_rad, {0, 0}));
    s.fov_rad = fov_rad;
    return s.renderer.Render(states, shutter);
  }
  cv::Mat sum = cv::Mat::zeros(s.parameters.height_px, s.parameters.width_px, CV_16UC3), mean;
  for (int i = 0; i < s.samples * s.samples; ++i) {
    const Eigen::Array2d place(i % s.samples, i / s.samples);
    s.renderer.SetCamera(LensOf(s.parameters, fov_rad, (place + 0.5) / s.samples - 0.5));
    cv::add(sum, s.renderer.Render(states, shutter), sum, cv::noArray(), CV_16U);
  }
  sum.convertTo(mean, CV_8U, 1.0 / (s.samples * s.samples));
  return mean;
}

}  // namespace kestrel::sim
