// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/calibrate.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "geometry/tait_bryan.h"
#include "vision/calibration/calibration_start.h"
#include "vision/calibration/view_adjustment.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMinViews = 4;
constexpr double kSamePose = 0.02;   // of the image's diagonal: views nearer than this are one
constexpr double kMinReach = 0.5;    // of half the image's smaller side: the outermost corner
constexpr double kMinTilts_deg = 6;  // between the two boards that differ most
constexpr double kMaxAlike = 2;      // see AllowForImages; of noise alone it is 0.5 to 1
// Of the focal length. The double sphere has a valley of cameras that fit alike, of which its deviations,
// straight lines, see only the floor nearby.
constexpr double kMaxSigmaFocal = 0.05, kMaxSigmaFocalOfSpheres = 0.02;
constexpr double kMaxUncertainty_px = 5;
constexpr double kMaxSigmaXi = 0.1;
constexpr double kFirstCommon_px = 0.05;  // see PointsOf; until it is known
constexpr double kOutlier = 5;            // deviations
constexpr double kMaxLeftOut = 1.0 / 3;   // of the views that show enough of the board
constexpr double kMaxOutliers = 1.0 / 3;  // of a view's corners

// Of a unified camera: fx, fy, cx, cy and xi alone.
const std::vector<int> kUndistorted = {0, 1, 2, 3, 4};

std::vector<int> FreeParameters(const CameraModel& camera) {
  std::vector<int> free;
  const std::vector<std::string> names = ParameterNames(camera);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] != "k3" || std::holds_alternative<KannalaBrandt>(camera)) {
      if (names[i] != "skew") free.push_back(static_cast<int>(i));
    }
  }
  return free;
}

// Of views that show the same, the first; their numbers.
std::vector<std::size_t> DifferentViews(std::span<const BoardView> views,
                                        const std::vector<std::size_t>& usable, double diagonal_px) {
  std::vector<std::size_t> different;
  for (const std::size_t i : usable) {
    const bool known = std::any_of(different.begin(), different.end(), [&](std::size_t j) {
      double sum = 0;
      int common = 0;
      for (const BoardCorner& a : views[i].corners) {
        for (const BoardCorner& b : views[j].corners) {
          if (a.index == b.index) sum += (a.pixel - b.pixel).norm(), ++common;
        }
      }
      return common > 0 && sum / common < kSamePose * diagonal_px;
    });
    if (!known) different.push_back(i);
  }
  return different;
}

std::string SeenIn(std::span<const BoardView> views) {
  std::string text;
  for (const BoardView& view : views)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", view.name, view.corners.size());
  return text;
}

// Refuses views that cannot determine a camera, whatever it is.
void CheckViews(const Board& board, std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                const CameraModel& like) {
  const auto any = std::any_of(views.begin(), views.end(), [](const auto& v) { return !v.corners.empty(); });
  if (!any)
    throw InputError({},
                     fmt::format("no {} was found in any of the {} images", Describe(board), views.size()));
  if (usable.size() < kMinViews) {
    throw InputError(
        {}, fmt::format("{} of {} images show at least {} corners of the {}; a calibration needs {}. "
                        "Corners seen: {}",
                        usable.size(), views.size(), kMinCorners, Describe(board), kMinViews, SeenIn(views)));
  }
  const double diagonal = std::hypot(WidthPx(like), HeightPx(like));
  const std::size_t different = DifferentViews(views, usable, diagonal).size();
  if (different < kMinViews) {
    throw InputError(
        {},
        fmt::format("the {} images that show the board show it in only {} different pose{}: a calibration "
                    "needs {}, tilted "
                    "and spread over the image",
                    usable.size(), different, different == 1 ? "" : "s", kMinViews));
  }
  const double half = std::min(WidthPx(like), HeightPx(like)) / 2.0;
  double reach = 0;
  for (const std::size_t i : usable) {
    for (const BoardCorner& corner : views[i].corners)
      reach = std::max(reach, (corner.pixel - MiddleOf(like)).norm());
  }
  if (reach < kMinReach * half) {
    throw InputError(
        {},
        fmt::format("the board is seen only within {:.0f} px of the middle of the image of {} x {}: show it "
                    "nearer to the "
                    "edges too, where the distortion is",
                    reach, WidthPx(like), HeightPx(like)));
  }
}

// The maximum angle between the normals of two boards, rad.
double SpreadOfTilts(const std::vector<AdjustedView>& views) {
  double least = 1;
  for (const AdjustedView& a : views) {
    for (const AdjustedView& b : views) {
      const Vector3d z = Vector3d::UnitZ();
      least = std::min(least, (a.X_CT.R * z).dot(b.X_CT.R * z));
    }
  }
  return std::acos(std::clamp(least, -1.0, 1.0));
}

// One deviation of the pixel of a known ray, the largest over the image.
double WorstUncertainty(const Calibration& c) {
  constexpr int kCols = 9, kRows = 7;
  double worst = 0;
  for (int row = 0; row < kRows; ++row) {
    for (int col = 0; col < kCols; ++col) {
      const Vector2d uv(col * (WidthPx(c.camera) - 1.0) / (kCols - 1),
                        row * (HeightPx(c.camera) - 1.0) / (kRows - 1));
      const auto ray = Ray(c.camera, uv);
      Eigen::Matrix2Xd d_all;
      // Beyond what was seen the lens may show nothing; there nobody asks.
      if (!ray || AngleFromAxis(*ray) > c.max_angle_seen_rad || !Project(c.camera, *ray, nullptr, &d_all))
        continue;
      Eigen::Matrix2Xd d(2, static_cast<Eigen::Index>(c.free.size()));
      for (std::size_t i = 0; i < c.free.size(); ++i)
        d.col(static_cast<Eigen::Index>(i)) = d_all.col(c.free[i]);
      worst = std::max(worst, std::sqrt((d * c.covariance * d.transpose()).trace() / 2));
    }
  }
  return worst;
}

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
  if (std::holds_alternative<Unified>(c.camera) && c.free == kUndistorted)
    c.notes.push_back("the images ask for no distortion: k1, k2, p1 and p2 are held at 0");
  for (const CalibratedView& view : c.views) {
    if (!view.left_out.empty())
      c.notes.push_back(fmt::format("{} was left out: {}", view.name, view.left_out));
  }
  if (c.corners_not_used > 0) {
    c.notes.push_back(fmt::format("{} of {} corners were set aside: more than {:g} deviations off",
                                  c.corners_not_used, c.corners, kOutlier));
  }
}

// The corners of the usable views. A corner's error has a part of its own, which its fit knows, and one that
// is common to all: what the models of corner and lens leave out.
std::vector<std::vector<SeenPoint>> PointsOf(const Board& board, std::span<const BoardView> views,
                                             const std::vector<std::size_t>& usable, double common_px) {
  const std::vector<Vector2d> places = Corners(board);
  std::vector<std::vector<SeenPoint>> all;
  for (const std::size_t i : usable) {
    std::vector<SeenPoint> points;
    for (const BoardCorner& corner : views[i].corners) {
      const Eigen::Matrix2d covariance =
          corner.covariance + common_px * common_px * Eigen::Matrix2d::Identity();
      const Eigen::Matrix2d L = covariance.llt().matrixL();
      points.push_back({places[static_cast<std::size_t>(corner.index)], corner.pixel, L.inverse()});
    }
    all.push_back(std::move(points));
  }
  return all;
}

// The views that agree, with those of their corners whose errors are noise.
struct Agreeing {
  Adjustment adjustment;
  std::vector<std::size_t> numbers;               // of its views, among the usable
  std::vector<std::vector<std::size_t>> corners;  // of their points, among the view's
};

double FreedomOf(const Agreeing& a, std::size_t free) {
  double points = 0;
  for (const AdjustedView& view : a.adjustment.views) points += static_cast<double>(view.points.size());
  return 2 * points - static_cast<double>(free) - 6 * static_cast<double>(a.adjustment.views.size());
}

// left_out: of the usable views, why one does not agree; empty where it does.
Agreeing SelectAgreeing(const PlacedViews& placed, std::vector<std::string>& left_out) {
  const double limit = kOutlier * RobustScale(placed.adjustment);
  Agreeing agreeing{{placed.adjustment.camera, {}}, {}, {}};
  std::fill(left_out.begin(), left_out.end(), "no pose of the board fits it");
  for (std::size_t i = 0; i < placed.numbers.size(); ++i) {
    const AdjustedView& all = placed.adjustment.views[i];
    AdjustedView noise{all.X_CT, {}};
    std::vector<std::size_t> corners;
    for (std::size_t j = 0; j < all.points.size(); ++j) {
      const auto error = WhitenedError(placed.adjustment.camera, all.X_CT, all.points[j]);
      if (!error || error->norm() > limit) continue;
      noise.points.push_back(all.points[j]);
      corners.push_back(j);
    }
    const std::size_t wild = all.points.size() - corners.size();
    std::string& reason = left_out[placed.numbers[i]];
    reason.clear();
    if (static_cast<double>(wild) > kMaxOutliers * static_cast<double>(all.points.size()) ||
        corners.size() < kMinCorners) {
      reason = fmt::format("{} of its {} corners do not fit the other views", wild, all.points.size());
      continue;
    }
    agreeing.adjustment.views.push_back(std::move(noise));
    agreeing.numbers.push_back(placed.numbers[i]);
    agreeing.corners.push_back(std::move(corners));
  }
  return agreeing;
}

// The common part of the corners' errors, px: with it, errors are as large as they are expected to be.
double CommonError(std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                   const Agreeing& a, std::size_t free) {
  std::vector<std::pair<double, double>> squares;  // of the error, and expected by the corner's own part
  for (std::size_t i = 0; i < a.numbers.size(); ++i) {
    const AdjustedView& view = a.adjustment.views[i];
    for (std::size_t j = 0; j < view.points.size(); ++j) {
      const auto error = PixelError(a.adjustment.camera, view.X_CT, view.points[j]);
      const Eigen::Matrix2d& own = views[usable[a.numbers[i]]].corners[a.corners[i][j]].covariance;
      if (error) squares.emplace_back(error->squaredNorm() / 2, own.trace() / 2);
    }
  }
  const double expected = FreedomOf(a, free) / 2;
  const auto excess = [&](double common) {
    double sum = -expected;
    for (const auto& [square, own] : squares) sum += square / (own + common * common);
    return sum;
  };
  double low = 0, high = 100;
  if (!(excess(1e-6) > 0)) return 0;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (excess(middle) > 0 ? low : high) = middle;
  }
  return high;
}

// Large errors count less and less as the rest gets better.
PlacedViews AdjustRobustly(const CameraModel& start, const std::vector<int>& free,
                           const std::vector<std::vector<SeenPoint>>& points) {
  PlacedViews placed = PlaceViews(start, points);
  for (int round = 0; round < 3; ++round) {
    Adjust(placed.adjustment, {.free = free, .huber = 2.5 * RobustScale(placed.adjustment)});
    placed = PlaceViews(placed.adjustment.camera, points);  // once more, now that the camera is known better
  }
  return placed;
}

// The unified model without its distortion, where that does as well. Of a mirror that is nearly a parabola,
// xi and k1 bend the view alike to the first order: free together, neither is known, and no covariance says
// so. "As well": the distortion's gain is less than Schwarz's criterion asks for (Ann. Statist. 6, 1978).
void DropDistortion(const CameraModel& like, Agreeing& agreeing, std::vector<int>& free) {
  std::vector<std::vector<SeenPoint>> points;
  for (const AdjustedView& view : agreeing.adjustment.views) points.push_back(view.points);
  const auto start = StartCalibration(like, kUndistorted, points);
  if (!start) return;
  PlacedViews plain = AdjustRobustly(start->camera, kUndistorted, points);
  if (plain.numbers.size() < points.size()) return;
  constexpr double kAll = std::numeric_limits<double>::infinity();
  const double plain_cost = Adjust(plain.adjustment, {.free = kUndistorted});
  const double cost = CostOf(agreeing.adjustment, kAll), freedom = FreedomOf(agreeing, free.size());
  const double dropped = static_cast<double>(free.size() - kUndistorted.size());
  if (!(plain_cost - cost < dropped * std::log(freedom) * cost / freedom)) return;
  agreeing.adjustment = std::move(plain.adjustment);
  free = kUndistorted;
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

// What else to try for views that leave the parameters of a model open.
const char* RemedyFor(const CameraModel& camera) {
  if (std::holds_alternative<BrownConrady>(camera)) return "show more of the field, with more tilt";
  if (std::holds_alternative<DoubleSphere>(camera))
    return "take the model pinhole (to some 120 deg of view) or unified, or show more of the field, with "
           "more tilt";
  return "take the model pinhole (to some 120 deg of view), or show more of the field, with more tilt";
}

// How much larger than by independent corners the deviations are where the errors of an image may be alike,
// root mean square over the parameters; if that is much, the covariance becomes the larger one.
double AllowForImages(const Adjustment& adjustment, const std::vector<int>& free, Calibration& c) {
  const auto clustered = ClusteredCovariance(adjustment, free);
  if (!clustered) return 1;
  const Eigen::VectorXd scale = c.covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd one = scale.asDiagonal() * c.covariance * scale.asDiagonal();
  const Eigen::MatrixXd other = scale.asDiagonal() * *clustered * scale.asDiagonal();
  const double alike = std::sqrt(one.ldlt().solve(other).trace() / static_cast<double>(free.size()));
  if (alike > kMaxAlike) c.covariance = *clustered;
  return alike;
}

// Refuses a camera that is only of some of the images.
void CheckLeftOut(std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                  const std::vector<std::string>& left_out, const CameraModel& like) {
  std::string names;
  double count = 0;
  for (std::size_t i = 0; i < usable.size(); ++i) {
    if (left_out[i].empty()) continue;
    names += fmt::format("{}{}", count == 0 ? "" : ", ", views[usable[i]].name);
    ++count;
  }
  if (count <= kMaxLeftOut * static_cast<double>(usable.size())) return;
  throw InputError(
      {},
      fmt::format(
          "{:g} of {} images do not fit the {} camera of the others: {}. They may be of another camera, or "
          "of "
          "one whose zoom or focus changed; or the board's numbers (counts, side, spacing) are wrong, or the "
          "lens is one for another model",
          count, usable.size(), NameOf(like), names));
}

void CheckResidual(const Calibration& c, double accepted_px) {
  if (c.rms_px <= accepted_px) return;
  std::vector<const CalibratedView*> used;
  for (const CalibratedView& view : c.views) {
    if (view.left_out.empty()) used.push_back(&view);
  }
  std::stable_sort(used.begin(), used.end(), [](auto* a, auto* b) { return a->rms_px > b->rms_px; });
  std::string worst;
  for (std::size_t i = 0; i < std::min<std::size_t>(used.size(), 3); ++i)
    worst += fmt::format("{}{} {:.2f}", i == 0 ? "" : ", ", used[i]->name, used[i]->rms_px);
  throw PoorFit({}, fmt::format("the {} model does not fit: {:.2f} px rms are left between what it says and "
                                "what {} images show, where "
                                "{:g} px are accepted; worst: {}. The board's numbers may be wrong (counts, "
                                "side, spacing), the images "
                                "of several cameras, or of one whose zoom or focus changed, the board not "
                                "flat, or the lens one for "
                                "another model",
                                NameOf(c.camera), c.rms_px, used.size(), accepted_px, worst));
}

// Refuses parameters that the views leave open, though they may say well where rays go.
void CheckFocalLength(const Calibration& c) {
  const double most =
      std::holds_alternative<DoubleSphere>(c.camera) ? kMaxSigmaFocalOfSpheres : kMaxSigmaFocal;
  if (c.sigma.head<2>().maxCoeff() <= most * Parameters(c.camera)[0]) return;
  const std::vector<std::string> names = ParameterNames(c.camera);
  std::string open;
  for (std::size_t i = 0; i < c.free.size(); ++i) {
    const std::string& name = names[static_cast<std::size_t>(c.free[i])];
    if (name == "fx" || name == "xi" || name == "alpha")
      open += fmt::format("{}{} {:.4g} +- {:.2g}", open.empty() ? "" : ", ", name,
                          Parameters(c.camera)[c.free[i]], c.sigma[static_cast<Eigen::Index>(i)]);
  }
  throw InputError({}, fmt::format("the images do not determine the {} model: {}; {}", NameOf(c.camera), open,
                                   RemedyFor(c.camera)));
}

}  // namespace

Calibration Calibrate(const Board& board, std::span<const BoardView> views, const CameraModel& like,
                      double accepted_px) {
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
  if (std::holds_alternative<Unified>(like)) DropDistortion(like, agreeing, free);

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
  CheckResidual(c, accepted_px);
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

Coverage CoverageOf(const Calibration& calibration, std::span<const cv::Mat> images) {
  Coverage c;
  const double width = WidthPx(calibration.camera), height = HeightPx(calibration.camera);
  // A cell is as bright as in the image where it is brightest.
  cv::Mat brightest(c.rows, c.cols, CV_32FC1, cv::Scalar(0));
  for (const cv::Mat& image : images) {
    cv::Mat cells;
    cv::resize(image, cells, brightest.size(), 0, 0, cv::INTER_AREA);
    cells.convertTo(cells, CV_32F);
    cv::max(brightest, cells, brightest);
  }
  constexpr double kDark = 0.1;
  const double dark = kDark * cv::mean(brightest)[0];
  for (int row = 0; row < c.rows; ++row) {
    for (int col = 0; col < c.cols; ++col) {
      const Vector2d middle((col + 0.5) * width / c.cols - 0.5, (row + 0.5) * height / c.rows - 0.5);
      c.in_lens.push_back(Ray(calibration.camera, middle) && !(brightest.at<float>(row, col) < dark));
    }
  }
  c.corners.resize(c.in_lens.size());
  for (const CalibratedView& view : calibration.views) {
    for (const CornerResidual& corner : view.corners) {
      if (!corner.used) continue;
      const int col = std::clamp(static_cast<int>((corner.pixel.x() + 0.5) * c.cols / width), 0, c.cols - 1);
      const int row = std::clamp(static_cast<int>((corner.pixel.y() + 0.5) * c.rows / height), 0, c.rows - 1);
      ++c.corners[static_cast<std::size_t>(row * c.cols + col)];
    }
  }
  int in_lens = 0, covered = 0;
  for (std::size_t i = 0; i < c.in_lens.size(); ++i) {
    in_lens += c.in_lens[i] || c.corners[i] > 0;
    covered += c.corners[i] > 0;
  }
  c.share = static_cast<double>(covered) / std::max(in_lens, 1);
  return c;
}

}  // namespace kestrel::vision
