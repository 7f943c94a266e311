// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/composition.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/stitching/detail/blenders.hpp>
#include <vector>

#include "vision/enhance/mosaic/composition_parts.h"

namespace kestrel::vision {
namespace {

// Memory of one pixel of the picture, bytes.
std::int64_t BytesOfPixel(Composer composer) {
  constexpr std::int64_t kTiles = 20, kPicture = 8, kBands = 60;
  return composer == Composer::kMultiBand ? kBands : composer == Composer::kMedian ? kPicture : kTiles;
}

cv::Rect Extent(const std::vector<CompositionPart>& parts, int halvings, int period_px) {
  cv::Rect all;
  for (const CompositionPart& part : parts) all |= Halved(part.part, halvings);
  if (period_px > 0) all &= Halved({-period_px / 2, -(1 << 28), period_px, 1 << 29}, halvings);
  return all;
}

class Composition {
 public:
  Composition(const Mosaic& mosaic, const CompositionOptions& options)
      : projection_(mosaic.projection()), options_(options), parts_(CompositionParts(mosaic)) {
    const std::int64_t most = std::max<std::int64_t>(1, options.most_bytes / BytesOfPixel(options.composer));
    do {
      all_ = Extent(parts_, halvings_, projection_.period_px());
    } while (std::int64_t{all_.width} * all_.height > most && ++halvings_ < 12);
    if (options.exposure) BalanceExposures(projection_, options.most_bytes, parts_);
    if (options.composer == Composer::kSeams || options.composer == Composer::kMultiBand)
      CutSeams(projection_, options.most_bytes, parts_);
  }

  MosaicPicture Picture() const {
    MosaicPicture picture;
    if (all_.empty()) return picture;
    switch (options_.composer) {
      case Composer::kAverage:
        picture = Drawn(Blending::kAverage);
        break;
      case Composer::kFeather:
        picture = Drawn(Blending::kFeather);
        break;
      case Composer::kNearest:
      case Composer::kSeams:
        picture = Drawn(Blending::kNearest);
        break;
      case Composer::kMedian:
        picture = Median();
        break;
      case Composer::kMultiBand:
        picture = Banded();
        break;
    }
    return picture;
  }

 private:
  ProjectedImage Project(const CompositionPart& part, Blending blending, const cv::Rect& within) const {
    ProjectedImage projected =
        ProjectImage(projection_, part.image, part.M_WC, part.part, halvings_, blending, within);
    if (projected.part.empty()) return projected;
    if (part.gain != 1) projected.pixels.convertTo(projected.pixels, -1, part.gain);
    if (!part.seam.empty()) CutBySeam(part, halvings_, projected);
    return projected;
  }

  MosaicPicture Place(cv::Mat image, cv::Mat shown) const {
    MosaicPicture picture;
    const cv::Rect seen = cv::boundingRect(shown);
    if (seen.empty()) return picture;
    picture.image = image(seen).clone();
    picture.shown = shown(seen).clone();
    picture.scale = std::ldexp(1.0, halvings_);
    picture.origin = picture.scale * Eigen::Vector2d(all_.x + seen.x + 0.5, all_.y + seen.y + 0.5) -
                     Eigen::Vector2d::Constant(0.5);
    return picture;
  }

  MosaicPicture Drawn(Blending blending) const {
    // Its tiles begin at the picture's corner, at whatever scale that is.
    Canvas canvas(blending, parts_.front().image.channels(), options_.most_bytes);
    for (const CompositionPart& part : parts_) {
      const ProjectedImage projected = Project(part, blending, all_);
      if (!projected.part.empty())
        canvas.Draw(projected.part - all_.tl(), projected.pixels, projected.weights);
    }
    const MosaicPicture drawn = canvas.Picture();
    if (drawn.image.empty()) return drawn;
    MosaicPicture picture = drawn;
    picture.scale = std::ldexp(1.0, halvings_);
    picture.origin = picture.scale * (drawn.origin + Eigen::Vector2d(all_.x + 0.5, all_.y + 0.5)) -
                     Eigen::Vector2d::Constant(0.5);
    return picture;
  }

  MosaicPicture Median() const {
    cv::Mat image = cv::Mat::zeros(all_.size(), parts_.front().image.type()),
            shown = cv::Mat::zeros(all_.size(), CV_8UC1);
    constexpr int kTile_px = 512;
    const int across = (all_.width + kTile_px - 1) / kTile_px, down = (all_.height + kTile_px - 1) / kTile_px;
    cv::parallel_for_({0, across * down}, [&](const cv::Range& range) {
      for (int i = range.start; i < range.end; ++i) {
        const cv::Rect tile =
            cv::Rect(all_.x + i % across * kTile_px, all_.y + i / across * kTile_px, kTile_px, kTile_px) &
            all_;
        MedianOf(tile, image(tile - all_.tl()), shown(tile - all_.tl()));
      }
    });
    return Place(image, shown);
  }

  void MedianOf(const cv::Rect& tile, cv::Mat image, cv::Mat shown) const {
    std::vector<ProjectedImage> here;
    for (const CompositionPart& part : parts_)
      if (!(Halved(part.part, halvings_) & tile).empty())
        if (ProjectedImage projected = Project(part, Blending::kAverage, tile); !projected.part.empty())
          here.push_back(std::move(projected));
    const int channels = image.channels();
    std::vector<std::vector<std::uint8_t>> values(static_cast<std::size_t>(channels));
    for (int y = 0; y < tile.height; ++y)
      for (int x = 0; x < tile.width; ++x) {
        for (auto& channel : values) channel.clear();
        const cv::Point at(tile.x + x, tile.y + y);
        for (const ProjectedImage& each : here) {
          if (!each.part.contains(at)) continue;
          const cv::Point in = at - each.part.tl();
          if (each.weights.at<float>(in) <= 0) continue;
          const std::uint8_t* pixel = each.pixels.ptr<std::uint8_t>(in.y) + in.x * channels;
          for (int c = 0; c < channels; ++c) values[static_cast<std::size_t>(c)].push_back(pixel[c]);
        }
        if (values[0].empty()) continue;
        shown.at<std::uint8_t>(y, x) = 255;
        for (int c = 0; c < channels; ++c) {
          auto& all = values[static_cast<std::size_t>(c)];
          const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
          std::nth_element(all.begin(), middle, all.end());
          image.ptr<std::uint8_t>(y)[x * channels + c] = *middle;
        }
      }
  }

  MosaicPicture Banded() const {
    constexpr int kBands = 5;
    cv::detail::MultiBandBlender blender(false, kBands, CV_32F);
    blender.prepare(all_);
    const int channels = parts_.front().image.channels();
    for (const CompositionPart& part : parts_) {
      const ProjectedImage projected = Project(part, Blending::kAverage, all_);
      if (projected.part.empty()) continue;
      const cv::Mat mask = projected.weights > 0;
      if (cv::countNonZero(mask) == 0) continue;
      cv::Mat colour, wide;
      if (channels == 1)
        cv::cvtColor(projected.pixels, colour, cv::COLOR_GRAY2BGR);
      else
        colour = projected.pixels;
      colour.convertTo(wide, CV_16S);
      blender.feed(wide, mask, projected.part.tl());
    }
    cv::Mat blended, shown, image;
    blender.blend(blended, shown);
    blended.convertTo(image, CV_8U);
    if (channels == 1) cv::extractChannel(image.clone(), image, 0);
    return Place(image, shown);
  }

  const Projection& projection_;
  CompositionOptions options_;
  std::vector<CompositionPart> parts_;
  int halvings_ = 0;
  cv::Rect all_;  // of the picture, in its own pixels
};

}  // namespace

MosaicPicture Compose(const Mosaic& mosaic, const CompositionOptions& options) {
  if (mosaic.keyframes() == 0) return {};
  return Composition(mosaic, options).Picture();
}

}  // namespace kestrel::vision
