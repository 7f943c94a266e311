// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/image_sensor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/random.h"

namespace kestrel::sim {
namespace {

void AddNoise(std::uint8_t* row, const std::int8_t* noise, std::size_t length) {
  for (std::size_t x = 0; x < length; ++x)
    row[x] = static_cast<std::uint8_t>(std::clamp(row[x] + noise[x], 0, 255));
}

// variance: of a signal of 0, and by how much it grows with each grey level.
void AddNoise(float* row, const float* noise, std::size_t length, float variance, float growth) {
  if (growth == 0) {
    const float sigma = std::sqrt(variance);
    for (std::size_t x = 0; x < length; ++x) row[x] += sigma * noise[x];
  } else {
    for (std::size_t x = 0; x < length; ++x) row[x] += std::sqrt(variance + growth * row[x]) * noise[x];
  }
}

cv::Mat Compressed(const cv::Mat& image, int quality) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return cv::imdecode(bytes, image.channels() == 1 ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR);
}

double LitShare(const vision::CameraModel& camera, const cv::Mat& shade) {
  const int width = vision::WidthPx(camera), height = vision::HeightPx(camera);
  int lit = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      lit += (shade.empty() || shade.at<float>(y, x) > 0) &&
             vision::Ray(camera, Eigen::Vector2d(x, y)).has_value();
  }
  return std::max(1, lit) / (static_cast<double>(width) * height);
}

}  // namespace

ImageParameters DrawScatter(const ImageParameters& parameters, std::uint64_t seed) {
  const ImageScatter& s = parameters.scatter;
  const auto around = [seed](const char* name, double value, double scatter, double low, double high) {
    if (scatter <= 0) return value;
    RandomStream random(seed, std::string("image ") + name);
    return std::clamp(value + scatter * random.Uniform(-1, 1), low, high);
  };
  constexpr double kAny = 1e9;
  ImageParameters p = parameters;
  p.scatter = {};
  p.noise_grey = around("noise_grey", p.noise_grey, s.noise_grey, 0, kAny);
  p.gain = around("gain", p.gain, s.gain, 0.05, kAny);
  p.full_well_e = around("full_well_e", p.full_well_e, s.full_well_e, 0, kAny);
  p.gamma = around("gamma", p.gamma, s.gamma, 1, 3);
  p.jpeg_quality =
      static_cast<int>(std::lround(around("jpeg_quality", p.jpeg_quality, s.jpeg_quality, 0, 100)));
  p.exposure.time_s = around("time_s", p.exposure.time_s, s.time_s, 0, kAny);
  p.exposure.line_s = around("line_s", p.exposure.line_s, s.line_s, 0, kAny);
  p.lens.cos_power = around("cos_power", p.lens.cos_power, s.cos_power, 0, kAny);
  p.lens.vignetting[0] = around("vignetting", p.lens.vignetting[0], s.vignetting, -kAny, kAny);
  p.lens.defocus_px = around("defocus_px", p.lens.defocus_px, s.defocus_px, 0, kAny);
  return p;
}

double LongestExposure_s(const ImageParameters& p) {
  const double longest_s = p.exposure.time_s + p.scatter.time_s;
  return longest_s > 0 && p.auto_exposure.target_grey > 0 ? p.auto_exposure.longest_s : longest_s;
}

double LongestReadout_s(const ImageParameters& p, int rows) {
  return (p.exposure.line_s + p.scatter.line_s) * (rows - 1);
}

ImageSensor::ImageSensor(const ImageParameters& parameters, const vision::CameraModel& camera,
                         std::uint64_t seed)
    : parameters_(parameters),
      seed_(RandomStream(seed, "image garbage").Bits()),
      defocus_(parameters.lens),
      tone_(parameters.gamma, parameters.bits) {
  const ImageParameters& p = parameters_;
  const cv::Mat shade = Shade(p.lens, camera, seed);
  if (p.auto_exposure.target_grey > 0) lit_share_ = LitShare(camera, shade);
  linear_ = !shade.empty() || !defocus_.sharp() || p.lens.glare > 0 || p.auto_exposure.target_grey > 0 ||
            p.gain != 1 || p.full_well_e > 0 || p.gamma != 1 || p.bits != 8;
  if (linear_) {
    noise_ = NoiseTable<float>(seed, [](double n) { return static_cast<float>(n); });
    shade_ = shade;
    if (p.colour && !shade.empty()) cv::merge(std::vector<cv::Mat>(3, shade), shade_);
  } else if (p.noise_grey > 0) {
    byte_noise_ = NoiseTable<std::int8_t>(seed, [&](double n) {
      return static_cast<std::int8_t>(std::clamp(std::lround(p.noise_grey * n), -127L, 127L));
    });
  }
}

cv::Mat ImageSensor::Expose(const cv::Mat& bgr, std::int64_t sequence) const {
  return Expose(bgr, sequence, {parameters_.exposure.time_s, 1, parameters_.gain});
}

cv::Mat ImageSensor::Expose(const cv::Mat& bgr, std::int64_t sequence, const ExposureSetting& setting) const {
  cv::Mat image;
  if (parameters_.colour) {
    image = bgr.clone();
  } else {
    cv::cvtColor(bgr, image, cv::COLOR_BGR2GRAY);
  }
  if (linear_) {
    Develop(image, sequence, setting);
  } else {
    if (setting.light != 1) image.convertTo(image, -1, setting.light);
    const std::size_t length = static_cast<std::size_t>(image.cols) * image.channels();
    for (int y = 0; y < image.rows && !byte_noise_.empty(); ++y)
      AddNoise(image.ptr(y), byte_noise_.Row(sequence, y, length), length);
  }
  if (parameters_.jpeg_quality > 0) image = Compressed(image, parameters_.jpeg_quality);
  return image;
}

// Row by row, so that a row stays in the cache from the first part to the last.
void ImageSensor::Develop(cv::Mat& image, std::int64_t sequence, const ExposureSetting& setting) const {
  const std::size_t length = static_cast<std::size_t>(image.cols) * image.channels();
  cv::Mat spread;  // what the lens makes of the light
  if (!defocus_.sharp() || parameters_.lens.glare > 0) {
    cv::Mat light(image.size(), CV_MAKETYPE(CV_32F, image.channels()));
    for (int y = 0; y < image.rows; ++y) tone_.Decode(image.ptr(y), 1, light.ptr<float>(y), length);
    spread = defocus_.sharp() ? light : defocus_.Spread(light);
    if (const double glare = parameters_.lens.glare; glare > 0)
      spread = (1 - glare) * spread + glare * cv::mean(spread);
  }
  const float brightness = static_cast<float>(setting.light * setting.gain);
  const double read = parameters_.noise_grey * setting.gain;
  const float variance = static_cast<float>(read * read);
  const float growth =
      parameters_.full_well_e > 0 ? static_cast<float>(setting.gain * 255 / parameters_.full_well_e) : 0;
  std::vector<float> row(length);
  for (int y = 0; y < image.rows; ++y) {
    std::uint8_t* bytes = image.ptr(y);
    if (spread.empty()) {
      tone_.Decode(bytes, brightness, row.data(), length);
    } else {
      const float* light = spread.ptr<float>(y);
      for (std::size_t x = 0; x < length; ++x) row[x] = brightness * light[x];
    }
    if (!shade_.empty()) {
      const float* shade = shade_.ptr<float>(y);
      for (std::size_t x = 0; x < length; ++x) row[x] *= shade[x];
    }
    if (variance > 0 || growth > 0)
      AddNoise(row.data(), noise_.Row(sequence, y, length), length, variance, growth);
    tone_.Encode(row.data(), bytes, length);
  }
}

cv::Mat ImageSensor::Garbage(cv::Size size, std::int64_t sequence) const {
  cv::Mat image(size, parameters_.colour ? CV_8UC3 : CV_8UC1);
  const std::size_t count = image.total() * image.elemSize();
  std::uint64_t state = RandomStream::Mix(seed_ ^ static_cast<std::uint64_t>(sequence));
  for (std::size_t i = 0; i < count; i += sizeof state) {
    state = RandomStream::Mix(state);
    std::memcpy(image.data + i, &state, std::min(sizeof state, count - i));
  }
  return image;
}

double ImageSensor::MeanGrey(const cv::Mat& image) const {
  const cv::Scalar mean = cv::mean(image);
  const double grey = image.channels() == 1 ? mean[0] : (mean[0] + mean[1] + mean[2]) / 3;
  return grey / lit_share_;
}

}  // namespace kestrel::sim
