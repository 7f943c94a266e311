// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace kestrel::bench {

// A kind of picture, at twice the scale of the images that are drawn of it: pixel (u, v) of an image shows
// (2u + 0.5, 2v + 0.5) of it.
struct AlignmentPicture {
  std::string name;
  cv::Mat fine;  // CV_32FC1, 1280 x 960
};
std::vector<AlignmentPicture> AlignmentPictures();  // text, texture, helipad, repeated, poor

inline const cv::Rect kTemplateRegion(270, 190, 100, 100);  // of the image as it is drawn without a warp

// What else differs between the template and the image.
struct AlignmentNuisance {
  std::string name;
  double noise_grey = 2;
  double max_gain = 1;    // between its reciprocal and itself, in proportion
  double max_offset = 0;  // grey, to either side
  double max_blur_px = 0;
};
std::vector<AlignmentNuisance> AlignmentNuisances();  // noise alone; light, blur and more noise

// After Baker and Matthews (2004): the corners of the template are displaced by a normal deviate in either
// coordinate, and the image shows the picture under the homography that takes the corners there.
struct AlignmentDraw {
  cv::Mat image;            // CV_8UC1, 640 x 480
  Eigen::Matrix3d W_truth;  // from the image without a warp
};
cv::Mat DrawReference(const AlignmentPicture& picture);  // CV_8UC1, with a noise of its own
AlignmentDraw DrawDisplaced(const AlignmentPicture& picture, double sigma_px,
                            const AlignmentNuisance& nuisance, std::uint64_t seed);

// Root mean square distance of the template's corners under W from where they are in truth, px.
double CornerError_px(const Eigen::Matrix3d& W, const Eigen::Matrix3d& W_truth);

}  // namespace kestrel::bench
