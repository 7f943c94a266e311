// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/calibrate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/tait_bryan.h"
#include "vision/calibration/agreeing_views.h"
#include "vision/calibration/board/circle_finder.h"
#include "vision/calibration/board_shape.h"
#include "vision/calibration/calibration_checks.h"
#include "vision/calibration/calibration_start.h"
#include "vision/calibration/calibration_uncertainty.h"
#include "vision/calibration/contradiction.h"
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
  if (!c.board.offsets_m.empty()) {
    const Vector2d rms_mm = 1000 * RmsOf(c.board);
    c.notes.push_back(fmt::format(
        "the board is not quite as its file says: in all images alike its corners are {:.2g} mm "
        "off in its plane and {:.2g} mm out of it, root mean square; the calibration allows for it",
        rms_mm.x(), rms_mm.y()));
  }
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
      c.max_angle_seen_rad = std::max(c.max_angle_seen_rad, AngleFromAxis(X_CT * point.p_T));
    }
    view.rms_px = std::sqrt(view_square / static_cast<double>(next));
    square += view_square;
    c.corners += static_cast<int>(points[number].size());
    c.corners_not_used += static_cast<int>(points[number].size() - next);
  }
  c.rms_px = std::sqrt(square / (c.corners - c.corners_not_used));
}

// A camera and the views that are of it, on the way to a calibration.
struct Fit {
  std::vector<int> free;
  std::optional<CameraModel> rival;            // see CalibrationStart
  std::vector<std::vector<SeenPoint>> points;  // of the usable views, all of them
  Agreeing agreeing;
  std::vector<std::string> left_out;  // of the usable views, why
};

// To a board that is as its file says.
Fit FitFlat(const Board& board, std::span<const BoardView> views, const std::vector<std::size_t>& usable,
            const CameraModel& like) {
  Fit fit{.free = FreeParameters(like),
          .rival = {},
          .points = PointsOf(board, views, usable, kFirstCommon_px),
          .agreeing = {},
          .left_out = std::vector<std::string>(usable.size())};
  const auto start = StartCalibration(like, fit.free, fit.points);
  if (!start)
    throw InputError({},
                     fmt::format("no start of the {} model sees the board in these images", NameOf(like)));
  fit.rival = start->rival;
  PlacedViews placed = AdjustRobustly(start->camera, fit.free, fit.points);
  for (int round = 0; round < 3; ++round) {
    fit.agreeing = SelectAgreeing(placed, fit.left_out);
    if (fit.agreeing.numbers.size() < kMinViews) {
      throw InputError({}, fmt::format("only {} of {} views agree on a {} camera; a calibration needs {}",
                                       fit.agreeing.numbers.size(), usable.size(), NameOf(like), kMinViews));
    }
    Adjust(fit.agreeing.adjustment, {.free = fit.free});
    if (round == 2) break;
    fit.points = PointsOf(board, views, usable, CommonError(views, usable, fit.agreeing, fit.free.size()));
    placed = PlaceViews(fit.agreeing.adjustment.camera, fit.points);
  }
  return fit;
}

// A board that is found in fewer than one of so many images may not be the one in them.
constexpr std::size_t kSeldom = 3;

// To the board as it is, where the images ask for it. Then more corners are noise, and errors are smaller.
void FitBoardToo(const Board& board, std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                 Fit& fit) {
  Agreeing& agreeing = fit.agreeing;
  if (!FindBoardShape(board, agreeing, fit.free)) return;
  for (int round = 0; round < 3; ++round) {
    const BoardShape shape = agreeing.adjustment.board;
    fit.points = PointsOf(board, views, usable, CommonError(views, usable, agreeing, fit.free.size()), shape);
    PlacedViews placed = PlaceViews(agreeing.adjustment.camera, fit.points);
    placed.adjustment.board = shape;
    agreeing = SelectAgreeing(placed, fit.left_out);
    AdjustBoardShape(agreeing, fit.free);
  }
}

// The calibration so far: camera, board, and what is left of each view.
Calibration CalibrationOf(const Board& board, std::span<const BoardView> views,
                          const std::vector<std::size_t>& usable, Fit& fit) {
  Calibration c;
  c.camera = fit.agreeing.adjustment.camera;
  c.board = fit.agreeing.adjustment.board;
  c.free = fit.free;
  for (const BoardView& view : views) {
    c.views.push_back({.name = view.name, .left_out = "", .X_CT = {}, .rms_px = 0, .corners = {}});
    if (view.corners.empty())
      c.views.back().left_out = "the board was not found";
    else if (view.corners.size() < kMinCorners)
      c.views.back().left_out = fmt::format("only {} corners were found", view.corners.size());
  }
  for (std::size_t i = 0; i < usable.size(); ++i) c.views[usable[i]].left_out = fit.left_out[i];
  if (!c.board.offsets_m.empty()) fit.points = PointsOf(board, views, usable, 0, c.board);
  AddResiduals(views, usable, fit.points, fit.agreeing, c);
  return c;
}

// Of the discs against their spacing, which every image shows: by a wrong one their middles would be moved wrongly.
void CheckDiameter(const Board& board, std::span<const cv::Mat> images, std::span<const BoardView> views,
                   const Calibration& calibration) {
  constexpr double kOff = 0.1;
  const auto* grid = std::get_if<CircleGrid>(&board);
  if (!grid) return;
  std::vector<double> seen_m;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto& X_CT = calibration.views[i].X_CT;
    if (!X_CT) continue;
    const auto of_view = SeenDiameters_m(images[i], *grid, views[i].corners, calibration.camera, *X_CT);
    seen_m.insert(seen_m.end(), of_view.begin(), of_view.end());
  }
  if (seen_m.empty()) return;
  const auto middle = seen_m.begin() + static_cast<std::ptrdiff_t>(seen_m.size() / 2);
  std::nth_element(seen_m.begin(), middle, seen_m.end());
  if (std::abs(*middle / grid->diameter_m - 1) < kOff) return;
  throw InputError(
      {}, fmt::format("the board's file says circles of {:.3g} mm with a spacing of {:.3g} mm; by the "
                      "images they are of {:.3g} mm: one of the numbers is wrong",
                      1000 * grid->diameter_m, 1000 * grid->spacing_m, 1000 * *middle));
}

}  // namespace

Calibration Calibrate(const Board& board, std::span<const BoardView> views, const CameraModel& like,
                      std::optional<double> accepted_px) {
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].corners.size() >= kMinCorners) usable.push_back(i);
  }
  CheckViews(board, views, usable, like);
  const double usual_px = AcceptedResidual(views, like);
  Fit fit = FitFlat(board, views, usable, like);
  CheckLeftOut(views, usable, fit.left_out, like);
  // A board whose numbers are wrong would otherwise become another one.
  CheckResidual(CalibrationOf(board, views, usable, fit), std::max(usual_px, accepted_px.value_or(0)));
  FitBoardToo(board, views, usable, fit);
  CheckLeftOut(views, usable, fit.left_out, like);
  const std::size_t contradicting = LeaveOutContradicting(fit.agreeing, fit.free, fit.left_out);
  DropDistortion(like, fit.agreeing, fit.free);

  const std::vector<int>& free = fit.free;
  const Agreeing& agreeing = fit.agreeing;
  Calibration c = CalibrationOf(board, views, usable, fit);
  CheckResidual(c, accepted_px.value_or(usual_px));
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
  if (kSeldom * usable.size() < views.size())
    c.notes.insert(c.notes.begin(),
                   fmt::format("the board was found in {} of {} images only: a part of another board may "
                               "look like it; are the numbers in its file right?",
                               usable.size(), views.size()));
  if (contradicting > 1) {
    c.notes.push_back(fmt::format(
        "the images contradict each other: {} of {} want a focal length and a centre of their own; "
        "are all of one camera with one zoom and focus?",
        contradicting, usable.size()));
  }
  if (alike > kMaxAlike) {
    c.notes.push_back(
        fmt::format("errors within an image are alike, as of a board that bends; the deviations allow for "
                    "that and are {:.1f} "
                    "times those of single corners",
                    alike));
  }
  if (fit.rival && std::abs(Parameters(*fit.rival)[0] - Parameters(c.camera)[0]) > 5 * c.sigma[0]) {
    std::string other;
    for (const int i : free) {
      other += fmt::format(" {} {:.5g}", ParameterNames(*fit.rival)[static_cast<std::size_t>(i)],
                           Parameters(*fit.rival)[i]);
    }
    c.notes.push_back(
        fmt::format("quite another {} camera fits these images as well:{}", NameOf(like), other));
  }
  return c;
}

std::vector<BoardView> Refit(const Board& board, std::span<const cv::Mat> images,
                             std::span<const BoardView> views, const Calibration& calibration) {
  CheckDiameter(board, images, views, calibration);
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
