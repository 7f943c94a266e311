// SPDX-License-Identifier: Apache-2.0
#include "bench/enhance/stabilise_stills.h"

#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "vision/enhance/stabilisation/gyro_track.h"
#include "vision/enhance/stabilisation/stabiliser.h"
#include "vision/write_image.h"

namespace kestrel::bench {

void WriteStabiliseStills(const ShakenClip& clip, const std::vector<cv::Mat>& images,
                          const vision::StabiliserOptions& options, const std::string& name,
                          const std::filesystem::path& out) {
  const int count = static_cast<int>(images.size()), middle = count / 2,
            half = static_cast<int>(clip.options().rate_hz / 2);
  vision::Stabiliser stabiliser(options, clip.camera(), clip.options().rate_hz);
  const vision::GyroTrack gyro(clip.Gyro());
  cv::Mat matched, shown, mean_in = cv::Mat::zeros(images[0].size(), CV_32FC1), mean_out;
  const auto take = [&](const std::optional<vision::StabilisedImage>& image) {
    if (!image) return false;
    const int i = static_cast<int>(image->number);
    if (i == middle) shown = image->image;
    if (mean_out.empty()) mean_out = cv::Mat::zeros(image->image.size(), CV_32FC1);
    if (std::abs(i - middle) > half) return true;
    cv::accumulate(images[static_cast<std::size_t>(i)], mean_in);
    cv::accumulate(image->image, mean_out);
    return true;
  };
  for (int i = 0; i < count; ++i) {
    const cv::Mat& image = images[static_cast<std::size_t>(i)];
    take(stabiliser.Step(image, clip.t_s(i),
                         {gyro.Rows(clip.t_s(i), clip.options().readout_s), {}, clip.options().readout_s}));
    if (i != middle) continue;
    cv::cvtColor(image, matched, cv::COLOR_GRAY2BGR);
    for (const vision::PointPair& pair : stabiliser.last_inliers())
      cv::line(matched, cv::Point2d(pair.from.x(), pair.from.y()), cv::Point2d(pair.to.x(), pair.to.y()),
               {80, 255, 80}, 1, cv::LINE_AA);
  }
  while (take(stabiliser.Finish())) {}
  cv::Mat both, shown_bgr, second;
  cv::cvtColor(shown, shown_bgr, cv::COLOR_GRAY2BGR);
  cv::hconcat(matched, shown_bgr, both);
  cv::hconcat(mean_in, mean_out, second);
  second.convertTo(second, CV_8U, 1.0 / (2 * half + 1));
  std::filesystem::create_directories(out);
  vision::WriteImage(out / (name + ".jpg"), both);
  vision::WriteImage(out / (name + "_second.jpg"), second);
}

}  // namespace kestrel::bench
