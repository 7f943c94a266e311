// SPDX-License-Identifier: Apache-2.0
#include "sim/image_sensor.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "sim/random.h"

namespace kestrel {
namespace {

constexpr std::size_t kNoiseSize = std::size_t{1} << 20;

}  // namespace

ImageSensor::ImageSensor(const ImageParameters& parameters, std::uint64_t seed) : colour_(parameters.colour) {
  RandomStream random(seed, "image noise");
  seed_ = RandomStream::Mix(seed);
  if (!(parameters.noise_grey > 0)) return;
  noise_.resize(kNoiseSize);
  for (std::int8_t& n : noise_) {
    n = static_cast<std::int8_t>(
        std::clamp(std::lround(parameters.noise_grey * random.Normal()), -127L, 127L));
  }
}

cv::Mat ImageSensor::Expose(const cv::Mat& bgr, std::int64_t sequence) const {
  cv::Mat image;
  if (colour_) {
    image = bgr.clone();
  } else {
    cv::cvtColor(bgr, image, cv::COLOR_BGR2GRAY);
  }
  if (noise_.empty()) return image;
  const std::size_t length = static_cast<std::size_t>(image.cols) * image.channels();
  for (int y = 0; y < image.rows; ++y) {
    const std::uint64_t place =
        RandomStream::Mix(seed_ ^ RandomStream::Mix((static_cast<std::uint64_t>(sequence) << 20) +
                                                    static_cast<std::uint64_t>(y)));
    const std::int8_t* noise = noise_.data() + place % (kNoiseSize - length);
    std::uint8_t* row = image.ptr(y);
    for (std::size_t x = 0; x < length; ++x)
      row[x] = static_cast<std::uint8_t>(std::clamp(row[x] + noise[x], 0, 255));
  }
  return image;
}

}  // namespace kestrel
