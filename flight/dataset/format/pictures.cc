// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/format/pictures.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <vector>

namespace kestrel::flight {
namespace {

constexpr double kKittiFlow_per_px = 64, kKittiFlowZero = 32768, kMost16 = 65535;

std::string Encoded(const char* ending, const cv::Mat& image, const std::vector<int>& parameters) {
  std::vector<uchar> bytes;
  if (!cv::imencode(ending, image, bytes, parameters))
    throw std::runtime_error(fmt::format("a picture cannot be encoded as {}", ending));
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

std::string PngOf(const cv::Mat& image) { return Encoded(".png", image, {cv::IMWRITE_PNG_COMPRESSION, 1}); }

std::string DepthTiff(const cv::Mat& depth_m) {
  constexpr int kNone = 1;  // COMPRESSION_NONE of libtiff
  return Encoded(".tiff", depth_m, {cv::IMWRITE_TIFF_COMPRESSION, kNone});
}

std::string DepthPng(const cv::Mat& depth_m, const cv::Mat& axial, double per_m) {
  cv::Mat depth(depth_m.size(), CV_16U);
  depth.forEach<std::uint16_t>([&](std::uint16_t& value, const int* at) {
    const double z = per_m * depth_m.at<float>(at) * axial.at<float>(at);
    value = z > 0 && z < kMost16 + 0.5 ? static_cast<std::uint16_t>(z + 0.5) : 0;  // NaN: 0
  });
  return PngOf(depth);
}

std::string FlowPng(const cv::Mat& flow_px) {
  cv::Mat coded(flow_px.size(), CV_16UC3);
  const auto code = [](float px) { return std::floor(px * kKittiFlow_per_px + kKittiFlowZero + 0.5); };
  coded.forEach<cv::Vec3w>([&](cv::Vec3w& pixel, const int* at) {
    const cv::Vec2f flow = flow_px.at<cv::Vec2f>(at);
    const double u = code(flow[0]), v = code(flow[1]);
    const bool known = u >= 0 && u <= kMost16 && v >= 0 && v <= kMost16;  // NaN: not
    pixel = known ? cv::Vec3w(1, static_cast<std::uint16_t>(v), static_cast<std::uint16_t>(u))
                  : cv::Vec3w(0, 0, 0);
  });
  return PngOf(coded);
}

}  // namespace kestrel::flight
