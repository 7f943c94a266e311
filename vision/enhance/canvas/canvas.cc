// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/canvas/canvas.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kestrel::vision {
namespace {

constexpr int kTile = Canvas::kTile_px, kTileBits = 8;
static_assert(1 << kTileBits == kTile);

int FloorDiv(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

template <int kChannels>
void Blend(Blending blending, const cv::Mat& pixels, const cv::Mat& weights, cv::Mat sums) {
  const bool nearest = blending == Blending::kNearest;
  for (int y = 0; y < sums.rows; ++y) {
    const std::uint8_t* from = pixels.ptr<std::uint8_t>(y);
    const float* w = weights.ptr<float>(y);
    float* to = sums.ptr<float>(y);
    for (int x = 0; x < sums.cols; ++x, from += kChannels, to += kChannels + 1) {
      if (nearest) {
        if (w[x] <= to[kChannels]) continue;
        for (int c = 0; c < kChannels; ++c) to[c] = from[c];
        to[kChannels] = w[x];
      } else {
        for (int c = 0; c < kChannels; ++c) to[c] += w[x] * static_cast<float>(from[c]);
        to[kChannels] += w[x];
      }
    }
  }
}

// Four pixels of a tile, where something was seen: sums add up, and of the nearest the mean is as near as the
// nearest of them.
template <int kChannels>
void HalveInto(Blending blending, const cv::Mat& tile, cv::Mat quarter) {
  for (int y = 0; y < quarter.rows; ++y)
    for (int x = 0; x < quarter.cols; ++x) {
      float* to = quarter.ptr<float>(y) + x * (kChannels + 1);
      int seen = 0;
      for (int k = 0; k < 4; ++k) {
        const float* from = tile.ptr<float>(2 * y + k / 2) + (2 * x + k % 2) * (kChannels + 1);
        if (from[kChannels] <= 0) continue;
        ++seen;
        for (int c = 0; c < kChannels; ++c) to[c] += from[c];
        to[kChannels] = blending == Blending::kNearest ? std::max(to[kChannels], from[kChannels])
                                                       : to[kChannels] + from[kChannels];
      }
      if (blending == Blending::kNearest && seen > 1)
        for (int c = 0; c < kChannels; ++c) to[c] /= static_cast<float>(seen);
    }
}

template <int kChannels>
void Develop(Blending blending, const cv::Mat& sums, int stride, cv::Mat image, cv::Mat shown) {
  for (int y = 0; y < image.rows; ++y) {
    const float* from = sums.ptr<float>(y * stride + stride / 2) + stride / 2 * (kChannels + 1);
    std::uint8_t *to = image.ptr<std::uint8_t>(y), *seen = shown.ptr<std::uint8_t>(y);
    for (int x = 0; x < image.cols; ++x, from += stride * (kChannels + 1), to += kChannels) {
      if (from[kChannels] <= 0) continue;
      const float by = blending == Blending::kNearest ? 1 : 1 / from[kChannels];
      for (int c = 0; c < kChannels; ++c) to[c] = cv::saturate_cast<std::uint8_t>(from[c] * by);
      seen[x] = 255;
    }
  }
}

}  // namespace

cv::Rect Halved(const cv::Rect& part, int halvings) {
  if (part.empty()) return {};
  const int by = 1 << halvings;
  const int x0 = FloorDiv(part.x, by), y0 = FloorDiv(part.y, by);
  return {x0, y0, FloorDiv(part.x + part.width - 1, by) + 1 - x0,
          FloorDiv(part.y + part.height - 1, by) + 1 - y0};
}

Canvas::Canvas(Blending blending, int channels, std::int64_t most_bytes)
    : blending_(blending),
      channels_(channels),
      most_tiles_(std::max<std::int64_t>(4, most_bytes / TileBytes())) {
  assert(channels == 1 || channels == 3);
}

std::int64_t Canvas::TileBytes() const {
  return std::int64_t{kTile} * kTile * (channels_ + 1) * static_cast<std::int64_t>(sizeof(float));
}

std::int64_t Canvas::bytes() const { return static_cast<std::int64_t>(tiles_.size()) * TileBytes(); }

void Canvas::MakeRoom(const cv::Rect& part) {
  constexpr int kMostHalvings = 12;
  while (halvings_ < kMostHalvings) {
    const cv::Rect tiles = Halved(Halved(part, halvings_), kTileBits),
                   all = tiles | Halved(extent(), kTileBits);
    // A picture is of all between tiles that are far apart too, in bytes where tiles are of floats.
    const bool fits = std::int64_t{all.width} * all.height <= 4 * most_tiles_;
    std::int64_t needed = static_cast<std::int64_t>(tiles_.size());
    for (int row = tiles.y; row < tiles.br().y && needed <= most_tiles_; ++row)
      for (int column = tiles.x; column < tiles.br().x && needed <= most_tiles_; ++column)
        needed += !tiles_.contains({row, column});
    if (fits && needed <= most_tiles_) return;
    Halve();
  }
}

void Canvas::Halve() {
  std::map<Place, cv::Mat> halved;
  for (const auto& [place, tile] : tiles_) {
    const Place to{FloorDiv(place.first, 2), FloorDiv(place.second, 2)};
    cv::Mat& into = halved[to];
    if (into.empty()) into = cv::Mat::zeros(kTile, kTile, CV_MAKETYPE(CV_32F, channels_ + 1));
    const cv::Mat quarter = into(cv::Rect((place.second - 2 * to.second) * kTile / 2,
                                          (place.first - 2 * to.first) * kTile / 2, kTile / 2, kTile / 2));
    channels_ == 1 ? HalveInto<1>(blending_, tile, quarter) : HalveInto<3>(blending_, tile, quarter);
  }
  tiles_ = std::move(halved);
  ++halvings_;
}

void Canvas::Draw(const cv::Rect& part, const cv::Mat& pixels, const cv::Mat& weights) {
  assert(pixels.channels() == channels_ && pixels.size() == part.size() && weights.size() == part.size());
  if (part.empty()) return;
  const cv::Rect tiles = Halved(part, kTileBits);
  for (int row = tiles.y; row < tiles.br().y; ++row)
    for (int column = tiles.x; column < tiles.br().x; ++column) {
      const cv::Point corner(column * kTile, row * kTile);
      const cv::Rect here = part & cv::Rect(corner, cv::Size(kTile, kTile)), of_part = here - part.tl();
      const cv::Mat its_weights = weights(of_part);
      const auto found = tiles_.find({row, column});
      if (found == tiles_.end() && cv::countNonZero(its_weights) == 0) continue;
      cv::Mat& tile = found == tiles_.end() ? tiles_[{row, column}] : found->second;
      if (tile.empty()) tile = cv::Mat::zeros(kTile, kTile, CV_MAKETYPE(CV_32F, channels_ + 1));
      const cv::Mat sums = tile(here - corner);
      channels_ == 1 ? Blend<1>(blending_, pixels(of_part), its_weights, sums)
                     : Blend<3>(blending_, pixels(of_part), its_weights, sums);
    }
}

void Canvas::Clear() { tiles_.clear(), halvings_ = 0; }

void Canvas::ClearTile(const cv::Rect& tile) { tiles_.erase({tile.y / kTile, tile.x / kTile}); }

std::vector<cv::Rect> Canvas::tiles() const {
  std::vector<cv::Rect> all;
  for (const auto& [place, tile] : tiles_)
    all.emplace_back(place.second * kTile, place.first * kTile, kTile, kTile);
  return all;
}

cv::Rect Canvas::extent() const {
  cv::Rect all;
  for (const auto& [place, tile] : tiles_)
    all |= cv::Rect(place.second * kTile, place.first * kTile, kTile, kTile);
  return all;
}

MosaicPicture Canvas::Picture(int stride) const {
  assert(stride > 0 && kTile % stride == 0);
  const cv::Rect all = extent();
  MosaicPicture picture;
  if (all.empty()) return picture;
  const int tile_px = kTile / stride;
  picture.image = cv::Mat::zeros(all.size() / stride, CV_MAKETYPE(CV_8U, channels_));
  picture.shown = cv::Mat::zeros(all.size() / stride, CV_8UC1);
  for (const auto& [place, tile] : tiles_) {
    const cv::Rect here((place.second * kTile - all.x) / stride, (place.first * kTile - all.y) / stride,
                        tile_px, tile_px);
    channels_ == 1 ? Develop<1>(blending_, tile, stride, picture.image(here), picture.shown(here))
                   : Develop<3>(blending_, tile, stride, picture.image(here), picture.shown(here));
  }
  const cv::Rect seen = cv::boundingRect(picture.shown);
  picture.image = picture.image(seen).clone();
  picture.shown = picture.shown(seen).clone();
  const Eigen::Vector2d first(all.x + seen.x * stride + stride / 2, all.y + seen.y * stride + stride / 2);
  picture.scale = std::ldexp(stride, halvings_);
  picture.origin =
      std::ldexp(1.0, halvings_) * (first + Eigen::Vector2d(0.5, 0.5)) - Eigen::Vector2d(0.5, 0.5);
  return picture;
}

}  // namespace kestrel::vision
