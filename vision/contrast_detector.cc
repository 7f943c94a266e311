// SPDX-License-Identifier: Apache-2.0
#include "vision/contrast_detector.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "geometry/tait_bryan.h"

namespace kestrel {

namespace {

constexpr int kLevels = 5;                 // of the pyramid: things of about 2 to 5 px in each
constexpr int kFine = 2;                   // levels finer than the candidate's, in which it is measured
constexpr int kAround = 4;                 // px to the places it is compared with
constexpr int kInner = 5, kOuter = 7;      // px of the candidate's level: the ring of the blob's background
constexpr int kNeighbourhood = 16;         // px of its level, in which a candidate must stand out
constexpr double kLeastSky = 0.005;        // share of the image
constexpr double kDark = 8, kWhite = 250;  // grey levels
constexpr int kLeastResponse = 4;          // grey levels of the mean of 3 x 3 px

struct Level {
  cv::Mat image, sky;  // sky: 255 or 0
  cv::Mat response;    // CV_8UC1
};

// How much each place differs from all around it, whatever the sign; 0 where there is no sky. What is no sky
// around it is not asked.
cv::Mat ResponseOf(const cv::Mat& smooth, const cv::Mat& ground) {
  cv::Mat high, low, least, most, dark, light;
  cv::copyMakeBorder(smooth, high, kAround, kAround, kAround, kAround, cv::BORDER_CONSTANT, 255);
  cv::copyMakeBorder(smooth, low, kAround, kAround, kAround, kAround, cv::BORDER_CONSTANT, 0);
  const cv::Rect middle(kAround, kAround, smooth.cols, smooth.rows);
  high(middle).setTo(255, ground);
  low(middle).setTo(0, ground);
  constexpr int kDiagonal = 3;
  const std::array<cv::Point, 8> around{{{kAround, 0},
                                         {-kAround, 0},
                                         {0, kAround},
                                         {0, -kAround},
                                         {kDiagonal, kDiagonal},
                                         {kDiagonal, -kDiagonal},
                                         {-kDiagonal, kDiagonal},
                                         {-kDiagonal, -kDiagonal}}};
  for (const cv::Point& p : around) {
    if (least.empty()) {
      least = high(middle + p).clone(), most = low(middle + p).clone();
      continue;
    }
    cv::min(least, high(middle + p), least);
    cv::max(most, low(middle + p), most);
  }
  cv::subtract(least, smooth, dark);
  cv::subtract(smooth, most, light);
  cv::max(dark, light, dark);
  dark.setTo(0, ground);
  return dark;
}

}  // namespace

const char* NameOf(SkySearchState state) {
  switch (state) {
    case SkySearchState::kSearched:
      return "searched";
    case SkySearchState::kNoSky:
      return "no sky";
    case SkySearchState::kTooDark:
      return "too dark";
    case SkySearchState::kWhiteOut:
      return "white out";
    case SkySearchState::kBadImage:
      return "bad image";
  }
  return "";
}

ContrastDetector::ContrastDetector(const CameraModel& camera, const cv::Mat& forbidden,
                                   const ContrastDetectorOptions& options)
    : camera_(camera), options_(options), mask_(camera, forbidden) {}

std::optional<ContrastDetection> ContrastDetector::Measured(const Blob& blob, int level,
                                                            double deviation_px) const {
  const double scale = 1 << level, shift = (scale - 1) / 2;
  ContrastDetection d;
  d.centre_px = scale * blob.centre + Eigen::Vector2d::Constant(shift);
  d.diameter_px = 2 * scale * std::sqrt(blob.area / M_PI);
  if (d.diameter_px < options_.least_diameter_px || d.diameter_px > options_.most_diameter_px)
    return std::nullopt;
  // The mean of its rays, each weighted by its solid angle, is the axis of a round cone exactly.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double solid_angle = 0;
  for (const BlobPixel& p : blob.pixels) {
    Eigen::Matrix<double, 3, 2> d_pixel;
    const auto ray = Ray(camera_, scale * p.px + Eigen::Vector2d::Constant(shift), &d_pixel);
    if (!ray) return std::nullopt;
    const double angle = p.share * scale * scale * d_pixel.col(0).cross(d_pixel.col(1)).norm();
    solid_angle += angle;
    sum += angle * *ray;
  }
  if (!(solid_angle > 0) || !(sum.norm() > 0)) return std::nullopt;
  d.cone.axis = sum.normalized();
  d.cone.half_angle = std::acos(std::clamp(1 - solid_angle / (2 * M_PI), -1.0, 1.0));
  const double rad_per_px = 2 * d.cone.half_angle / d.diameter_px;
  d.axis_sigma = deviation_px * scale * rad_per_px;
  d.half_angle_sigma = 0.7 * d.axis_sigma;
  d.contrast = blob.contrast;
  d.score = blob.score;
  return d;
}

SkySearch ContrastDetector::Search(const cv::Mat& image, const Eigen::Vector3d& down_C,
                                   double down_sigma) const {
  SkySearch search;
  if (image.empty() || (image.type() != CV_8UC3 && image.type() != CV_8UC1) ||
      image.cols != WidthPx(camera_) || image.rows != HeightPx(camera_) ||
      !(std::abs(down_C.norm() - 1) < 1e-3) || !(down_sigma >= 0))
    return search;
  std::array<Level, kLevels> levels;
  levels[0].image = image;
  for (std::size_t l = 1; l < kLevels; ++l)
    cv::resize(levels[l - 1].image, levels[l].image, levels[l - 1].image.size() / 2, 0, 0, cv::INTER_AREA);
  cv::Mat quarter = levels[2].image;
  if (quarter.channels() == 1) cv::cvtColor(quarter, quarter, cv::COLOR_GRAY2BGR);
  levels[1].sky = mask_.Find(quarter, down_C, down_sigma, Radians(options_.margin_deg));
  search.state = SkySearchState::kNoSky;
  if (cv::countNonZero(levels[1].sky) < kLeastSky * static_cast<double>(levels[1].sky.total())) return search;
  {
    cv::Mat coarse;
    cv::resize(levels[1].sky, coarse, levels[2].image.size(), 0, 0, cv::INTER_NEAREST);
    const cv::Scalar mean = cv::mean(quarter, coarse);
    search.state = SkySearchState::kTooDark;
    if (std::max({mean[0], mean[1], mean[2]}) < kDark) return search;
    search.state = SkySearchState::kWhiteOut;
    if (std::min({mean[0], mean[1], mean[2]}) > kWhite) return search;
  }
  search.state = SkySearchState::kSearched;

  cv::resize(levels[1].sky, levels[0].sky, image.size(), 0, 0, cv::INTER_NEAREST);
  for (std::size_t l = 2; l < kLevels; ++l) {
    cv::resize(levels[l - 1].sky, levels[l].sky, levels[l].image.size(), 0, 0, cv::INTER_AREA);
    cv::threshold(levels[l].sky, levels[l].sky, 254, 255, cv::THRESH_BINARY);
  }
  std::vector<Candidate> candidates;
  for (int l = 0; l < kLevels; ++l) {
    Level& level = levels[static_cast<std::size_t>(l)];
    const cv::Rect part = cv::boundingRect(level.sky);
    if (part.width < 2 * kAround || part.height < 2 * kAround) continue;
    cv::Mat ground;
    cv::bitwise_not(level.sky(part), ground);
    for (int c = 0; c < image.channels(); c += 2) {
      cv::Mat channel, smooth;
      if (image.channels() == 1)
        channel = level.image(part);
      else
        cv::extractChannel(level.image(part), channel, c);
      cv::blur(channel, smooth, {3, 3});
      const cv::Mat response = ResponseOf(smooth, ground);
      if (c == 0)
        level.response = response;
      else
        cv::max(level.response, response, level.response);
    }
    // A thing of less than 3 px fills but part of the mean.
    const int threshold = std::max(kLeastResponse, static_cast<int>(options_.least_contrast * 0.5));
    std::vector<Candidate> here;
    for (int y = 0; y < part.height; ++y) {
      const auto* row = level.response.ptr<uchar>(y);
      for (int x = 0; x < part.width; ++x)
        if (row[x] >= threshold) here.push_back({{x, y}, l, row[x], 0});
    }
    std::stable_sort(here.begin(), here.end(),
                     [](const Candidate& a, const Candidate& b) { return a.response > b.response; });
    std::vector<Candidate> kept;
    for (const Candidate& c : here) {
      if (static_cast<int>(kept.size()) >= options_.most_candidates) break;
      const bool beside = std::any_of(kept.begin(), kept.end(), [&](const Candidate& k) {
        return std::abs(k.place.x - c.place.x) <= kAround && std::abs(k.place.y - c.place.y) <= kAround;
      });
      if (beside) continue;
      kept.push_back(c);
    }
    for (Candidate& c : kept) {
      // The strongest response nearby, itself and what it smears left out.
      int rival = 1;
      for (int y = std::max(0, c.place.y - kNeighbourhood);
           y <= std::min(part.height - 1, c.place.y + kNeighbourhood); ++y)
        for (int x = std::max(0, c.place.x - kNeighbourhood);
             x <= std::min(part.width - 1, c.place.x + kNeighbourhood); ++x)
          if (std::abs(x - c.place.x) > kOuter || std::abs(y - c.place.y) > kOuter)
            rival = std::max(rival, static_cast<int>(level.response.at<uchar>(y, x)));
      c.outstanding = static_cast<double>(c.response) / rival;
      c.place += part.tl();
      candidates.push_back(c);
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.response > b.response; });
  if (static_cast<int>(candidates.size()) > options_.most_candidates)
    candidates.resize(static_cast<std::size_t>(options_.most_candidates));

  const BlobOptions blob_options{options_.least_score, options_.most_aspect, options_.least_fill,
                                 options_.most_halo, 0.5};
  for (const Candidate& c : candidates) {
    const int at = std::max(0, c.level - kFine), factor = 1 << (c.level - at);
    const Level& level = levels[static_cast<std::size_t>(at)];
    const cv::Point place(c.place.x * factor + factor / 2, c.place.y * factor + factor / 2);
    const Blob blob =
        MeasureBlob(level.image, level.sky, place, kInner * factor, kOuter * factor, blob_options);
    if (blob.state != BlobState::kMeasured || c.outstanding < options_.least_outstanding) continue;
    if (blob.strongest < options_.least_contrast) continue;
    // Of the centre: noise in the pixels of the edge, and what a grid of pixels adds.
    const double deviation_px = 0.05 + std::sqrt(M_PI * blob.area) / (2 * blob.score * std::sqrt(blob.area));
    auto detection = Measured(blob, at, deviation_px);
    if (!detection) continue;
    detection->outstanding = c.outstanding;
    const auto twin =
        std::find_if(search.detections.begin(), search.detections.end(), [&](const ContrastDetection& d) {
          return (d.centre_px - detection->centre_px).norm() < (d.diameter_px + detection->diameter_px) / 2;
        });
    if (twin == search.detections.end())
      search.detections.push_back(*detection);
    else if (detection->score > twin->score)
      *twin = *detection;
  }
  std::stable_sort(search.detections.begin(), search.detections.end(),
                   [](const ContrastDetection& a, const ContrastDetection& b) { return a.score > b.score; });
  return search;
}

}  // namespace kestrel
