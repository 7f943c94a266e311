// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/skyline.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "geometry/tait_bryan.h"
#include "vision/horizon/skyline_profile.h"

namespace kestrel::vision {

namespace {

// Coarse: about a candidate that is off by several degrees. Fine: about the coarse answer, by the resolution
// of the lens.
const BandGrid kWide{72, 39, Radians(-16), Radians(1)};
constexpr int kHorizonRow = 16;  // of kWide, at elevation 0
constexpr int kFineAzimuths = 240;
// Grey levels of all channels, at noise of some 2: under the first there is no horizon to be seen. Up to the
// second the contour may be the edge of a cloud or of haze, and must be the better a circle for it.
constexpr double kMinContrast = 12, kPlainContrast = 40;
constexpr double kHazyAgreement = 0.4;
constexpr double kRival = 0.65, kFullRival = 0.9, kRivalAgreement = 0.3;
constexpr double kChooses = Radians(1);  // rad: what is expected as well as this chooses between rivals
constexpr double kMinFound = 0.45;       // of the meridians in view
constexpr double kMaxBelow = 0.25;       // of the contour's points under the circle
constexpr double kNarrow = 0.35;         // of the azimuths: a lens that sees no more of the horizon
constexpr double kAllRound = 0.6;   // of the azimuths: a lens that sees less of a level horizon looks one way
constexpr double kOneSided = 0.02;  // of the view, on the other side of the expected horizon
constexpr double kSure = Radians(4);  // rad: what is expected as well as this needs no search
constexpr double kDeep = Radians(1);  // rad
constexpr double kAlike = Radians(1.5);
constexpr double kArcRelief = Radians(0.6);
constexpr double kArcGate = 2.7;       // deviations, by direction
constexpr double kArcMostSigma = 1.1;  // of an answer, in those of what was expected
constexpr double kArcLeastExpected = Radians(1.0);
// Of SkylineSearch::Sides: likeness to sky, over 0, or to ground; nats per cell.
constexpr double kTurned = 1, kDoubtful = 0.3, kFarLeast = -0.3, kMaxSkyBelow = 3.5;
constexpr double kGroundAbove = -0.5, kPlainGroundAbove = -1, kRise = 1.5, kPlainRise = 2, kFall = 1;
constexpr double kStripApart = 0.5;
constexpr double kTie = 0.15;  // of the quality of two answers
constexpr double kKnownDipSigma = Radians(0.2);
constexpr double kEarth_m = 6371e3;
constexpr double kFineLowest_deg = -3.5, kFineHighest_deg = 13;

struct Contour {
  std::vector<ContourPoint> points;
  std::vector<double> gains;
  double blur = 0;      // median, rad
  double contrast = 0;  // median, grey levels
  int shown = 0;
};

double Median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Contour Gathered(const std::vector<ProfilePoint>& profile, const BandGrid& grid) {
  Contour contour;
  std::vector<double> blurs, contrasts;
  for (int i = 0; i < grid.azimuths; ++i) {
    const ProfilePoint& p = profile[static_cast<std::size_t>(i)];
    contour.shown += p.shown;
    if (!p.found) continue;
    contour.points.push_back({grid.Azimuth(i), p.elevation, std::min(1.0, p.gain / 12)});
    contour.gains.push_back(p.gain);
    blurs.push_back(p.blur);
    contrasts.push_back(p.contrast);
  }
  contour.blur = Median(blurs);
  contour.contrast = Median(contrasts);
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

// An arc is matched by the edge of a field, of a lake or of a cloud, or by a skyline upside down; what lies
// on its two sides tells. Snow under a grey sky and dusk may look the wrong way by a little.
std::optional<NoSkyline> Doubt(const SkylineSearch::Sides& sides) {
  if (sides.below > sides.above + kTurned) return NoSkyline::kUpsideDown;
  if (sides.above < 0 || sides.far < kFarLeast) return NoSkyline::kNoSky;
  if (sides.below > kMaxSkyBelow) return NoSkyline::kNoGround;
  if (sides.below > sides.above + kDoubtful) return NoSkyline::kAmbiguous;
  // The skyline is the topmost edge: right above it there is no ground under more sky, nor a lake under
  // trees.
  const double rise = sides.far - sides.near;
  const bool ground_above = (sides.near < kGroundAbove && rise > kRise && sides.strip_apart > kStripApart) ||
                            (sides.near < kPlainGroundAbove && rise > kPlainRise);
  const bool lake_below = sides.far < 0 && rise < -kFall;
  if (ground_above || lake_below) return NoSkyline::kAmbiguous;
  return std::nullopt;
}

// Of an answer from what was expected, by its directions.
double MahalanobisDistance(const SkylineFix& fix, const Eigen::Vector3d& down_C, double side_sigma) {
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = fix.down_C.unitOrthogonal();
  across.col(1) = fix.down_C.cross(across.col(0));
  const Eigen::Vector2d off = across.transpose() * down_C.normalized();
  const Eigen::Matrix2d S =
      across.transpose() * fix.covariance * across + side_sigma * side_sigma * Eigen::Matrix2d::Identity();
  return std::sqrt(off.dot(S.inverse() * off));
}
double LargestSigma(const Eigen::Matrix3d& covariance) {
  return std::sqrt(covariance.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff());
}

double DipAt(double height_m) { return std::sqrt(2 * std::max(0.0, height_m) / kEarth_m); }
double Reach(const SkylineExpected& e) { return std::min(0.5, 3 * e.down_sigma + 0.02); }

}  // namespace

Skyline::Skyline(const CameraModel& camera, const Eigen::Matrix3d& R_BC, const cv::Mat& forbidden,
                 const SkylineOptions& options)
    : camera_(camera),
      R_BC_(R_BC),
      options_(options),
      sampler_(camera, forbidden),
      search_(camera, forbidden, R_BC.transpose() * Eigen::Vector3d::UnitZ(), Radians(options.max_tilt_deg)) {
  const Eigen::Matrix3d R_CB = R_BC.transpose();
  const cv::Mat nothing = cv::Mat::zeros(HeightPx(camera), WidthPx(camera), CV_8UC3);
  const BandSamples band = sampler_.Read(nothing, 1, HorizontalAbout(R_CB.col(2), R_CB.col(0)), kWide);
  int shown = 0;
  for (int i = 0; i < kWide.azimuths; ++i) shown += band.shown.at<uchar>(i, kHorizonRow) != 0;
  one_sided_ = shown < kAllRound * kWide.azimuths;
  if (StraightSkyline::Suits(camera))
    straight_.emplace(camera, forbidden, R_CB.col(2), Radians(options.max_tilt_deg));
}

std::optional<Skyline::Close> Skyline::LookClosely(const cv::Mat& half, const Eigen::Vector3d& down_C) const {
  Close close;
  close.horizontal = HorizontalAbout(down_C, R_BC_.transpose() * Eigen::Vector3d::UnitX());
  const auto n = static_cast<double>(kWide.azimuths);
  CircleFitOptions fit_options;
  fit_options.min_scatter = 0.003;
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
    double support = 0;
    for (std::size_t i = 0; i < contour.points.size(); ++i)
      support += (0.35 + 0.65 * fit->belongs[i]) * std::min(1.0, contour.gains[i] / 20);
    close.support = support / std::max<double>(contour.shown, n / 6) +
                    0.3 * ContourSeparation(band, kWide, profile) -
                    0.1 * std::max(0.0, Degrees(std::abs(close.dip)) - 2);
  }
  return close;
}

Skyline::Refined Skyline::Refine(const cv::Mat& image, const Close& close,
                                 const SkylineExpected& expected) const {
  const double step_deg = 0.3;
  const BandGrid grid{kFineAzimuths, static_cast<int>((kFineHighest_deg - kFineLowest_deg) / step_deg) + 1,
                      Radians(kFineLowest_deg) - std::clamp(close.dip, 0.0, 0.15), Radians(step_deg)};
  const Eigen::Vector3d nose = R_BC_.transpose() * Eigen::Vector3d::UnitX();
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
    if (expected.height_m) {
      fit_options.dip = DipAt(*expected.height_m);
      fit_options.dip_over_sigma = kKnownDipSigma + 0.3 * fit_options.dip;
    }
    fit_options.dip_over_sigma += 2 * std::max(0.0, contour.blur - 3 * grid.step);
    if (expected.down_C) {
      fit_options.near = {expected.down_C->dot(h.forward), expected.down_C->dot(h.right)};
      fit_options.reach = Reach(expected);
      fit_options.near_weight = 0.1;
    }
    if (one_sided_) fit_options.arc_relief = kArcRelief;
    fit = FitCircle(contour.points, fit_options);
    if (!fit) return {NoSkyline::kTooLittle, 0, static_cast<double>(contour.shown) / grid.azimuths};
    if (round == 0 && fit->state.head<2>().norm() < Radians(0.3)) break;
    if (round == 0) {
      h = HorizontalAbout(Tilted(h, fit->state), nose);
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
  fix.contrast = contour.contrast;
  fix.rival = fit->rival;
  for (std::size_t i = 0; i < contour.points.size(); ++i)
    fix.points.push_back({h.Direction(contour.points[i].azimuth, contour.points[i].elevation),
                          fit->belongs[i] * contour.points[i].weight});
  const double quality = fit->explained / std::max<double>(contour.shown, grid.azimuths / 6.0) -
                         0.03 * std::min(9.0, fit->strain * fit->strain);
  const double in_view = static_cast<double>(contour.shown) / grid.azimuths;
  const auto no = [&](NoSkyline reason) { return Refined{reason, quality, in_view}; };
  if (fix.circle_seen < options_.min_circle) return no(NoSkyline::kTooLittle);
  if (fix.contrast < kMinContrast) return no(NoSkyline::kHazy);
  // A short arc is matched by more circles.
  const double agreement = expected.down_C ? options_.min_agreement_expected : options_.min_agreement;
  const double arc = expected.down_C ? 0.25 : 0.8;
  const double least = agreement + std::clamp(arc * 2 * (0.55 - fix.circle_seen), 0.0, 0.3);
  const double haze = std::clamp((kPlainContrast - fix.contrast) / (kPlainContrast - kMinContrast), 0.0, 1.0);
  if (fix.agreement < agreement + kHazyAgreement * haze && fix.agreement >= least)
    return no(NoSkyline::kHazy);
  // A horizon leaves its step on most of the meridians that are in view.
  const bool sparse = static_cast<double>(contour.points.size()) < kMinFound * contour.shown;
  if (fix.agreement < least || fit->below > kMaxBelow || sparse) return no(NoSkyline::kUneven);
  // What is expected chooses between rivals, the surer the better it is known.
  const double unsure = std::clamp((expected.down_sigma - kChooses) / kChooses, 0.0, 1.0);
  const double rivalry = unsure * std::clamp((fix.rival - kRival) / (kFullRival - kRival), 0.0, 1.0);
  if (expected.down_C ? fix.agreement < agreement + kRivalAgreement * rivalry
                      : fix.rival > options_.max_rival)
    return no(NoSkyline::kAmbiguous);
  if (fix.down_C.dot(R_BC_.transpose() * Eigen::Vector3d::UnitZ()) < std::cos(Radians(options_.max_tilt_deg)))
    return no(NoSkyline::kTooLittle);
  const double sigma = std::sqrt(fix.covariance.trace());
  if (!(sigma < Radians(options_.max_sigma_deg))) return no(NoSkyline::kTooLittle);
  if (expected.down_C) {
    const double off = std::acos(std::clamp(fix.down_C.dot(expected.down_C->normalized()), -1.0, 1.0));
    if (off > options_.gate * std::hypot(expected.down_sigma, sigma)) return no(NoSkyline::kImplausible);
    if (one_sided_) {
      // An arc seldom contradicts a wrong answer, so that what was expected must; and a deviation like that
      // of what was expected adds little to it.
      const double side_sigma = expected.down_sigma / std::sqrt(2);
      if (MahalanobisDistance(fix, *expected.down_C, side_sigma) > kArcGate)
        return no(NoSkyline::kImplausible);
      if (LargestSigma(fix.covariance) > kArcMostSigma * std::max(side_sigma, kArcLeastExpected))
        return no(NoSkyline::kTooLittle);
    }
  }
  return {std::move(fix), quality, in_view};
}

SkylineResult Skyline::Measure(const cv::Mat& image, const SkylineExpected& expected) const {
  if (image.cols != WidthPx(camera_) || image.rows != HeightPx(camera_)) return NoSkyline::kWrongSize;
  cv::Mat colour = image;
  if (image.channels() == 1) cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
  const Eigen::Vector3d nose = R_BC_.transpose() * Eigen::Vector3d::UnitX();
  Refined best{NoSkyline::kNoSky, -1, 0};
  if (expected.down_C && expected.down_sigma < kSure) {
    const double dip = expected.height_m ? DipAt(*expected.height_m) : 0.003;
    best = Refine(colour, {HorizontalAbout(*expected.down_C, nose), 1, dip}, expected);
    if (std::holds_alternative<SkylineFix>(best.result)) return best.result;
  }
  cv::Mat half;
  cv::resize(colour, half, {image.cols / 2, image.rows / 2}, 0, 0, cv::INTER_AREA);
  auto overview = search_.Look(half, static_cast<std::size_t>(options_.candidates));
  if (overview.dark > 0.97) return NoSkyline::kTooDark;
  if (overview.white > 0.9) return NoSkyline::kWhiteOut;
  if (overview.spread < 3 && overview.rough < 3) return NoSkyline::kNoContrast;
  if (straight_ && !expected.down_C) {
    SkylineResult result = straight_->Measure(colour);
    const auto* why = std::get_if<NoSkyline>(&result);
    if (why && *why == NoSkyline::kNoLine && !overview.candidates.empty()) {
      const SkylineSearch::Candidate& first = overview.candidates.front();
      if (first.sky_above > 0 && first.sky_below > 0) return NoSkyline::kNoGround;
      if (first.sky_above < 0 && first.sky_below < 0) return NoSkyline::kNoSky;
    }
    return result;
  }
  if (expected.down_C) {
    if (expected.down_sigma < kSure) {
      if (std::get<NoSkyline>(best.result) != NoSkyline::kTooLittle) return best.result;
      const double above = search_.ShareAbove(expected.down_C->normalized());
      if (above < kOneSided) return NoSkyline::kNoSky;
      if (above > 1 - kOneSided) return NoSkyline::kNoGround;
      return best.result;
    }
    overview.candidates.push_back({expected.down_C->normalized(), 0});
  }
  std::vector<Close> closes;
  for (const auto& candidate : overview.candidates)
    if (auto close = LookClosely(half, candidate.down_C)) {
      close->support += 0.25 * candidate.score;
      closes.push_back(*close);
    }
  std::sort(closes.begin(), closes.end(),
            [](const Close& a, const Close& b) { return a.support > b.support; });
  if (closes.empty() || closes[0].support < 0.35)
    return overview.sky > 0 ? NoSkyline::kNoGround : NoSkyline::kNoSky;
  // What the coarse look cannot tell apart, the fine one can. A dip that no height explains may be a shore
  // or the edge of a field: what does the horizon look like from there?
  std::vector<Close> starts{closes[0]};
  if (closes[0].dip > kDeep) starts.push_back({closes[0].horizontal, closes[0].support, 0.003});
  for (std::size_t k = 1; k < closes.size() && starts.size() < 3; ++k)
    if (closes[k].support > 0.75 * closes[0].support &&
        closes[k].horizontal.down.dot(closes[0].horizontal.down) < std::cos(kAlike)) {
      starts.push_back(closes[k]);
      break;
    }
  std::vector<Refined> answers;
  for (const Close& start : starts) {
    answers.push_back(Refine(colour, start, expected));
    answers.back().quality += start.support / 2;
  }
  const auto top = std::max_element(answers.begin(), answers.end(),
                                    [](const Refined& a, const Refined& b) { return a.quality < b.quality; });
  const auto* fix = std::get_if<SkylineFix>(&top->result);
  for (const Refined& answer : answers) {
    const auto* other = std::get_if<SkylineFix>(&answer.result);
    if (fix && other && answer.quality > top->quality - kTie &&
        fix->down_C.dot(other->down_C) < std::cos(2 * kAlike))
      return NoSkyline::kAmbiguous;
  }
  // Through a narrow lens clouds or fields alone may look like a horizon, but not like sky over ground.
  const auto* reason = std::get_if<NoSkyline>(&top->result);
  if (reason && *reason != NoSkyline::kAmbiguous && top->in_view < kNarrow) {
    const SkylineSearch::Candidate& first = overview.candidates.front();
    if (first.sky_above > 0 && first.sky_below > 0) return NoSkyline::kNoGround;
    if (first.sky_above < 0 && first.sky_below < 0) return NoSkyline::kNoSky;
  }
  if (fix && one_sided_)
    if (const auto doubt = Doubt(search_.SidesOf(overview, fix->down_C, fix->dip))) return *doubt;
  return top->result;
}

}  // namespace kestrel::vision
