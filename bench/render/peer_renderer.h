// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "sim/render/opengl/gl_context.h"
#include "vision/camera/camera_model.h"

namespace kestrel::bench {

// How others draw with MuJoCo, to be measured against: its own off-screen path through OpenGL, without
// shadows. A pinhole directly; a wide lens from whole faces of a cube, whose pixels are half as large as the
// lens's in the middle of its image, read back and looked up in a table with bilinear interpolation. A face
// that the lens does not see is left out. Belongs to the thread that made it.
class PeerRenderer {
 public:
  // The model must outlive it. backend: osmesa or egl. samples: for each pixel; MuJoCo's own default is 4.
  // finer: than said above.
  PeerRenderer(const mjModel* model, const vision::CameraModel& camera, const std::string& backend,
               int samples, double finer = 1);
  ~PeerRenderer();
  PeerRenderer(const PeerRenderer&) = delete;
  PeerRenderer& operator=(const PeerRenderer&) = delete;

  // CV_8UC3, red, green, blue as MuJoCo has it, the top row first.
  cv::Mat Render(const mjData* data, const Pose& X_NC);
  int face_px() const { return face_px_; }  // side of a face; 0: drawn directly
  int faces() const { return static_cast<int>(R_CV_.size()); }

 private:
  const mjModel* model_;
  int face_px_ = 0;
  vision::Pinhole picture_;               // what OpenGL draws
  std::vector<Eigen::Quaterniond> R_CV_;  // of each picture
  std::unique_ptr<sim::GlContext> context_;
  mjvScene scene_;
  mjvOption visible_;
  mjrContext gpu_;
  cv::Mat pictures_;                // one below the other, each bottom row first
  cv::Mat table_, table_fraction_;  // as cv::remap wants it
};

}  // namespace kestrel::bench
