// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <variant>

#include "geometry/pose.h"
#include "vision/camera_model.h"

namespace kestrel {

class OpenGlRenderer;
class RayRenderer;

struct RenderOptions {
  std::string backend = "auto";  // ray; or OpenGL by osmesa or egl; auto: ray
  bool shadows = false;
  int samples = 0;  // OpenGL: for each pixel, to smooth edges; 0: none
  int threads = 1;  // ray: 0: as many as the machine has cores. The picture is the same.
};

template <class Visitor>
void Fields(Visitor& v, RenderOptions& o) {
  v("backend", o.backend, {"auto", "ray", "osmesa", "egl"});
  v("shadows", o.shadows);
  v("samples", o.samples, 0, 16);
  v("threads", o.threads, 0, 256);
}

// The world and the camera in it at one instant. Positions and lights of data are computed (mj_kinematics and
// mj_camlight, mj_forward or mj_step).
struct Instant {
  double t_s = 0;
  const mjData* data = nullptr;
  Pose X_NC;  // optical: x right, y down, z forward
};

// When the pixels are open. Row v is open for exposure_s around row_0_s + v * line_s. Light is gathered at
// samples instants, evenly spread over that; 1: in the middle, a sharp image.
struct Shutter {
  double row_0_s = 0;
  double exposure_s = 0;
  double line_s = 0;  // 0: global shutter
  int samples = 1;
};

// What is seen in each pixel, at its centre, by the camera's own geometry: the truth for tests of vision.
// Rays see what is opaque, at any distance; OpenGL sees what is transparent too, and nothing beyond 500 m.
struct Surfaces {
  cv::Mat depth_m;  // CV_32F, distance from the viewpoint along the ray; infinite in the sky, NaN outside the
                    // lens
  cv::Mat geom;     // CV_32S, id of the geom; -1: sky, -2: outside the lens
};

// Draws what a camera sees, by one of two means: see RenderOptions. The same instants give the same image,
// bit for bit, with the same name().
class Renderer {
 public:
  // The model must outlive it. Throws std::runtime_error with one sentence that names what cannot be drawn.
  Renderer(const mjModel* model, const CameraModel& camera, const RenderOptions& options);
  ~Renderer();

  // The image, CV_8UC3 in the order blue, green, red; black outside the lens.
  cv::Mat Render(const mjData* data, const Pose& X_NC);
  // The same while the world and the camera move: instants in the order of time; between two of them poses
  // are interpolated, beyond the ends the nearest holds.
  cv::Mat Render(std::span<const Instant> instants, const Shutter& shutter);
  Surfaces See(const mjData* data, const Pose& X_NC);
  // As in RayRenderer; empty by OpenGL, which cannot tell.
  cv::Mat Flow(const Instant& now, const Instant& next);

  // What draws, and its version.
  const std::string& name() const;

 private:
  std::variant<std::unique_ptr<RayRenderer>, std::unique_ptr<OpenGlRenderer>> by_;
};

}  // namespace kestrel
