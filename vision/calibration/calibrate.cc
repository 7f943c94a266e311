// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/calibrate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/tait_bryan.h"
#include "vision/calibration/agreeing_views.h"
#include "vision/calibration/calibration_checks.h"
#include "vision/calibration/calibration_start.h"
#include "vision/calibration/calibration_uncertainty.h"
#include "vision/calibration/distortion_terms.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMinTilts_deg = 6;  // between the two boards that differ most
constexpr double kMaxUncertainty_px = 5;
constexpr double kMaxSigmaXi = 0.1;
constexpr double kFirstCommon_px = 0.05;  // see PointsOf; until it is known

void AddNotes(Calibration& c) {
  const Eigen::VectorXd all = Parameters(c.camera);
  const auto at_limit = [&](int i, double limit) {
    if (std::abs(all[i] - limit) < 1e-9) {
      c.notes.push_back(
          fmt::format("{} is at its limit {:g}: the images do not ask for this model; compare with another",
                      ParameterNames(c.camera)[static_cast<std::size_t>(i)], limit));
    }
  };
  if (std::holds_alternative<Unified>(c.camera)) at_limit(4, 0), at_limit(4, 20);
  if (std::holds_alternative<DoubleSphere>(c.camera))
    at_limit(4, -0.99), at_limit(4, 1), at_limit(5, 0), at_limit(5, 1);
  if (std::holds_alternative<Unified>(c.camera) && c.sigma[4] > kMaxSigmaXi) {
    c.notes.push_back(
        fmt::format("xi, f and k1 can hardly be told apart in these images (xi +- {:.2g}): where rays go is "
                    "known all the same",
                    c.sigma[4]));
  }
  if (const std::string held = HeldDistortion(c.camera, c.free); !held.empty())
    c.notes.push_back("held at 0, because the images do not show that it is there: " + held);
  for (const CalibratedView& view : c.views) {
    if (!view.left_out.empty())
      c.notes.push_back(fmt::format("{} was left out: {}", view.name, view.left_out));
  }
  if (c.corners_not_used > 0) {
    c.notes.push_back(fmt::format("{} of {} corners were set aside: more than {:g} deviations off",
                                  c.corners_not_used, c.corners, kOutlier));
  }
}

// What the corners of the used views are beside the calibration.
void AddResiduals(std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                  const std::vector<std::vector<SeenPoint>>& points, const Agreeing& agreeing,
                  Calibration& c) {
  double square = 0;
  for (std::size_t i = 0; i < agreeing.numbers.size(); ++i) {
    const std::size_t number = agreeing.numbers[i];
    CalibratedView& view = c.views[usable[number]];
    const Pose& X_CT = agreeing.adjustment.views[i].X_CT;
    view.X_CT = X_CT;
    double view_square = 0;
    std::size_t next = 0;
    for (std::size_t j = 0; j < points[number].size(); ++j) {
      const SeenPoint& point = points[number][j];
      const auto error = PixelError(c.camera, X_CT, point);
      const bool used = next < agreeing.corners[i].size() && agreeing.corners[i][next] == j && error;
      next += used;
      view.corners.push_back({views[usable[number]].corners[j].index, point.pixel,
                              error.value_or(Vector2d::Constant(std::nan(""))), used});
      if (!used) continue;
      view_square += error->squaredNorm();
      c.max_angle_seen_rad =
          std::max(c.max_angle_seen_rad, AngleFromAxis(X_CT * Vector3d(point.p_T.x(), point.p_T.y(), 0)));
    }
    view.rms_px = std::sqrt(view_square / static_cast<double>(next));
    square += view_square;
    c.corners += static_cast<int>(points[number].size());
    c.corners_not_used += static_cast<int>(points[number].size() - next);
  }
  c.rms_px = std::sqrt(square / (c.corners - c.corners_not_used));
}

}  // namespace

Calibration Calibrate(const Board& board, std::span<const BoardView> views, const CameraModel& like,
                      std::optional<double> accepted_px) {
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].corners.size() >= kMinCorners) usable.push_back(i);
  }
  CheckViews(board, views, usable, like);

  std::vector<int> free = FreeParameters(like);
  std::vector<std::vector<SeenPoint>> points = PointsOf(board, views, usable, kFirstCommon_px);
  const auto start = StartCalibration(like, free, points);
  if (!start)
    throw InputError({},
                     fmt::format("no start of the {} model sees the board in these images", NameOf(like)));
  PlacedViews placed = AdjustRobustly(start->camera, free, points);
  Agreeing agreeing;
  std::vector<std::string> left_out(usable.size());
  for (int round = 0; round < 3; ++round) {
    agreeing = SelectAgreeing(placed, left_out);
    if (agreeing.numbers.size() < kMinViews) {
      throw InputError({}, fmt::format("only {} of {} views agree on a {} camera; a calibration needs {}",
                                       agreeing.numbers.size(), usable.size(), NameOf(like), kMinViews));
    }
    Adjust(agreeing.adjustment, {.free = free});
    if (round == 2) break;
    points = PointsOf(board, views, usable, CommonError(views, usable, agreeing, free.size()));
    placed = PlaceViews(agreeing.adjustment.camera, points);
  }
  CheckLeftOut(views, usable, left_out, like);
  DropDistortion(like, agreeing, free);

  Calibration c;
  c.camera = agreeing.adjustment.camera;
  c.free = free;
  for (const BoardView& view : views) {
    c.views.push_back({.name = view.name, .left_out = "", .X_CT = {}, .rms_px = 0, .corners = {}});
    if (view.corners.empty())
      c.views.back().left_out = "the board was not found";
    else if (view.corners.size() < kMinCorners)
      c.views.back().left_out = fmt::format("only {} corners were found", view.corners.size());
  }
  for (std::size_t i = 0; i < usable.size(); ++i) c.views[usable[i]].left_out = left_out[i];
  AddResiduals(views, usable, points, agreeing, c);
  CheckResidual(c, accepted_px.value_or(AcceptedResidual(views, like)));
  const double tilts = Degrees(SpreadOfTilts(agreeing.adjustment.views));
  if (tilts < kMinTilts_deg) {
    throw InputError(
        {},
        fmt::format("in all {} views the board stands parallel to itself, within {:.1f} deg: tilt it "
                    "by 20 to 50 deg this way and that, or focal length and distance cannot be told apart",
                    agreeing.numbers.size(), tilts));
  }
  const auto covariance = ParameterCovariance(agreeing.adjustment, free);
  const double freedom = FreedomOf(agreeing, free.size());
  if (!covariance || !(freedom > 0)) {
    throw InputError(
        {}, fmt::format("{} corners in {} views do not determine the {} parameters of the {} model; {}",
                        c.corners, agreeing.numbers.size(), free.size(), NameOf(like), RemedyFor(like)));
  }
  constexpr double kAll = std::numeric_limits<double>::infinity();
  c.covariance = *covariance * (CostOf(agreeing.adjustment, kAll) / freedom);
  const double alike = AllowForImages(agreeing.adjustment, free, c);
  c.sigma = c.covariance.diagonal().cwiseSqrt();
  c.worst_uncertainty_px = WorstUncertainty(c);
  if (!(c.worst_uncertainty_px < kMaxUncertainty_px)) {
    throw InputError(
        {}, fmt::format("the views leave the {} model uncertain by {:.1f} px, with boards tilted by up "
                        "to {:.0f} deg against each other; {}",
                        NameOf(like), c.worst_uncertainty_px, tilts, RemedyFor(like)));
  }
  CheckFocalLength(c);
  AddNotes(c);
  if (alike > kMaxAlike) {
    c.notes.push_back(fmt::format(
        "the images contradict each other: errors within one are alike, which makes the deviations {:.1f} "
        "times as large as errors of single corners would; are all images of one camera with one zoom and "
        "focus, the board flat and its numbers right?",
        alike));
  }
  if (start->rival && std::abs(Parameters(*start->rival)[0] - Parameters(c.camera)[0]) > 5 * c.sigma[0]) {
    std::string other;
    for (const int i : free) {
      other += fmt::format(" {} {:.5g}", ParameterNames(*start->rival)[static_cast<std::size_t>(i)],
                           Parameters(*start->rival)[i]);
    }
    c.notes.push_back(
        fmt::format("quite another {} camera fits these images as well:{}", NameOf(like), other));
  }
  return c;
}

std::vector<BoardView> Refit(const Board& board, std::span<const cv::Mat> images,
                             std::span<const BoardView> views, const Calibration& calibration) {
  std::vector<BoardView> refitted(views.begin(), views.end());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto& X_CT = calibration.views[i].X_CT;
    if (X_CT) refitted[i].corners = RefitBoard(images[i], board, views[i].corners, calibration.camera, *X_CT);
  }
  return refitted;
}

std::vector<std::string> CalibratedModels() { return {"pinhole", "unified", "fisheye", "double_sphere"}; }

CameraModel CameraLike(const std::string& model, cv::Size image) {
  CameraModel camera = BrownConrady{};
  if (model == "unified") camera = Unified{};
  if (model == "fisheye") camera = KannalaBrandt{};
  if (model == "double_sphere") camera = DoubleSphere{};
  std::visit([&](auto& c) { c.width_px = image.width, c.height_px = image.height; }, camera);
  return camera;
}

}  // namespace kestrel::vision
