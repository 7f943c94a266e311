// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "vision/enhance/canvas/blending.h"

namespace kestrel::vision {

// A part of a surface as a picture.
struct MosaicPicture {
  cv::Mat image;  // CV_8UC1 or CV_8UC3; black where nothing was seen
  cv::Mat shown;  // CV_8UC1, 255 where something was seen
  // The pixel (x, y) is at origin + scale * (x, y) of the surface.
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  double scale = 1;
};

// What is drawn on a surface, one image after the other, figure 4.6 of the thesis: it grows by tiles, and where
// it would outgrow its memory it is scaled down by half. The thesis calculates the scale anew that just fits a
// picture of a given size; halves average whole pixels, so that nothing is blurred again and again.
class Canvas {
 public:
  static constexpr int kTile_px = 256;

  // channels: 1 or 3. most_bytes: of all its tiles; at least four of them are kept.
  Canvas(Blending blending, int channels, std::int64_t most_bytes);

  // Makes room for a part of the surface, in its own pixels. halvings() says at which scale it is to be drawn.
  void MakeRoom(const cv::Rect& part);
  // How often it was scaled down. The canvas's pixel i covers those of the surface from i 2^h to (i + 1) 2^h - 1.
  int halvings() const { return halvings_; }
  // Blends pixels (CV_8U) by their weights (CV_32FC1, 0: none). part: in pixels of the canvas.
  void Draw(const cv::Rect& part, const cv::Mat& pixels, const cv::Mat& weights);
  void Clear();
  void ClearTile(const cv::Rect& tile);
  std::vector<cv::Rect> tiles()
      const;  // where something was drawn, each of kTile_px, in pixels of the canvas

  std::int64_t bytes() const;
  cv::Rect extent() const;  // of its tiles, in pixels of the canvas; empty: nothing was drawn
  // All that was drawn, cut to what was seen. stride: of every so many pixels one, a power of two below kTile_px.
  MosaicPicture Picture(int stride = 1) const;

 private:
  using Place = std::pair<int, int>;  // row and column of a tile

  void Halve();
  std::int64_t TileBytes() const;

  Blending blending_;
  int channels_;
  std::int64_t most_tiles_;
  int halvings_ = 0;
  std::map<Place, cv::Mat>
      tiles_;  // CV_32F: sums of the weighted channels, then of weights; or the nearest's
};

// Of pixels of a surface, those of a canvas that was scaled down so often that hold them all.
cv::Rect Halved(const cv::Rect& part, int halvings);

}  // namespace kestrel::vision
