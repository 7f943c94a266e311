// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/border/straight_skyline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "geometry/tait_bryan.h"
#include "vision/horizon/border/border_belief.h"
#include "vision/horizon/border/border_look.h"
#include "vision/horizon/border/border_search.h"

namespace kestrel::vision {

namespace {

constexpr std::size_t kCandidates = 8, kClimbed = 3, kPlain = 4;
constexpr double kClimbs_px[] = {16, 32, 50};  // over a line that may have a farther one above it
constexpr double kSameOffset_px = 3, kSameTurn = Radians(1.5);
constexpr double kNothing = -1;
constexpr double kRival = 0.5, kRivalApart = Radians(4);  // of the beliefs of two answers
constexpr double kLeastSide = 0.01;                       // of the view, on either side
constexpr double kWidestLens = Radians(62);
constexpr double kLeastNear = 0.6;
constexpr double kRelief = Radians(1.1);  // of the skyline, beforehand
constexpr double kDip = 0.002;            // of the horizon from 13 m up, rad
constexpr double kUnevenShare = 1.0, kRollShare = 0.9;

bool MoreBelieved(const LookedAtLine& a, const LookedAtLine& b) { return a.belief > b.belief; }

bool Same(const SkyBorder& a, const SkyBorder& b, const Eigen::Vector2d& middle) {
  return a.normal.dot(b.normal) > std::cos(kSameTurn) &&
         std::abs((a.offset - a.normal.dot(middle)) - (b.offset - b.normal.dot(middle))) < kSameOffset_px;
}

}  // namespace

StraightSkyline::StraightSkyline(const CameraModel& camera, const cv::Mat& forbidden,
                                 const Eigen::Vector3d& down_C, double max_tilt)
    : plane_(camera, forbidden), down_C_(down_C.normalized()), max_tilt_(max_tilt) {}

bool StraightSkyline::Suits(const CameraModel& camera) {
  const int width = WidthPx(camera), height = HeightPx(camera);
  int seen = 0, near = 0;
  for (int i = 0; i <= 16; ++i)
    for (int j = 0; j <= 16; ++j) {
      const auto ray = Ray(camera, {(width - 1) * i / 16.0, (height - 1) * j / 16.0});
      if (!ray) continue;
      ++seen, near += ray->z() > std::cos(kWidestLens);
    }
  return seen > 0 && near == seen;
}

std::vector<LookedAtLine> StraightSkyline::Lines(const cv::Mat& image) const {
  const cv::Mat view = plane_.Of(image);
  const Eigen::Vector2d middle(view.cols / 2.0, view.rows / 2.0);
  std::vector<SkyBorder> starts;
  for (const BorderCandidate& c : SearchBorders(view, plane_.shown(), {0, -1}, M_PI, kCandidates))
    starts.push_back(c.line);
  std::vector<LookedAtLine> all;
  std::array<std::vector<SkyBorder>, 2> tried;
  const auto look_at = [&](const SkyBorder& line, bool topmost) {
    auto& done = tried[topmost];
    if (std::any_of(done.begin(), done.end(), [&](const SkyBorder& t) { return Same(t, line, middle); }))
      return;
    done.push_back(line);
    const auto look = LookAtBorder(plane_, view, line, topmost);
    if (!look) return;
    const BorderSides sides = SidesOf(view, plane_.shown(), look->line);
    if (sides.share_above < kLeastSide || sides.share_below < kLeastSide) return;
    done.push_back(look->line);
    const double belief = BorderBelief(*look, sides);
    // What is hardly an edge is none, whatever lies on its sides.
    all.push_back({*look, sides, look->contrast < kLeastContrast ? std::min(belief, 0.0) : belief,
                   plane_.DownOf(look->line, kDip)});
  };
  for (std::size_t k = 0; k < starts.size(); ++k) {
    look_at(starts[k], true);
    if (k < kPlain) look_at(starts[k], false);
  }
  std::sort(all.begin(), all.end(), MoreBelieved);
  // Behind the likeliest there may be a farther one, above it.
  const std::vector<LookedAtLine> first(
      all.begin(), all.begin() + static_cast<std::ptrdiff_t>(std::min(all.size(), kClimbed)));
  for (const LookedAtLine& seen : first)
    for (const double climb : kClimbs_px) {
      SkyBorder higher = seen.look.line;
      higher.offset += climb;
      look_at(higher, true);
    }
  std::sort(all.begin(), all.end(), MoreBelieved);
  return all;
}

SkylineResult StraightSkyline::Measure(const cv::Mat& image) const {
  const std::vector<LookedAtLine> all = Lines(image);
  if (all.empty()) return NoSkyline::kNoContrast;
  const LookedAtLine& best = all.front();
  if (best.belief < kLeastBelief) {
    if (best.belief < kNothing) return NoSkyline::kNoLine;
    if (best.look.contrast < kLeastContrast) return NoSkyline::kHazy;
    if (best.look.near < kLeastNear) return NoSkyline::kUneven;
    return NoSkyline::kNoLine;
  }
  if (best.down_C.dot(down_C_) < std::cos(max_tilt_))
    return best.down_C.dot(down_C_) < 0 ? NoSkyline::kUpsideDown : NoSkyline::kTooLittle;
  for (const LookedAtLine& other : all)
    if (other.belief > std::max(kLeastBelief, best.belief - kRival) &&
        best.down_C.dot(other.down_C) < std::cos(kRivalApart))
      return NoSkyline::kAmbiguous;

  SkylineFix fix;
  fix.down_C = best.down_C;
  fix.dip = kDip;
  fix.agreement = best.look.straight;
  fix.contrast = best.look.contrast;
  fix.rival = all.size() > 1 ? 1 / (1 + std::exp(best.belief - all[1].belief)) : 0;
  // Across the line the skyline's relief is the error, along it the difference of the relief at its ends.
  double square = 0, n = 0;
  for (const BorderPoint& p : best.look.points) square += p.above * p.above, n += 1;
  const double uneven = std::min(std::sqrt(square / std::max(1.0, n)) / plane_.focal_px(), Radians(2));
  const double relief = std::hypot(kRelief, kUnevenShare * uneven);
  const Eigen::Vector3d ahead = (Eigen::Vector3d::UnitZ() - fix.down_C.z() * fix.down_C).normalized();
  const Eigen::Vector3d side = fix.down_C.cross(ahead);
  const double reach = std::clamp(best.look.shown / 2 / plane_.focal_px(), 0.1, 1.0);
  const double roll_sigma = kRollShare * relief / std::max(0.3, reach) * 0.5;
  fix.covariance =
      relief * relief * ahead * ahead.transpose() + roll_sigma * roll_sigma * side * side.transpose();
  double least = M_PI, most = -M_PI;
  const Eigen::Vector2d along(-best.look.line.normal.y(), best.look.line.normal.x());
  const cv::Size view = plane_.shown().size();
  const Eigen::Vector2d middle_px((view.width - 1) / 2.0, (view.height - 1) / 2.0);
  const Eigen::Vector2d foot =
      middle_px + (best.look.line.offset - best.look.line.normal.dot(middle_px)) * best.look.line.normal;
  for (const BorderPoint& p : best.look.points) {
    const Eigen::Vector3d ray = plane_.RayOf(foot + p.along * along + p.above * best.look.line.normal);
    fix.points.push_back({ray, p.weight});
    const double azimuth = std::atan2(side.dot(ray), ahead.dot(ray));
    least = std::min(least, azimuth), most = std::max(most, azimuth);
  }
  fix.circle_seen = std::max(0.0, most - least) / (2 * M_PI);
  return fix;
}

}  // namespace kestrel::vision
