// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/features/surf.h"

#include <dlib/array2d.h>
#include <dlib/image_keypoint/surf.h>

#include <cstring>

namespace kestrel::vision {
namespace {

constexpr double kMinResponse = 30;  // of the determinant of the Hessian
constexpr double kRadius_scales =
    9;  // half the side of the filter that finds a feature, in units of its scale

}  // namespace

Features DetectSurf(const cv::Mat& grey, int max_features) {
  dlib::array2d<unsigned char> image(grey.rows, grey.cols);
  for (int row = 0; row < grey.rows; ++row)
    std::memcpy(&image[row][0], grey.ptr(row), static_cast<std::size_t>(grey.cols));
  const std::vector<dlib::surf_point> found = dlib::get_surf_points(image, max_features, kMinResponse);
  Features features;
  features.descriptors.create(static_cast<int>(found.size()), 64, CV_32F);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const dlib::surf_point& point = found[i];
    features.points.emplace_back(static_cast<float>(point.p.center.x()),
                                 static_cast<float>(point.p.center.y()),
                                 static_cast<float>(2 * kRadius_scales * point.p.scale),
                                 static_cast<float>(point.angle * 180 / CV_PI + (point.angle < 0 ? 360 : 0)),
                                 static_cast<float>(point.p.score));
    float* const row = features.descriptors.ptr<float>(static_cast<int>(i));
    for (int k = 0; k < 64; ++k) row[k] = static_cast<float>(point.des(k));
  }
  return features;
}

}  // namespace kestrel::vision
