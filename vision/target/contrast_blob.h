// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace kestrel::vision {

// A compact thing before an even background, measured to a fraction of a pixel.
struct BlobOptions {
  double min_score = 5;     // of its contrast, in sigmas of what is around it
  double max_aspect = 3;    // of the axes of its second moments
  double min_fill = 0.6;    // of the ellipse of its second moments
  double min_around = 0.5;  // of the ring around it that must be sky
};

enum class BlobState {
  kMeasured,
  kNothing,     // no contrast to what is around
  kHemmedIn,    // too little sky around it to tell
  kConnected,   // with what is no sky, or with something that goes on
  kNotCompact,  // long or ragged
  kClutter      // no more than others of its surroundings
};
const char* NameOf(BlobState state);

struct BlobPixel {
  Eigen::Vector2d px;
  double share = 0;  // of the pixel that the blob covers, 0 to 1
};

struct Blob {
  BlobState state = BlobState::kNothing;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // px, as all that follows only if measured
  double area = 0;                                   // px^2
  double contrast = 0;   // of its inside against the background, grey levels of 255, signed; mean of the
                         // channels
  double strongest = 0;  // the same in the channel where it is largest, without its sign
  double score = 0;      // strongest, in sigmas of the background
  double sigma = 0;      // of the background about its plane, in one channel
  Eigen::Vector3d background = Eigen::Vector3d::Zero();  // at its middle, of each channel
  double aspect = 0;
  std::vector<BlobPixel> pixels;
};

// The blob around a place. image: CV_8UC3 or CV_8UC1; sky: CV_8UC1 of its size, 0 where there is none. Its
// diameter is less than `inner`; the background is read in a ring between the radii inner and outer, px, as a
// plane in each channel.
Blob MeasureBlob(const cv::Mat& image, const cv::Mat& sky, const cv::Point& place, int inner, int outer,
                 const BlobOptions& options);

// How steep the edge of a blob is: the largest change of any channel over 3 px on rays from its centre, mean
// of 16 rays all round, in its strongest contrast. About 1 of a thing, however it is shaded near 0.5; of a
// cloud or of a glow the less the larger it is. strongest and sigma as in Blob.
double SharpnessOf(const cv::Mat& image, const Eigen::Vector2d& centre, double radius, double strongest,
                   double sigma);

}  // namespace kestrel::vision
