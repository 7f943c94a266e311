// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

// Points followed from one image into another by pyramidal Lucas-Kanade (Bouguet 2001), as OpenCV has it for the
// processor and for OpenCL. The same on any number of threads; by OpenCL nearly the same.
namespace kestrel::vision {

struct FlowOptions {
  cv::Size window{15, 15};
  int levels = 3;                  // beside the image itself
  double least_eigenvalue = 1e-3;  // of a window's gradients, on the processor: with less it is not followed
  bool opencl = false;             // on a device of OpenCL, if there is one (opencl_device.h tells)
};

// An image in the sizes that are compared.
class FlowPyramid {
 public:
  FlowPyramid() = default;
  // CV_8UC1, which is not copied but for the device, where its smaller sizes are made.
  FlowPyramid(const cv::Mat& grey, const FlowOptions& options);
  bool empty() const { return grey_.empty(); }

 private:
  friend std::vector<std::uint8_t> FollowPoints(const FlowPyramid& from, const FlowPyramid& to,
                                                const std::vector<cv::Point2f>& begin,
                                                std::vector<cv::Point2f>& end);
  cv::Mat grey_;
  std::vector<cv::Mat> sizes_;  // on the processor; or
  cv::UMat on_device_;
  FlowOptions options_;
};

// Both pyramids are of the same options. end: where the points may be; empty: nearly where they begin. Gives where they
// are there, and of each 1 if it was found, else 0.
std::vector<std::uint8_t> FollowPoints(const FlowPyramid& from, const FlowPyramid& to,
                                       const std::vector<cv::Point2f>& begin, std::vector<cv::Point2f>& end);

// What points are followed on now: "processor", the device of OpenCL by its name, or "processor (OpenCL absent)" and
// "processor (OpenCL failed)" where it was asked for.
std::string FlowDevice(bool opencl);

}  // namespace kestrel::vision
