// SPDX-License-Identifier: Apache-2.0
#include "vision/calibrate.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "geometry/tait_bryan.h"
#include "vision/ray_pose.h"
#include "vision/view_adjustment.h"

namespace kestrel {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kLeastViews = 4;
constexpr std::size_t kLeastCorners = 8;
constexpr double kSamePose = 0.02;      // of the image's diagonal: views nearer than this are one
constexpr double kLeastReach = 0.5;     // of half the image's smaller side: the outermost corner
constexpr double kLeastTilts_deg = 6;   // between the two boards that differ most
constexpr double kMostResidual_px = 3;  // beyond it the model is not of this lens
constexpr double kMostUncertainty_px = 5;
constexpr double kMostSigmaXi = 0.1;
// What a corner's own covariance does not know: sampling, the pixel's shape.
constexpr double kCornerFloor_px = 0.01;
constexpr double kOutlier = 5;             // deviations
constexpr double kMostOutliers = 1.0 / 3;  // of a view's corners

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

// Focal lengths and what bends the view most, for the first stage.
std::vector<int> CoarseParameters(const CameraModel& camera) {
  if (std::holds_alternative<Unified>(camera)) return {0, 1, 4};
  if (std::holds_alternative<DoubleSphere>(camera)) return {0, 1, 4, 5};
  return {0, 1};
}

Vector2d MiddleOf(const CameraModel& camera) {
  return {(WidthPx(camera) - 1) / 2.0, (HeightPx(camera) - 1) / 2.0};
}

SeenPoint PointOf(const BoardCorner& corner, const std::vector<Vector2d>& places) {
  const Eigen::Matrix2d covariance =
      corner.covariance + kCornerFloor_px * kCornerFloor_px * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d L = covariance.llt().matrixL();
  return {places[static_cast<std::size_t>(corner.index)], corner.pixel, L.inverse()};
}

// The error of a point in px; none where the camera cannot see it.
std::optional<Vector2d> ErrorOf(const CameraModel& camera, const Pose& X_CT, const SeenPoint& point) {
  const auto uv = Project(camera, X_CT * Vector3d(point.p_T.x(), point.p_T.y(), 0));
  if (!uv) return std::nullopt;
  return *uv - point.pixel;
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The deviation along one axis of whitened errors, whatever some of them are.
double RobustScale(const Adjustment& a) {
  std::vector<double> norms;
  for (const AdjustedView& view : a.views) {
    for (const SeenPoint& point : view.points) {
      const auto error = WhitenedError(a.camera, view.X_CT, point);
      norms.push_back(error ? error->norm() : std::numeric_limits<double>::infinity());
    }
  }
  constexpr double kMedianOfRayleigh = 1.1774;
  return std::max(Median(std::move(norms)) / kMedianOfRayleigh, 1e-9);
}

// The pose of a view under a camera: by its rays, then by a few steps of adjustment. None: too few rays.
std::optional<Pose> PoseOf(const CameraModel& camera, const std::vector<SeenPoint>& points, int steps) {
  std::vector<PlaneRay> rays;
  for (const SeenPoint& point : points) {
    if (const auto ray = Ray(camera, point.pixel)) rays.push_back({point.p_T, *ray});
  }
  if (rays.size() < kLeastCorners || 3 * rays.size() < 2 * points.size()) return std::nullopt;
  const auto X_CT = PlanePoseFromRays(rays);
  if (!X_CT) return std::nullopt;
  Adjustment one{camera, {{*X_CT, points}}};
  Adjust(one, {.free = {}, .huber = 3 * RobustScale(one), .max_steps = steps});
  return one.views[0].X_CT;
}

double MedianError(const CameraModel& camera, const Pose& X_CT, const std::vector<SeenPoint>& points) {
  std::vector<double> errors;
  for (const SeenPoint& point : points) {
    const auto error = ErrorOf(camera, X_CT, point);
    errors.push_back(error ? error->norm() : kLostError_px);
  }
  return Median(std::move(errors));
}

// Cameras without distortion, about the middle of the image: for each shape of the lens, many focal lengths.
// reach_px: how far from the middle corners were seen; each start sees them there at another angle.
std::vector<std::vector<CameraModel>> Starts(const CameraModel& like, double reach_px) {
  std::vector<std::vector<CameraModel>> starts;
  const auto add = [&](std::initializer_list<double> own) {
    CameraModel camera = like;
    Eigen::VectorXd all = Eigen::VectorXd::Zero(Parameters(like).size());
    std::copy(own.begin(), own.end(), all.begin() + 4);
    starts.emplace_back();
    for (const double angle_deg : {10, 18, 26, 35, 45, 55, 65, 76, 88, 101}) {
      const double angle = Radians(angle_deg);
      all.head<2>().setOnes(), all.segment<2>(2).setZero();
      SetParameters(camera, all);
      const auto m = Project(camera, {std::sin(angle), 0, std::cos(angle)});
      if (!m) continue;
      all.head<2>().setConstant(reach_px / m->x());
      all.segment<2>(2) = MiddleOf(like);
      SetParameters(camera, all);
      starts.back().push_back(camera);
    }
  };
  if (std::holds_alternative<Unified>(like)) {
    for (const double xi : {0.3, 0.8, 1.3, 2.2}) add({xi});
  } else if (std::holds_alternative<DoubleSphere>(like)) {
    for (const auto& [xi, alpha] : {std::pair{0.0, 0.3}, {0.0, 0.5}, {-0.2, 0.6}, {0.2, 0.65}})
      add({xi, alpha});
  } else {
    add({});
  }
  return starts;
}

// How badly a start fits, px: the mean over some views of the median error of their corners.
double Misfit(const CameraModel& camera, const std::vector<AdjustedView>& views) {
  constexpr std::size_t kSome = 8, kSomePoints = 30;
  constexpr double kLost_px = 50;
  double sum = 0;
  const std::size_t count = std::min(kSome, views.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<SeenPoint>& all = views[i * views.size() / count].points;
    std::vector<SeenPoint> points;
    const std::size_t few = std::min(kSomePoints, all.size());
    for (std::size_t j = 0; j < few; ++j) points.push_back(all[j * all.size() / few]);
    const auto X_CT = PoseOf(camera, points, 4);
    sum += X_CT ? std::min(MedianError(camera, *X_CT, points), kLost_px) : kLost_px;
  }
  return sum / static_cast<double>(count);
}

// The views of an adjustment that a camera can place; the others, by their number, are lost.
struct Placed {
  Adjustment adjustment;
  std::vector<std::size_t> from;  // the view's number
};
Placed PlaceAll(const CameraModel& camera, const std::vector<AdjustedView>& views) {
  Placed placed{{camera, {}}, {}};
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto X_CT = PoseOf(camera, views[i].points, 10);
    if (!X_CT) continue;
    placed.adjustment.views.push_back({*X_CT, views[i].points});
    placed.from.push_back(i);
  }
  return placed;
}

// The camera that fits best of those to which the starts lead, the best start of each shape of the lens. And
// one elsewhere that fits as well within three deviations, if there is any.
struct Beginning {
  CameraModel best;
  std::optional<CameraModel> rival;
};
// None: no start sees enough.
std::optional<Beginning> Begin(const CameraModel& like, const std::vector<AdjustedView>& views) {
  double reach_px = 0;
  for (const AdjustedView& view : views) {
    for (const SeenPoint& point : view.points)
      reach_px = std::max(reach_px, (point.pixel - MiddleOf(like)).norm());
  }
  std::vector<Adjustment> ends;
  for (const std::vector<CameraModel>& shape : Starts(like, reach_px)) {
    std::vector<double> misfits;
    for (const CameraModel& start : shape) misfits.push_back(Misfit(start, views));
    if (misfits.empty()) continue;
    const auto least = std::min_element(misfits.begin(), misfits.end()) - misfits.begin();
    Adjustment a{shape[static_cast<std::size_t>(least)], {}};
    for (const std::vector<int>& free : {CoarseParameters(like), FreeParameters(like)}) {
      a = PlaceAll(a.camera, views).adjustment;
      if (a.views.empty()) break;
      Adjust(a, {.free = free, .huber = 2 * RobustScale(a), .max_steps = 30});
    }
    if (!a.views.empty()) ends.push_back(std::move(a));
  }
  if (ends.empty()) return std::nullopt;

  // A start that leaves more views without a pose is no better for that.
  std::size_t most = 0;
  for (const Adjustment& a : ends) most = std::max(most, a.views.size());
  std::erase_if(ends, [&](const Adjustment& a) { return a.views.size() < most; });
  double scale = std::numeric_limits<double>::infinity();
  for (const Adjustment& a : ends) scale = std::min(scale, RobustScale(a));
  const auto cost = [&](const Adjustment& a) { return CostOf(a, 3 * scale) / (scale * scale); };
  std::stable_sort(ends.begin(), ends.end(),
                   [&](const Adjustment& a, const Adjustment& b) { return cost(a) < cost(b); });
  Beginning beginning{ends[0].camera, std::nullopt};
  for (const Adjustment& a : ends) {
    const double f = Parameters(ends[0].camera)[0];
    if (cost(a) < cost(ends[0]) + 9 && std::abs(Parameters(a.camera)[0] / f - 1) > 0.03)
      beginning.rival = a.camera;
  }
  return beginning;
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
    throw InputError({fmt::format("no {} was found in any of the {} images", Describe(board), views.size())});
  if (usable.size() < kLeastViews) {
    throw InputError({fmt::format(
        "{} of {} images show at least {} corners of the {}; a calibration needs {}. "
        "Corners seen: {}",
        usable.size(), views.size(), kLeastCorners, Describe(board), kLeastViews, SeenIn(views))});
  }
  const double diagonal = std::hypot(WidthPx(like), HeightPx(like));
  const std::size_t different = DifferentViews(views, usable, diagonal).size();
  if (different < kLeastViews) {
    throw InputError(
        {fmt::format("the {} images that show the board show it in only {} different pose{}: a calibration "
                     "needs {}, tilted "
                     "and spread over the image",
                     usable.size(), different, different == 1 ? "" : "s", kLeastViews)});
  }
  const double half = std::min(WidthPx(like), HeightPx(like)) / 2.0;
  double reach = 0;
  for (const std::size_t i : usable) {
    for (const BoardCorner& corner : views[i].corners)
      reach = std::max(reach, (corner.pixel - MiddleOf(like)).norm());
  }
  if (reach < kLeastReach * half) {
    throw InputError(
        {fmt::format("the board is seen only within {:.0f} px of the middle of the image of {} x {}: show it "
                     "nearer to the "
                     "edges too, where the distortion is",
                     reach, WidthPx(like), HeightPx(like))});
  }
}

// The greatest angle between the normals of two boards, rad.
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

// One deviation of the pixel of a known ray, the greatest over the image.
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
  if (std::holds_alternative<Unified>(c.camera) && c.sigma[4] > kMostSigmaXi) {
    c.notes.push_back(
        fmt::format("xi, f and k1 can hardly be told apart in these images (xi +- {:.2g}): where rays go is "
                    "known all the same",
                    c.sigma[4]));
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

}  // namespace

Calibration Calibrate(const Board& board, std::span<const BoardView> views, const CameraModel& like) {
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].corners.size() >= kLeastCorners) usable.push_back(i);
  }
  CheckViews(board, views, usable, like);

  const std::vector<Vector2d> places = Corners(board);
  std::vector<AdjustedView> seen;
  for (const std::size_t i : usable) {
    AdjustedView view;
    for (const BoardCorner& corner : views[i].corners) view.points.push_back(PointOf(corner, places));
    seen.push_back(std::move(view));
  }
  const std::vector<int> free = FreeParameters(like);
  const auto start = Begin(like, seen);
  if (!start)
    throw InputError({fmt::format("no start of the {} model sees the board in these images", NameOf(like))});

  // Large errors count less and less as the rest gets better.
  Placed placed = PlaceAll(start->best, seen);
  for (int round = 0; round < 3; ++round) {
    Adjust(placed.adjustment, {.free = free, .huber = 2.5 * RobustScale(placed.adjustment)});
    placed = PlaceAll(placed.adjustment.camera, seen);  // once more, now that the camera is known better
  }
  Calibration c{placed.adjustment.camera, free, {}, {}, {}, 0, 0, 0, 0, 0, {}};
  c.views.resize(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    c.views[i].name = views[i].name;
    if (views[i].corners.size() < kLeastCorners) {
      c.views[i].left_out = views[i].corners.empty()
                                ? "the board was not found"
                                : fmt::format("only {} corners were found", views[i].corners.size());
    } else {
      c.views[i].left_out = "no pose of the board fits it";  // until one does
    }
  }

  // What is noise takes part, by least squares; what is not is set aside, and named.
  Adjustment a;
  std::vector<std::size_t> from;
  for (int round = 0; round < 2; ++round) {
    const double limit = kOutlier * RobustScale(placed.adjustment);
    a = {placed.adjustment.camera, {}};
    from.clear();
    for (std::size_t v = 0; v < placed.from.size(); ++v) {
      const AdjustedView& all = placed.adjustment.views[v];
      CalibratedView& view = c.views[usable[placed.from[v]]];
      AdjustedView used{all.X_CT, {}};
      for (const SeenPoint& point : all.points) {
        const auto error = WhitenedError(a.camera, all.X_CT, point);
        if (error && error->norm() <= limit) used.points.push_back(point);
      }
      const std::size_t wild = all.points.size() - used.points.size();
      if (static_cast<double>(wild) > kMostOutliers * static_cast<double>(all.points.size()) ||
          used.points.size() < kLeastCorners) {
        view.left_out =
            fmt::format("{} of its {} corners do not fit the other views", wild, all.points.size());
        continue;
      }
      view.left_out.clear();
      a.views.push_back(std::move(used));
      from.push_back(v);
    }
    if (a.views.size() < kLeastViews) {
      throw InputError({fmt::format("only {} of {} views agree on a {} camera; a calibration needs {}",
                                    a.views.size(), usable.size(), NameOf(like), kLeastViews)});
    }
    Adjust(a, {.free = free});
    placed.adjustment.camera = a.camera;
    for (std::size_t i = 0; i < from.size(); ++i) placed.adjustment.views[from[i]].X_CT = a.views[i].X_CT;
  }
  c.camera = a.camera;

  double square = 0, whitened_square = 0;
  int used = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const std::size_t number = usable[placed.from[from[i]]];
    CalibratedView& view = c.views[number];
    view.X_CT = a.views[i].X_CT;
    double view_square = 0;
    int view_used = 0;
    for (const BoardCorner& corner : views[number].corners) {
      const SeenPoint point = PointOf(corner, places);
      const auto error = ErrorOf(c.camera, *view.X_CT, point);
      const bool is_used = std::any_of(a.views[i].points.begin(), a.views[i].points.end(),
                                       [&](const SeenPoint& p) { return p.p_T == point.p_T; });
      view.corners.push_back(
          {corner.index, corner.pixel, error.value_or(Vector2d::Constant(std::nan(""))), is_used});
      ++c.corners;
      if (!is_used || !error) {
        ++c.corners_not_used;
        continue;
      }
      view_square += error->squaredNorm();
      whitened_square += (point.whiten * *error).squaredNorm();
      ++view_used;
      c.max_angle_seen_rad = std::max(c.max_angle_seen_rad,
                                      AngleFromAxis(*view.X_CT * Vector3d(point.p_T.x(), point.p_T.y(), 0)));
    }
    view.rms_px = std::sqrt(view_square / std::max(view_used, 1));
    square += view_square;
    used += view_used;
  }
  c.rms_px = std::sqrt(square / used);

  if (!(c.rms_px < kMostResidual_px)) {
    throw InputError(
        {fmt::format("the {} model does not fit: {:.1f} px are left between what it says and what "
                     "is seen; try another model, or check the board's description",
                     NameOf(like), c.rms_px)});
  }
  const double tilts = Degrees(SpreadOfTilts(a.views));
  if (tilts < kLeastTilts_deg) {
    throw InputError(
        {fmt::format("in all {} views the board stands parallel to itself, within {:.1f} deg: tilt it "
                     "by 20 to 50 deg this way and that, or focal length and distance cannot be told "
                     "apart",
                     a.views.size(), tilts)});
  }
  const auto covariance = ParameterCovariance(a, free);
  const double freedom =
      2.0 * used - static_cast<double>(free.size()) - 6.0 * static_cast<double>(a.views.size());
  if (!covariance || !(freedom > 0)) {
    throw InputError({fmt::format("{} corners in {} views do not determine the {} parameters of the {} model",
                                  used, a.views.size(), free.size(), NameOf(like))});
  }
  c.covariance = *covariance * (whitened_square / freedom);
  c.sigma = c.covariance.diagonal().cwiseSqrt();
  c.worst_uncertainty_px = WorstUncertainty(c);
  if (!(c.worst_uncertainty_px < kMostUncertainty_px)) {
    throw InputError(
        {fmt::format("the views leave the {} model uncertain by {:.1f} px, with boards tilted by up "
                     "to {:.0f} deg against each other: show more of the field and more tilt, or take "
                     "a model with fewer parameters",
                     NameOf(like), c.worst_uncertainty_px, tilts)});
  }
  AddNotes(c);
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

std::vector<std::string> CalibratedModels() { return {"pinhole", "unified", "fisheye", "double_sphere"}; }

CameraModel CameraLike(const std::string& model, cv::Size image) {
  CameraModel camera = BrownConrady{};
  if (model == "unified") camera = Unified{};
  if (model == "fisheye") camera = KannalaBrandt{};
  if (model == "double_sphere") camera = DoubleSphere{};
  std::visit([&](auto& c) { c.width_px = image.width, c.height_px = image.height; }, camera);
  return camera;
}

Coverage CoverageOf(const Calibration& calibration) {
  Coverage c;
  const std::size_t cells = static_cast<std::size_t>(c.cols * c.rows);
  c.in_lens.resize(cells), c.corners.resize(cells);
  const double width = WidthPx(calibration.camera), height = HeightPx(calibration.camera);
  for (int row = 0; row < c.rows; ++row) {
    for (int col = 0; col < c.cols; ++col) {
      const Vector2d middle((col + 0.5) * width / c.cols - 0.5, (row + 0.5) * height / c.rows - 0.5);
      c.in_lens[static_cast<std::size_t>(row * c.cols + col)] = Ray(calibration.camera, middle).has_value();
    }
  }
  for (const CalibratedView& view : calibration.views) {
    for (const CornerResidual& corner : view.corners) {
      if (!corner.used) continue;
      const int col = std::clamp(static_cast<int>((corner.pixel.x() + 0.5) * c.cols / width), 0, c.cols - 1);
      const int row = std::clamp(static_cast<int>((corner.pixel.y() + 0.5) * c.rows / height), 0, c.rows - 1);
      ++c.corners[static_cast<std::size_t>(row * c.cols + col)];
    }
  }
  int in_lens = 0, covered = 0;
  for (std::size_t i = 0; i < cells; ++i) {
    in_lens += c.in_lens[i] || c.corners[i] > 0;
    covered += c.corners[i] > 0;
  }
  c.share = static_cast<double>(covered) / std::max(in_lens, 1);
  return c;
}

}  // namespace kestrel
