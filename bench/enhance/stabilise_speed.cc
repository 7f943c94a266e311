// SPDX-License-Identifier: Apache-2.0
#include "bench/enhance/stabilise_speed.h"

#include <fmt/format.h>

#include <chrono>
#include <opencv2/core.hpp>

#include "base/statistics.h"
#include "base/stopwatch.h"
#include "bench/enhance/shaken_clip.h"
#include "vision/enhance/motion/opencl_device.h"
#include "vision/enhance/stabilisation/stabiliser.h"

namespace kestrel::bench {
namespace {

struct Speed {
  double images_s = 0;
  double points = 0;  // mean that were followed
};

Speed Time(const std::vector<cv::Mat>& images, std::size_t count, bool opencl, double rate_hz) {
  constexpr std::size_t kWarm = 3;  // images, in which memory is taken and kernels are compiled
  vision::StabiliserOptions options;
  options.mode = "reference", options.motion.max_points = 1000, options.motion.opencl = opencl;
  vision::Stabiliser stabiliser(options, {}, rate_hz);
  std::vector<double> points;
  auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < count; ++i) {
    if (i == kWarm) start = std::chrono::steady_clock::now(), points.clear();
    points.push_back(stabiliser.Step(images[i], static_cast<double>(i) / rate_hz)->points);
  }
  return {static_cast<double>(count - kWarm) / SecondsSince(start), Mean(points)};
}

}  // namespace

void TimeStabiliser(std::uint64_t seed, std::vector<records::Figure>& table) {
  const ShakenClip clip({.name = "hover", .size = {1024, 780}, .images = 90}, seed);
  std::vector<cv::Mat> images;
  for (int i = 0; i < clip.options().images; ++i) images.push_back(clip.Draw(i));
  const int before = cv::getNumThreads();
  const auto tell = [&](const std::string& way, const Speed& speed, std::optional<double> target) {
    fmt::print("1024 x 780, {}: {:.0f} images/s, {:.0f} points followed in each\n", way, speed.images_s,
               speed.points);
    table.push_back({fmt::format("stabilise, reference, 1024 x 780, 1000 points, {}", way), speed.images_s,
                     "images/s", target, true, ""});
  };
  for (const int cores : {1, 2}) {
    cv::setNumThreads(cores);
    tell(fmt::format("{} core{}", cores, cores > 1 ? "s" : ""),
         Time(images, images.size(), false, clip.options().rate_hz),
         cores == 2 ? std::optional(60.0) : std::nullopt);
  }
  constexpr std::size_t kByOpenCl = 13;  // a processor takes long over them
  const Speed by_opencl = Time(images, kByOpenCl, true, clip.options().rate_hz);
  if (vision::OpenClStateNow() == vision::OpenClState::kUsed)
    tell(fmt::format("OpenCL on {}", *vision::OpenClDevice()), by_opencl, std::nullopt);
  else
    fmt::print("OpenCL: {}\n", vision::NameOf(vision::OpenClStateNow()));
  cv::setNumThreads(before);
}

}  // namespace kestrel::bench
