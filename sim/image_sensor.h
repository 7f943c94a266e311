// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace kestrel {

struct ImageParameters {
  bool colour = false;
  double rate_hz = 20;
  double latency_s = 0.05;  // from the middle of the exposure until the flight code has the frame
  double noise_grey = 2;    // deviation of the read noise of a pixel, grey levels of 255
};

template <class Visitor>
void Fields(Visitor& v, ImageParameters& p) {
  v("colour", p.colour);
  v("rate_hz", p.rate_hz, 0.5, 500.0);
  v("latency_s", p.latency_s, 0.0, 2.0);
  v("noise_grey", p.noise_grey, 0.0, 60.0);
}

// Makes a sensor's image of a rendered one: monochrome unless colour is asked for, with noise that depends on
// the seed and the frame's sequence alone, so that frames may be made in any order on any thread.
class ImageSensor {
 public:
  ImageSensor(const ImageParameters& parameters, std::uint64_t seed);
  cv::Mat Expose(const cv::Mat& bgr, std::int64_t sequence) const;

 private:
  bool colour_;
  std::uint64_t seed_;
  // Noise is drawn once: each row of each frame reads it from a place of its own, so that no frame costs a
  // million Gaussian numbers.
  std::vector<std::int8_t> noise_;
};

}  // namespace kestrel
