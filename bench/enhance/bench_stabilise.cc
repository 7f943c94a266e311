// SPDX-License-Identifier: Apache-2.0
#include "bench/enhance/bench_stabilise.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "base/statistics.h"
#include "base/stopwatch.h"
#include "bench/enhance/shaken_clip.h"
#include "bench/enhance/stabilise_clips.h"
#include "bench/enhance/stabilise_drift.h"
#include "bench/enhance/stabilise_speed.h"
#include "bench/enhance/stabilise_stills.h"
#include "bench/enhance/steadiness.h"
#include "vision/enhance/stabilisation/stabiliser.h"
#include "vision/write_image.h"

namespace kestrel::bench {
namespace {

using vision::StabiliserOptions;

constexpr const char* kReference = "reference";  // of a hover alone: the view is to stand still

struct Way {
  std::string name;
  StabiliserOptions options;
};

std::vector<Way> Ways() {
  StabiliserOptions smooth, offline, lag_1, gyro, both, both_offline, reference;
  reference.mode = "reference";
  offline.mode = "offline";
  lag_1.lag_s = 1;
  gyro.by = "gyro", both.by = both_offline.by = "both", both_offline.mode = "offline";
  return {{"vision, lag 1 s", lag_1}, {"vision, lag 2 s", smooth}, {"vision, offline", offline},
          {"gyro, lag 2 s", gyro},    {"both, lag 2 s", both},     {"both, offline", both_offline},
          {kReference, reference}};
}

struct Result {
  Steadiness steadiness;
  double ms = 0;  // an image
  int lost = 0;   // images without a motion
};

Result Run(const ShakenClip& clip, const std::vector<cv::Mat>& images, const StabiliserOptions& options) {
  vision::Stabiliser stabiliser(options, clip.camera(), clip.options().rate_hz);
  const vision::GyroTrack gyro(clip.Gyro());
  std::vector<vision::ImageView> views;
  Result result;
  const auto start = std::chrono::steady_clock::now();
  const auto take = [&](const std::optional<vision::StabilisedImage>& image) {
    if (!image) return false;
    views.push_back(image->view);
    using S = vision::StabilisedState;
    result.lost +=
        image->state == S::kCut || image->state == S::kTextureless || image->state == S::kGyroAlone;
    return true;
  };
  for (int i = 0; i < static_cast<int>(images.size()); ++i)
    take(stabiliser.Step(images[static_cast<std::size_t>(i)], clip.t_s(i),
                         {gyro.Rows(clip.t_s(i), clip.options().readout_s), {}, clip.options().readout_s}));
  while (take(stabiliser.Finish())) {}
  result.ms = 1e3 * SecondsSince(start) / static_cast<double>(images.size());
  result.steadiness = SteadinessOf(clip, 0, views);
  return result;
}

struct Mean3 {
  std::vector<double> jitter, skew, stability, stability_in, distortion, crop, outside, ms;
  int lost = 0;
  void Add(const Result& r) {
    jitter.push_back(r.steadiness.Jitter()), skew.push_back(r.steadiness.Skew());
    stability.push_back(r.steadiness.stability), stability_in.push_back(r.steadiness.stability_in);
    distortion.push_back(r.steadiness.distortion), crop.push_back(r.steadiness.crop);
    outside.push_back(r.steadiness.outside), ms.push_back(r.ms);
    lost += r.lost;
  }
};

}  // namespace

void BenchStabilise(flight::SeedRange seeds, const std::filesystem::path& out,
                    std::vector<records::Figure>& table) {
  seeds.last = std::min(seeds.last, seeds.first + 2);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  std::map<std::string, Mean3> all;
  fmt::print(
      "| {:<10} | {:<17} | jitter px in, left | share  | skew   | stable | distortion | crop  | lost | ms   "
      "|\n",
      "clip", "way");
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    for (const ShakenClipOptions& of : StabiliseClips()) {
      const ShakenClip clip(of, seed);
      std::vector<cv::Mat> images;
      for (int i = 0; i < of.images; ++i) images.push_back(clip.Draw(i));
      for (const Way& way : Ways()) {
        if (way.name == kReference && of.name != "hover") continue;
        const Result r = Run(clip, images, way.options);
        const Steadiness& s = r.steadiness;
        fmt::print(
            "| {:<10} | {:<17} | {:8.2f} {:9.3f} | {:6.4f} | {:>6} | {:6.3f} | {:10.3f} | {:5.3f} | {:4} | "
            "{:4.1f} |\n",
            of.name, way.name, s.jitter_in_px, s.jitter_px, s.Jitter(),
            s.skew_in_px > 0 ? fmt::format("{:.3f}", s.Skew()) : "-", s.stability, s.distortion, s.crop,
            r.lost, r.ms);
        all[way.name].Add(r);
        const bool still = (of.name == "hover" || of.readout_s > 0) &&
                           (way.name == kReference || way.name.ends_with("lag 2 s"));
        if (!out.empty() && still && seed == seeds.first)
          WriteStabiliseStills(clip, images, way.options,
                               of.name + "_" + way.name.substr(0, way.name.find(',')), out);
      }
    }
  }
  cv::setNumThreads(threads);
  for (const auto& [name, mean] : all) {
    const double target = name.starts_with("vision") || name == kReference ? 0.05 : 0.02;
    table.push_back(
        {fmt::format("stabilise, {}: jitter left", name), Mean(mean.jitter), "share", target, false, ""});
    if (name == kReference)
      table.push_back(
          {"stabilise, reference: time of an image", Mean(mean.ms), "ms", 1000.0 / 120, false, ""});
  }
  BenchReferenceDrift(seeds.first, table);
  TimeStabiliser(seeds.first, table);
}

}  // namespace kestrel::bench
