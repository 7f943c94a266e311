// SPDX-License-Identifier: Apache-2.0
#include "vision/skyline.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "geometry/tait_bryan.h"
#include "vision/skyline_profile.h"

namespace kestrel {

namespace {

// Coarse: about a candidate that is off by several degrees. Fine: about the coarse answer, by the resolution
// of the lens.
const BandGrid kWide{72, 39, Radians(-16), Radians(1)};
constexpr int kFineAzimuths = 240;
constexpr double kLeastFound = 0.45;  // of the meridians in view
constexpr double kFineLowest_deg = -3.5, kFineHighest_deg = 13;

struct Contour {
  std::vector<ContourPoint> points;
  std::vector<double> gains;
  double blur = 0;  // median, rad
  int shown = 0;
};

Contour Gathered(const std::vector<ProfilePoint>& profile, const BandGrid& grid) {
  Contour contour;
  std::vector<double> blurs;
  for (int i = 0; i < grid.azimuths; ++i) {
    const ProfilePoint& p = profile[static_cast<std::size_t>(i)];
    contour.shown += p.shown;
    if (!p.found) continue;
    contour.points.push_back({grid.Azimuth(i), p.elevation, std::min(1.0, p.gain / 12)});
    contour.gains.push_back(p.gain);
    blurs.push_back(p.blur);
  }
  if (!blurs.empty()) {
    const auto middle = blurs.begin() + static_cast<std::ptrdiff_t>(blurs.size() / 2);
    std::nth_element(blurs.begin(), middle, blurs.end());
    contour.blur = *middle;
  }
  return contour;
}

// The vertical after the fitted tilt: its horizon stands at a cos(azimuth) + b sin(azimuth) over the old one.
Eigen::Vector3d Tilted(const Horizontal& h, const Eigen::Vector3d& state) {
  return (h.down + std::tan(state[0]) * h.forward + std::tan(state[1]) * h.right).normalized();
}

std::vector<double> CircleOf(const Eigen::Vector3d& state, const BandGrid& grid) {
  std::vector<double> out;
  for (int i = 0; i < grid.azimuths; ++i) {
    const double a = grid.Azimuth(i);
    out.push_back(state[0] * std::cos(a) + state[1] * std::sin(a) + state[2]);
  }
  return out;
}

}  // namespace

Skyline::Skyline(const CameraModel& camera, const Eigen::Matrix3d& R_BC, const cv::Mat& forbidden,
                 const SkylineOptions& options)
    : camera_(camera),
      R_BC_(R_BC),
      options_(options),
      sampler_(camera, forbidden),
      search_(camera, forbidden, R_BC.transpose() * Eigen::Vector3d::UnitZ(), Radians(options.max_tilt_deg)) {
}

std::optional<Skyline::Close> Skyline::LookClosely(const cv::Mat& half, const Eigen::Vector3d& down_C) const {
  Close close;
  close.horizontal = HorizontalAbout(down_C, R_BC_.transpose() * Eigen::Vector3d::UnitX());
  const auto n = static_cast<double>(kWide.azimuths);
  CircleFitOptions fit_options;
  fit_options.least_scatter = 0.003;
  for (int round = 0; round < 2; ++round) {
    const BandSamples band = sampler_.Read(half, 2, close.horizontal, kWide);
    const std::vector<double> start(static_cast<std::size_t>(kWide.azimuths), round ? -close.dip : 0.0);
    const auto profile = FindContour(
        band, kWide, start, {Radians(round ? 1.0 : 4.0), Radians(round ? 8.0 : 14.0), Radians(22.0), 3});
    const Contour contour = Gathered(profile, kWide);
    // Haze hides the ground next to the horizon: what is seen ends lower, and not sharply.
    fit_options.dip_over_sigma = 0.01 + std::max(0.0, contour.blur - 2 * kWide.step);
    const auto fit = FitCircle(contour.points, fit_options);
    if (!fit) return std::nullopt;
    close.horizontal =
        HorizontalAbout(Tilted(close.horizontal, fit->state), R_BC_.transpose() * Eigen::Vector3d::UnitX());
    close.dip = -fit->state[2];
    close.shown = contour.shown / n;
    close.found = static_cast<double>(contour.points.size()) / n;
    double support = 0;
    for (std::size_t i = 0; i < contour.points.size(); ++i)
      support += (0.35 + 0.65 * fit->belongs[i]) * std::min(1.0, contour.gains[i] / 20);
    close.support = support / std::max<double>(contour.shown, n / 6) +
                    0.3 * ContourSeparation(band, kWide, profile) -
                    0.1 * std::max(0.0, Degrees(std::abs(close.dip)) - 2);
  }
  return close;
}

SkylineResult Skyline::Refine(const cv::Mat& image, const Close& close) const {
  const double step_deg = 0.3;
  const BandGrid grid{kFineAzimuths, static_cast<int>((kFineHighest_deg - kFineLowest_deg) / step_deg) + 1,
                      Radians(kFineLowest_deg) - std::clamp(close.dip, 0.0, 0.15), Radians(step_deg)};
  Horizontal h = close.horizontal;
  Eigen::Vector3d state(0, 0, -close.dip);
  std::optional<CircleFit> fit;
  Contour contour;
  for (int round = 0; round < 2; ++round) {
    const BandSamples band = sampler_.Read(image, 1, h, grid);
    const auto profile =
        FindContour(band, grid, CircleOf(state, grid), {Radians(0.6), Radians(3.0), Radians(9.0), 2});
    contour = Gathered(profile, grid);
    CircleFitOptions fit_options;
    fit_options.dip_over_sigma += 2 * std::max(0.0, contour.blur - 3 * grid.step);
    fit = FitCircle(contour.points, fit_options);
    if (!fit) return NoSkyline::kTooLittle;
    if (round == 0 && fit->state.head<2>().norm() < Radians(0.3)) break;
    if (round == 0) {
      h = HorizontalAbout(Tilted(h, fit->state), R_BC_.transpose() * Eigen::Vector3d::UnitX());
      state = Eigen::Vector3d(0, 0, fit->state[2]);
    }
  }
  SkylineFix fix;
  fix.down_C = Tilted(h, fit->state);
  Eigen::Matrix<double, 3, 2> J;  // of down_C by (a, b)
  J << h.forward, h.right;
  J -= fix.down_C * (fix.down_C.transpose() * J);
  fix.covariance = J * fit->covariance.topLeftCorner<2, 2>() * J.transpose();
  fix.dip = -fit->state[2];
  fix.circle_seen = static_cast<double>(contour.points.size()) / grid.azimuths;
  fix.agreement = fit->on_circle;
  fix.rival = fit->rival;
  for (std::size_t i = 0; i < contour.points.size(); ++i)
    fix.points.push_back({h.Direction(contour.points[i].azimuth, contour.points[i].elevation),
                          fit->belongs[i] * contour.points[i].weight});
  if (fix.circle_seen < options_.least_circle) return NoSkyline::kTooLittle;
  // A short arc is matched by more circles.
  const double least = options_.least_agreement + 0.25 * std::clamp(2 * (0.55 - fix.circle_seen), 0.0, 1.0);
  // A horizon leaves its step on most of the meridians that are in view.
  const bool sparse = static_cast<double>(contour.points.size()) < kLeastFound * contour.shown;
  if (fix.agreement < least || sparse) return NoSkyline::kUneven;
  if (fix.rival > options_.most_rival) return NoSkyline::kAmbiguous;
  if (fix.down_C.dot(R_BC_.transpose() * Eigen::Vector3d::UnitZ()) < std::cos(Radians(options_.max_tilt_deg)))
    return NoSkyline::kTooLittle;
  const double worst = std::sqrt(fix.covariance.trace());
  if (!(worst < Radians(options_.most_sigma_deg))) return NoSkyline::kTooLittle;
  return fix;
}

SkylineResult Skyline::Measure(const cv::Mat& image, const std::optional<Eigen::Vector3d>& expected) const {
  if (image.cols != WidthPx(camera_) || image.rows != HeightPx(camera_)) return NoSkyline::kWrongSize;
  cv::Mat colour = image;
  if (image.channels() == 1) cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
  cv::Mat half;
  cv::resize(colour, half, {image.cols / 2, image.rows / 2}, 0, 0, cv::INTER_AREA);
  auto overview = search_.Look(half, static_cast<std::size_t>(options_.candidates));
  if (overview.dark > 0.97) return NoSkyline::kTooDark;
  if (overview.white > 0.9) return NoSkyline::kWhiteOut;
  if (overview.spread < 3 && overview.rough < 3) return NoSkyline::kNoContrast;
  if (expected) overview.candidates.push_back({expected->normalized(), 0});
  std::vector<Close> closes;
  for (const auto& candidate : overview.candidates)
    if (auto close = LookClosely(half, candidate.down_C)) {
      close->support += 0.25 * candidate.score;
      closes.push_back(*close);
    }
  if (closes.empty()) return overview.rough < 2.5 ? NoSkyline::kNoGround : NoSkyline::kNoSky;
  std::sort(closes.begin(), closes.end(),
            [](const Close& a, const Close& b) { return a.support > b.support; });
  if (closes[0].support < 0.35) return overview.rough < 2.5 ? NoSkyline::kNoGround : NoSkyline::kNoSky;
  return Refine(colour, closes[0]);
}

}  // namespace kestrel
