// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/mosaic_view.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace kestrel::app {
namespace {

using Eigen::Vector2d;

const cv::Size kHalf(640, 480);
const cv::Scalar kAgreed(80, 220, 80), kOutline(60, 60, 230), kBack(40, 40, 40);

cv::Mat Bgr(const cv::Mat& image) {
  if (image.channels() == 3) return image.clone();
  cv::Mat bgr;
  cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

cv::Point At(const Vector2d& v) { return {cvRound(v.x()), cvRound(v.y())}; }

// The largest of its shape that fits; shift and scale: of its pixels to those of the half.
cv::Mat Fitted(const cv::Mat& bgr, double& scale, Vector2d& shift) {
  cv::Mat half(kHalf, CV_8UC3, kBack), small;
  scale = std::min(1.0 * kHalf.width / bgr.cols, 1.0 * kHalf.height / bgr.rows);
  const cv::Size size(std::clamp(cvRound(scale * bgr.cols), 1, kHalf.width),
                      std::clamp(cvRound(scale * bgr.rows), 1, kHalf.height));
  cv::resize(bgr, small, size, 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  const cv::Rect place({(kHalf.width - size.width) / 2, (kHalf.height - size.height) / 2}, size);
  small.copyTo(half(place));
  shift = {place.x, place.y};
  return half;
}

void Caption(cv::Mat& half, const std::string& text) {
  cv::putText(half, text, {8, 20}, cv::FONT_HERSHEY_SIMPLEX, 0.5, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(half, text, {8, 20}, cv::FONT_HERSHEY_SIMPLEX, 0.5, {255, 255, 255}, 1, cv::LINE_AA);
}

// Cut where a surface all around is.
void DrawOutline(const vision::Mosaic& mosaic, int number, const vision::MosaicPicture& picture, double scale,
                 const Vector2d& shift, cv::Mat& half) {
  constexpr int kSteps = 12;
  const cv::Size size = mosaic.projection().image_size();
  const double w = size.width - 1, h = size.height - 1;
  const Vector2d corners[] = {{0, 0}, {w, 0}, {w, h}, {0, h}, {0, 0}};
  std::optional<Vector2d> last;
  for (int side = 0; side < 4; ++side)
    for (int i = 0; i <= kSteps; ++i) {
      const auto on = mosaic.PlaceOf(
          number, corners[side] + (corners[side + 1] - corners[side]) * (static_cast<double>(i) / kSteps));
      const int period = mosaic.projection().period_px();
      if (on && last && (period == 0 || std::abs(on->x() - last->x()) < period / 2.0)) {
        const auto drawn = [&](const Vector2d& p) {
          return At((p - picture.origin) / picture.scale * scale + shift);
        };
        cv::line(half, drawn(*last), drawn(*on), kOutline, 2, cv::LINE_AA);
      }
      last = on;
    }
}

}  // namespace

cv::Mat MosaicView(const vision::MosaicSeries::Step& step, const vision::Mosaic& mosaic,
                   const cv::Mat& image) {
  double scale = 1;
  Vector2d shift(0, 0);
  cv::Mat left = Fitted(Bgr(image), scale, shift);
  for (const vision::PixelPair& pair : mosaic.last_pairs()) {
    cv::line(left, At(scale * pair.a + shift), At(scale * pair.b + shift), kOutline, 1, cv::LINE_AA);
    cv::circle(left, At(scale * pair.b + shift), 3, kAgreed, 1, cv::LINE_AA);
  }
  Caption(left, fmt::format("{}   {} places agree, {:.2f} px", vision::NameOf(step.step.state),
                            step.step.agreed, step.step.rms_px));
  cv::Mat right(kHalf, CV_8UC3, kBack);
  // Not more pixels than are shown, or a large mosaic would take longer to show than to grow.
  int stride = 1;
  const cv::Size size = mosaic.CanvasSize();
  while (stride < 64 && size.width / stride > 2 * kHalf.width && size.height / stride > 2 * kHalf.height)
    stride *= 2;
  const vision::MosaicPicture picture = mosaic.Picture(stride);
  if (!picture.image.empty()) {
    right = Fitted(Bgr(picture.image), scale, shift);
    DrawOutline(mosaic, step.step.number, picture, scale, shift, right);
  }
  Caption(right, fmt::format("mosaic {}   {} keyframes   {} loops   scale 1:{:g}", step.mosaic + 1,
                             mosaic.keyframes(), mosaic.loops(), picture.scale / stride));
  cv::Mat both;
  cv::hconcat(left, right, both);
  return both;
}

}  // namespace kestrel::app
