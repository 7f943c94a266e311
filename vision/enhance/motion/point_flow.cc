// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/motion/point_flow.h"

#include <opencv2/video/tracking.hpp>

#include "vision/enhance/motion/opencl_device.h"

namespace kestrel::vision {

FlowPyramid::FlowPyramid(const cv::Mat& grey, const FlowOptions& options) : grey_(grey), options_(options) {
  if (options_.opencl && DoByOpenCl([&] { grey_.copyTo(on_device_); })) return;
  on_device_.release();
  cv::buildOpticalFlowPyramid(grey_, sizes_, options_.window, options_.levels, true);
}

std::vector<std::uint8_t> FollowPoints(const FlowPyramid& from, const FlowPyramid& to,
                                       const std::vector<cv::Point2f>& begin, std::vector<cv::Point2f>& end) {
  std::vector<std::uint8_t> found;
  if (begin.empty()) return found;
  const FlowOptions& options = from.options_;
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);
  const int guessed = end.empty() ? 0 : cv::OPTFLOW_USE_INITIAL_FLOW;
  const std::vector<cv::Point2f> guesses = end;
  if (!from.on_device_.empty() && !to.on_device_.empty() && DoByOpenCl([&] {
        cv::UMat points, there, marks;
        cv::Mat(begin).reshape(2, 1).copyTo(points);
        if (guessed) cv::Mat(guesses).reshape(2, 1).copyTo(there);
        cv::calcOpticalFlowPyrLK(from.on_device_, to.on_device_, points, there, marks, cv::noArray(),
                                 options.window, options.levels, stop, guessed, options.least_eigenvalue);
        there.getMat(cv::ACCESS_READ).reshape(2, 1).copyTo(end);
        marks.getMat(cv::ACCESS_READ).reshape(1, 1).copyTo(found);
      }))
    return found;
  end = guesses;
  // Where a device has failed meanwhile, there is an image and no pyramid.
  if (from.sizes_.empty() || to.sizes_.empty())
    cv::calcOpticalFlowPyrLK(from.grey_, to.grey_, begin, end, found, cv::noArray(), options.window,
                             options.levels, stop, guessed, options.least_eigenvalue);
  else
    cv::calcOpticalFlowPyrLK(from.sizes_, to.sizes_, begin, end, found, cv::noArray(), options.window,
                             options.levels, stop, guessed, options.least_eigenvalue);
  return found;
}

std::string FlowDevice(bool opencl) {
  if (!opencl) return "processor";
  const OpenClState state = OpenClStateNow();
  if (state == OpenClState::kUsed) return *OpenClDevice();
  return std::string("processor (OpenCL ") + NameOf(state) + ")";
}

}  // namespace kestrel::vision
