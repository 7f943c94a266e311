// SPDX-License-Identifier: Apache-2.0
#include "vision/target/contrast_detector.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "geometry/tait_bryan.h"

namespace kestrel::vision {

namespace {

constexpr int kLevels = 5;             // of the pyramid: things of about 2 to 5 px in each
constexpr int kFine = 2;               // levels finer than the candidate's, in which it is measured
constexpr int kAround = 4;             // px to the places it is compared with
constexpr int kInner = 5, kOuter = 7;  // px of the candidate's level: the ring of the blob's background
constexpr double kMinForEdge_px = 6;
constexpr double kExpectedReach = 1.3, kExpected_px = 4;  // around an expected one, of its radius and besides
constexpr double kMinAround = 0.35;                       // of the ring around a blob that must be sky
constexpr double kMinSky = 0.005;                         // share of the image
constexpr double kGlow =
    205;  // grey levels of red: lighter things before such a sky are the sun's disc or clouds
constexpr double kDark = 8, kWhite = 250;  // grey levels
constexpr int kMinResponse = 4;            // grey levels of the mean of 3 x 3 px

struct Level {
  cv::Mat image, sky;  // sky: 255 or 0
};

// How much each place differs from all around it, whatever the sign; 0 where the sky is not free. What is no
// free sky around it is not asked. Larger values than there are in response replace those.
void Respond(const cv::Mat& smooth, const cv::Mat& free, cv::Mat& response) {
  const int rows = smooth.rows, columns = smooth.cols;
  cv::Mat high(rows + 2 * kAround, columns + 2 * kAround, CV_8UC1, cv::Scalar(255));
  cv::Mat low(high.size(), CV_8UC1, cv::Scalar(0));
  const cv::Rect middle(kAround, kAround, columns, rows);
  cv::Mat taken;
  cv::bitwise_not(free, taken);
  cv::bitwise_or(smooth, taken, high(middle));
  cv::bitwise_and(smooth, free, low(middle));
  constexpr int kDiagonal = 3;
  for (int y = 0; y < rows; ++y) {
    const auto row = [&](const cv::Mat& m, int dy) { return m.ptr<uchar>(y + kAround + dy) + kAround; };
    const uchar *h0 = row(high, 0), *hu = row(high, -kAround), *hd = row(high, kAround);
    const uchar *ha = row(high, -kDiagonal), *hb = row(high, kDiagonal);
    const uchar *l0 = row(low, 0), *lu = row(low, -kAround), *ld = row(low, kAround);
    const uchar *la = row(low, -kDiagonal), *lb = row(low, kDiagonal);
    const uchar *s = smooth.ptr<uchar>(y), *open = free.ptr<uchar>(y);
    uchar* r = response.ptr<uchar>(y);
    const auto least = [](uchar a, uchar b) { return a < b ? a : b; };
    const auto most = [](uchar a, uchar b) { return a > b ? a : b; };
#pragma GCC ivdep  // the rows of different images do not overlap: 16 pixels at a time
    for (int x = 0; x < columns; ++x) {
      const uchar around = least(
          least(least(h0[x - kAround], h0[x + kAround]), least(hu[x], hd[x])),
          least(least(ha[x - kDiagonal], ha[x + kDiagonal]), least(hb[x - kDiagonal], hb[x + kDiagonal])));
      const uchar below =
          most(most(most(l0[x - kAround], l0[x + kAround]), most(lu[x], ld[x])),
               most(most(la[x - kDiagonal], la[x + kDiagonal]), most(lb[x - kDiagonal], lb[x + kDiagonal])));
      const auto dark = static_cast<uchar>(most(around, s[x]) - s[x]);
      const auto light = static_cast<uchar>(s[x] - least(below, s[x]));
      r[x] = most(r[x], static_cast<uchar>(most(dark, light) & open[x]));
    }
  }
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
                                                            double sigma_px) const {
  const double scale = 1 << level, shift = (scale - 1) / 2;
  ContrastDetection d;
  d.centre_px = scale * blob.centre + Eigen::Vector2d::Constant(shift);
  d.diameter_px = 2 * scale * std::sqrt(blob.area / M_PI);
  if (d.diameter_px < options_.min_diameter_px || d.diameter_px > options_.max_diameter_px)
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
  d.axis_sigma = sigma_px * scale * rad_per_px;
  d.half_angle_sigma = 0.7 * d.axis_sigma;
  d.contrast = blob.contrast;
  d.score = blob.score;
  return d;
}

SkySearch ContrastDetector::Search(const cv::Mat& image, const Eigen::Vector3d& down_C, double down_sigma,
                                   const std::vector<OutlineCone>& expected) const {
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
  for (const OutlineCone& cone : expected) {
    Eigen::Matrix<double, 2, 3> d_point;
    const auto uv = Project(camera_, cone.axis, &d_point);
    if (!uv) continue;
    const double radius_px = cone.half_angle * d_point.norm() / std::sqrt(2) * kExpectedReach + kExpected_px;
    cv::circle(levels[1].sky,
               {static_cast<int>(std::lround(uv->x() / 2)), static_cast<int>(std::lround(uv->y() / 2))},
               static_cast<int>(std::ceil(radius_px / 2)), kFreeSky, cv::FILLED);
  }
  search.state = SkySearchState::kNoSky;
  if (cv::countNonZero(levels[1].sky) < kMinSky * static_cast<double>(levels[1].sky.total())) return search;
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
    // Of four pixels the worst.
    const cv::Mat& finer = levels[l - 1].sky;
    levels[l].sky.create(levels[l].image.size(), CV_8UC1);
    for (int y = 0; y < levels[l].sky.rows; ++y)
      for (int x = 0; x < levels[l].sky.cols; ++x)
        levels[l].sky.at<uchar>(y, x) =
            std::min({finer.at<uchar>(2 * y, 2 * x), finer.at<uchar>(2 * y, 2 * x + 1),
                      finer.at<uchar>(2 * y + 1, 2 * x), finer.at<uchar>(2 * y + 1, 2 * x + 1)});
  }
  std::vector<Candidate> candidates;
  for (int l = 0; l < kLevels; ++l) {
    Level& level = levels[static_cast<std::size_t>(l)];
    const cv::Rect part = cv::boundingRect(level.sky);
    if (part.width < 2 * kAround || part.height < 2 * kAround) continue;
    cv::Mat free, response(part.size(), CV_8UC1, cv::Scalar(0));
    cv::compare(level.sky(part), kFreeSky, free, cv::CMP_EQ);
    for (int c = 0; c < image.channels(); c += 2) {
      cv::Mat channel, smooth;
      if (image.channels() == 1)
        channel = level.image(part);
      else
        cv::extractChannel(level.image(part), channel, c);
      cv::blur(channel, smooth, {3, 3});
      Respond(smooth, free, response);
    }
    // A thing of less than 3 px fills but part of the mean.
    const int threshold = std::max(kMinResponse, static_cast<int>(options_.min_contrast * 0.5));
    std::vector<Candidate> here;
    for (int y = 0; y < part.height; ++y) {
      const auto* row = response.ptr<uchar>(y);
      for (int x = 0; x < part.width; ++x)
        if (row[x] >= threshold) here.push_back({{x, y}, l, row[x]});
    }
    std::stable_sort(here.begin(), here.end(),
                     [](const Candidate& a, const Candidate& b) { return a.response > b.response; });
    std::vector<Candidate> kept;
    for (const Candidate& c : here) {
      if (static_cast<int>(kept.size()) >=
          (l < kFine ? options_.max_candidates : (options_.max_candidates + 1) / 2))
        break;
      const bool beside = std::any_of(kept.begin(), kept.end(), [&](const Candidate& k) {
        return std::abs(k.place.x - c.place.x) <= kAround && std::abs(k.place.y - c.place.y) <= kAround;
      });
      if (beside) continue;
      kept.push_back(c);
    }
    for (Candidate& c : kept) {
      c.place += part.tl();
      candidates.push_back(c);
    }
  }
  const BlobOptions blob_options{options_.min_score, options_.max_aspect, options_.min_fill, 0.5};
  for (const Candidate& c : candidates) {
    const int at = std::max(0, c.level - kFine), factor = 1 << (c.level - at);
    const Level& level = levels[static_cast<std::size_t>(at)];
    const cv::Point place(c.place.x * factor + factor / 2, c.place.y * factor + factor / 2);
    const Blob blob =
        MeasureBlob(level.image, level.sky, place, kInner * factor, kOuter * factor, blob_options);
    if (blob.state != BlobState::kMeasured) continue;
    if (blob.strongest < options_.min_contrast * (blob.contrast > 0 ? options_.light_factor : 1)) continue;
    if (blob.contrast > 0 && blob.background[2] > kGlow) continue;
    // Of the centre: noise in the pixels of the edge, and what a grid of pixels adds.
    const double sigma_px = 0.05 + std::sqrt(M_PI * blob.area) / (2 * blob.score * std::sqrt(blob.area));
    auto detection = Measured(blob, at, sigma_px);
    if (!detection) continue;
    if (detection->diameter_px >= kMinForEdge_px &&
        SharpnessOf(image, detection->centre_px, detection->diameter_px / 2, blob.strongest, blob.sigma) <
            options_.min_sharpness)
      continue;
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

}  // namespace kestrel::vision
