// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/composition_parts.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/stitching/detail/exposure_compensate.hpp>
#include <opencv2/stitching/detail/seam_finders.hpp>
#include <utility>

namespace kestrel::vision {
namespace {

// Exposures and seams are sought in images of about so many pixels.
constexpr double kSmall_px = 20000;

struct SmallParts {
  int halvings = 0;
  std::vector<cv::Point> corners;
  std::vector<cv::Mat> pixels, masks;  // CV_8UC3; CV_8UC1
};

// Memory of them all, bytes.
std::int64_t BytesOfSmall(const std::vector<CompositionPart>& parts, int halvings) {
  constexpr std::int64_t kPixel = 20, kCovered = 4;
  std::int64_t sum = 0;
  cv::Rect all;
  for (const CompositionPart& part : parts) {
    const cv::Rect here = Halved(part.part, halvings);
    sum += kPixel * here.width * here.height;
    all |= here;
  }
  return sum + kCovered * all.width * all.height;
}

SmallParts Small(const Projection& projection, const std::vector<CompositionPart>& parts,
                 std::int64_t most_bytes) {
  SmallParts small;
  const double area = projection.image_size().area();
  constexpr int kMostHalvings = 12;
  while (area / std::pow(4, small.halvings) > kSmall_px) ++small.halvings;
  while (small.halvings < kMostHalvings && BytesOfSmall(parts, small.halvings) > most_bytes) ++small.halvings;
  for (const CompositionPart& part : parts) {
    const std::optional<cv::Rect> all = projection.period_px() > 0
                                            ? std::optional(Halved({-projection.period_px() / 2, part.part.y,
                                                                    projection.period_px(), part.part.height},
                                                                   small.halvings))
                                            : std::nullopt;
    const ProjectedImage projected =
        ProjectImage(projection, part.image, part.M_WC, part.part, small.halvings, Blending::kAverage, all);
    small.corners.push_back(projected.part.tl());
    if (projected.pixels.channels() == 1)
      cv::cvtColor(projected.pixels, small.pixels.emplace_back(), cv::COLOR_GRAY2BGR);
    else
      small.pixels.push_back(projected.pixels);
    small.masks.push_back(projected.weights > 0);
  }
  return small;
}

std::vector<cv::UMat> AsUMats(const std::vector<cv::Mat>& mats, int depth) {
  std::vector<cv::UMat> all(mats.size());
  for (std::size_t i = 0; i < mats.size(); ++i) mats[i].convertTo(all[i], depth);
  return all;
}

// Of every place by how many it is shown.
cv::Mat Coverage(const SmallParts& small, cv::Point& corner) {
  cv::Rect all;
  for (std::size_t i = 0; i < small.masks.size(); ++i)
    all |= cv::Rect(small.corners[i], small.masks[i].size());
  corner = all.tl();
  cv::Mat coverage = cv::Mat::zeros(all.size(), CV_32SC1);
  for (std::size_t i = 0; i < small.masks.size(); ++i) {
    cv::Mat here = coverage(cv::Rect(small.corners[i] - corner, small.masks[i].size()));
    cv::add(here, cv::Scalar(1), here, small.masks[i]);
  }
  return coverage;
}

// Without which images nothing would be missing, every other one first, so that they thin evenly.
std::vector<bool> Needed(const SmallParts& small) {
  const std::size_t n = small.masks.size();
  cv::Point corner;
  cv::Mat coverage = Coverage(small, corner);
  std::vector<bool> needed(n, true);
  for (std::size_t stride = 2; stride <= 2 * n; stride *= 2)
    for (std::size_t i = stride / 2; i < n; i += stride) {
      if (!needed[i]) continue;
      cv::Mat here = coverage(cv::Rect(small.corners[i] - corner, small.masks[i].size()));
      const cv::Mat alone = (here == 1) & small.masks[i];
      if (cv::countNonZero(alone) > 0) continue;
      needed[i] = false;
      cv::subtract(here, cv::Scalar(1), here, small.masks[i]);
    }
  return needed;
}

}  // namespace

std::vector<CompositionPart> CompositionParts(const Mosaic& mosaic) {
  std::vector<CompositionPart> parts;
  for (const Mosaic::Kept& kept : mosaic.kept()) {
    const cv::Rect part = mosaic.projection().PartOf(kept.M_WC);
    for (const cv::Rect& moved : WrappedParts(part, mosaic.projection().period_px()))
      if (!moved.empty())
        parts.push_back(
            {.image = kept.image, .M_WC = kept.M_WC, .part = moved, .gain = 1, .seam = {}, .seam_part = {}});
  }
  return parts;
}

void BalanceExposures(const Projection& projection, std::int64_t most_bytes,
                      std::vector<CompositionPart>& parts) {
  if (parts.size() < 2) return;
  const SmallParts small = Small(projection, parts, most_bytes);
  cv::detail::GainCompensator compensator;
  std::vector<std::pair<cv::UMat, std::uint8_t>> masks;
  for (const cv::UMat& mask : AsUMats(small.masks, CV_8U)) masks.emplace_back(mask, std::uint8_t{255});
  compensator.feed(small.corners, AsUMats(small.pixels, CV_8U), masks);
  std::vector<cv::Mat> gains;
  compensator.getMatGains(gains);
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i].gain = gains[i].at<double>(0);
}

void CutSeams(const Projection& projection, std::int64_t most_bytes, std::vector<CompositionPart>& parts) {
  SmallParts small = Small(projection, parts, most_bytes);
  const std::vector<bool> needed = Needed(small);
  std::vector<CompositionPart> left;
  SmallParts of_left;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!needed[i]) continue;
    small.pixels[i].convertTo(small.pixels[i], -1, parts[i].gain);
    left.push_back(std::move(parts[i]));
    of_left.corners.push_back(small.corners[i]);
    of_left.pixels.push_back(small.pixels[i]);
    of_left.masks.push_back(small.masks[i]);
  }
  parts = std::move(left);
  std::vector<cv::UMat> masks = AsUMats(of_left.masks, CV_8U);
  cv::detail::GraphCutSeamFinder(cv::detail::GraphCutSeamFinderBase::COST_COLOR)
      .find(AsUMats(of_left.pixels, CV_32F), of_left.corners, masks);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    masks[i].copyTo(parts[i].seam);
    // A little wider, so that between the coarse pixels of two no gap is left.
    cv::dilate(parts[i].seam, parts[i].seam, cv::Mat());
    parts[i].seam_part = {of_left.corners[i], parts[i].seam.size()};
    parts[i].seam_halvings = small.halvings;
  }
}

void CutBySeam(const CompositionPart& part, int halvings, ProjectedImage& projected) {
  const double to_seam = std::ldexp(1.0, halvings - part.seam_halvings);
  const PixelMap map = MakePixelMap(projected.part, 16, [&](const Eigen::Vector2d& pixel) {
    const Eigen::Vector2d at = to_seam * (pixel + Eigen::Vector2d(0.5, 0.5)) - Eigen::Vector2d(0.5, 0.5);
    return std::optional<Eigen::Vector2d>(at - Eigen::Vector2d(part.seam_part.x, part.seam_part.y));
  });
  cv::Mat shown;
  cv::remap(part.seam, shown, map.u, map.v, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  projected.weights.setTo(0, shown < 128);
}

}  // namespace kestrel::vision
