// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <opencv2/core.hpp>
#include <string>

#include "base/yaml/fields.h"
#include "geometry/pose.h"

// What a renderer is given and gives, whichever it is.
namespace kestrel::sim {

struct RenderOptions {
  std::string backend = "auto";  // ray; or OpenGL by osmesa or egl; auto: ray
  std::string light = "lamps";   // what the model's lights alone make; sky: as sun and sky shine, ray alone
  double daylight = 1;           // as a multiple of the usual
  bool shadows = false;          // of lamps: with hard edges
  int samples = 0;               // OpenGL: for each pixel, to smooth edges; 0: none
  int threads = 1;               // ray: 0: as many as the machine has cores. The picture is the same.
};

inline void Fields(FieldVisitor& v, RenderOptions& o) {
  v({"backend", "ray: our own ray renderer; osmesa, egl: MuJoCo's OpenGL; auto: ray"}, o.backend,
    {"auto", "ray", "osmesa", "egl"});
  v({"light",
     "lamps: the world's lights alone; sky: soft shadows of the sun, light from the whole sky and detail of "
     "the "
     "ground, by ray"},
    o.light, {"lamps", "sky"});
  v({"daylight",
     "light of the world as a multiple of the usual: less under a dark cloud; cameras see it, but for an "
     "event "
     "camera"},
    o.daylight, 0.02, 5.0);
  v({"shadows", "whether lights cast shadows, with hard edges; light: sky has its own"}, o.shadows);
  v({"samples", "OpenGL: samples of each pixel against jagged edges; 0: none"}, o.samples, 0, 16);
  v({"threads", "ray: threads that render one image; 0: one for each core; the image is the same"}, o.threads,
    0, 256);
}

// The world and the camera in it at one instant. Positions and lights of data are computed (mj_kinematics and
// mj_camlight, mj_forward or mj_step).
struct SceneState {
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

}  // namespace kestrel::sim
