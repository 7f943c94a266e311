// SPDX-License-Identifier: Apache-2.0
#include "mission/mosaic/mosaic_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mission/caption/caption.h"

namespace kestrel::mission {
namespace {

const cv::Scalar kRed(60, 60, 255);

cv::Mat InColour(const cv::Mat& image) {
  cv::Mat bgr = image;
  if (image.channels() == 1) cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

}  // namespace

cv::Mat DrawnMosaic(const vision::Mosaic& mosaic, const cv::Mat& image, cv::Size size,
                    const std::string& caption) {
  cv::Mat drawn(size, CV_8UC3, cv::Scalar::all(0));
  const vision::MosaicPicture picture = mosaic.Picture();
  if (!picture.image.empty()) {
    const double scale = std::min({static_cast<double>(size.width) / picture.image.cols,
                                   static_cast<double>(size.height) / picture.image.rows, 1.0});
    cv::Mat small;
    cv::resize(InColour(picture.image), small, {}, scale, scale, cv::INTER_AREA);
    const cv::Point corner((size.width - small.cols) / 2, (size.height - small.rows) / 2);
    small.copyTo(drawn(cv::Rect(corner, small.size()) & cv::Rect({}, size)));
    std::vector<cv::Point> outline;
    const double right = image.cols - 1, bottom = image.rows - 1;
    for (const Eigen::Vector2d& uv :
         {Eigen::Vector2d(0, 0), {right, 0}, Eigen::Vector2d(right, bottom), Eigen::Vector2d(0, bottom)})
      if (const auto place = mosaic.PlaceOf(mosaic.images() - 1, uv)) {
        const Eigen::Vector2d at = (*place - picture.origin) / picture.scale * scale;
        outline.emplace_back(corner.x + static_cast<int>(std::lround(at.x())),
                             corner.y + static_cast<int>(std::lround(at.y())));
      }
    // On a surface all around an image may lie on both sides of the cut.
    const bool whole = outline.size() == 4 && cv::boundingRect(outline).width < size.width / 2;
    if (whole) cv::polylines(drawn, outline, true, kRed, 2, cv::LINE_AA);
  }
  cv::Mat inset;
  cv::resize(InColour(image), inset, {size.width / 4, size.width / 4 * image.rows / image.cols}, 0, 0,
             cv::INTER_AREA);
  inset.copyTo(drawn(cv::Rect({}, inset.size())));
  cv::rectangle(drawn, cv::Rect({}, inset.size()), kRed, 2);
  NameMark(drawn, {8, size.height - 10}, caption);
  return drawn;
}

cv::Mat Tiled(const std::vector<cv::Mat>& pictures) {
  constexpr std::size_t kColumns = 3;
  constexpr int kGap_px = 6;
  if (pictures.empty()) return {};
  const cv::Size size = pictures.front().size();
  const int columns = static_cast<int>(std::min(kColumns, pictures.size()));
  const int rows = static_cast<int>((pictures.size() + kColumns - 1) / kColumns);
  cv::Mat tiled(rows * (size.height + kGap_px) - kGap_px, columns * (size.width + kGap_px) - kGap_px, CV_8UC3,
                cv::Scalar::all(255));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const cv::Point at(static_cast<int>(i % kColumns) * (size.width + kGap_px),
                       static_cast<int>(i / kColumns) * (size.height + kGap_px));
    pictures[i].copyTo(tiled(cv::Rect(at, size)));
  }
  return tiled;
}

}  // namespace kestrel::mission
