// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/enhance/stabilisation/stabiliser.h"

namespace kestrel::app {

// What is kept of an image until it is shown.
struct ImageBefore {
  int number = 0;  // of the input, from 0
  double t_s = 0;
  std::optional<vision::StabilisedState> left_out;  // it is not shown, and why
  cv::Mat drawn;                                    // with what was matched
  double ms = 0;                                    // that it took
  bool interlaced = false;
  std::optional<Eigen::Vector3d> down_C;  // by the skyline
};

// What became of a video's images, as a table and in sentences.
class StabiliseTally {
 public:
  // camera: none, by vision in pixels. opencl: points are to be followed on a device of OpenCL.
  // level: the horizon is to be level.
  StabiliseTally(const vision::CameraModel* camera, bool opencl, bool level)
      : camera_(camera), opencl_(opencl), level_(level) {}

  void Add(const vision::StabilisedImage& image, const ImageBefore& before);
  void AddLeftOut(const ImageBefore& before);
  const std::string& csv() const { return csv_; }
  int images() const { return images_; }  // that are shown
  // Whether the motion of an image was measured and, if it is to be level, a horizon seen.
  bool Achieved() const;
  // The count of each state, and of those that ask for it the remedy.
  std::vector<std::string> Sentences() const;

 private:
  const vision::CameraModel* camera_;
  bool opencl_, level_;
  std::string csv_ =
      "frame,t_s,state,points,inliers,rms_px,strength,shift_x_px,shift_y_px,turn_deg,scale,stabilise_ms,"
      "device,interlaced,horizon_in_deg,horizon_deg\n";
  std::map<std::string, int> states_;
  int images_ = 0, left_out_ = 0, levelled_ = 0, drawn_back_ = 0;
  double ms_ = 0, square_in_deg2_ = 0, square_deg2_ = 0, worst_deg_ = 0;
};

}  // namespace kestrel::app
