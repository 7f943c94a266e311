// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "sim/camera/renderer.h"
#include "sim/world/scene.h"
#include "vision/calibration/board/board.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

// Poses X_CT of a board before a camera, as one holds it for a calibration: the places where a corner of it
// is seen are spread evenly over the image and to the rim of the lens; near and far; turned at will, and
// tilted by up to 50 degrees. Of a chessboard all is in view, of tags at least a third; the smallest is large
// enough to be found. The same seed gives the same poses; the first of many are those of few. Throws
// std::runtime_error if the camera is too coarse for the board.
std::vector<Pose> SpreadPoses(const vision::CameraModel& camera, const vision::Board& board, int count,
                              std::uint64_t seed);

struct BoardRendererOptions {
  double blur_px = 0.3;          // standard deviation of the lens's blur
  double noise_grey = 2;         // standard deviation of the read noise of a pixel, grey levels of 255
  std::string backend = "auto";  // see RenderOptions
  int threads = 0;               // of the ray renderer; 0: all cores
};

// A board in even light before a grey wall, and a camera that takes pictures of it. Each pixel is the mean of
// several rays, 4 x 4 where the renderer can draw so large an image.
class BoardRenderer {
 public:
  // Throws std::runtime_error with what cannot be drawn.
  BoardRenderer(const vision::Board& board, const vision::CameraModel& camera,
                const BoardRendererOptions& options);

  // CV_8UC1. Noise depends on seed and number alone.
  cv::Mat Render(const Pose& X_CT, std::uint64_t seed, std::int64_t number);
  const std::string& renderer() const { return renderer_.name(); }

 private:
  BoardRendererOptions options_;
  int fine_;  // rays along each side of a pixel
  cv::Size size_;
  ModelPtr model_;
  DataPtr data_;
  Renderer renderer_;
};

// The same camera with n x n pixels for each.
vision::CameraModel Refined(const vision::CameraModel& camera, int n);

}  // namespace kestrel::sim
