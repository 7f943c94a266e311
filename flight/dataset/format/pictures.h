// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

// Pictures of data sets as the bytes of their files. All of it is compressed as fast as can be: what is
// noisy hardly shrinks by more patience.
namespace kestrel::flight {

std::string PngOf(const cv::Mat& image);

// 32-bit floats, m along the ray; infinite: sky, NaN: no lens there.
std::string DepthTiff(const cv::Mat& depth_m);
// 16 bits, so many to the metre, of the plane: axial as in RigCamera. 0: none, behind, or too far.
std::string DepthPng(const cv::Mat& depth_m, const cv::Mat& axial, double per_m);

// KITTI's: blue 1 where it is known, green and red v and u by 64 about 32768.
std::string FlowPng(const cv::Mat& flow_px);

}  // namespace kestrel::flight
