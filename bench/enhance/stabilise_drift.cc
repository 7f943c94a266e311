// SPDX-License-Identifier: Apache-2.0
#include "bench/enhance/stabilise_drift.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "base/statistics.h"
#include "bench/enhance/shaken_clip.h"
#include "vision/enhance/stabilisation/stabiliser.h"

namespace kestrel::bench {
namespace {

// Of the places that the first image shows and this one too, where the view shows them against where it showed them.
std::vector<double> Errors_px(const ShakenClip& clip, int i, const vision::ImageView& first,
                              const vision::ImageView& view) {
  const vision::CameraModel camera = clip.camera();
  const cv::Size size = clip.options().size;
  constexpr int kSteps = 8;
  std::vector<double> errors;
  for (int y = 0; y < kSteps; ++y)
    for (int x = 0; x < kSteps; ++x) {
      const Eigen::Vector2d uv((x + 0.5) * size.width / kSteps, (y + 0.5) * size.height / kSteps);
      const Eigen::Vector2d seen =
          clip.SeenFrom(clip.X_NC(clip.t_s(i)), clip.Ground(clip.X_NC(clip.t_s(0)), uv));
      if (!cv::Rect2d(0, 0, size.width - 1, size.height - 1).contains({seen.x(), seen.y()})) continue;
      errors.push_back((*vision::ShownAt(view, &camera, seen) - *vision::ShownAt(first, &camera, uv)).norm());
    }
  return errors;
}

}  // namespace

void BenchReferenceDrift(std::uint64_t seed, std::vector<records::Figure>& table) {
  ShakenClipOptions of{.name = "to and fro", .size = {320, 240}, .images = 1800};
  of.wander_m = 6;
  const ShakenClip clip(of, seed);
  vision::StabiliserOptions options;
  options.mode = "reference", options.crop = 1;
  vision::Stabiliser stabiliser(options, {}, of.rate_hz);
  const int tenth = of.images / 10;
  vision::ImageView first;
  std::vector<double> begin, end;
  int anchors = 0;
  for (int i = 0; i < of.images; ++i) {
    const auto image = stabiliser.Step(clip.Draw(i), clip.t_s(i));
    if (i == 0) first = image->view;
    anchors += image->state == vision::StabilisedState::kReanchored;
    const std::vector<double> errors = Errors_px(clip, i, first, image->view);
    if (i < tenth) begin.insert(begin.end(), errors.begin(), errors.end());
    if (i >= of.images - tenth) end.insert(end.end(), errors.begin(), errors.end());
  }
  fmt::print(
      "reference, a minute to and fro: off by {:.3f} px in its first tenth, by {:.3f} px in its last; {} new "
      "references\n",
      Rms(begin), Rms(end), anchors);
  table.push_back(
      {"stabilise, reference: off after 1,800 images to and fro", Rms(end), "px", 0.5, false, ""});
}

}  // namespace kestrel::bench
