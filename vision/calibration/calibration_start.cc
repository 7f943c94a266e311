// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/calibration_start.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/tait_bryan.h"
#include "vision/calibration/ray_pose.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Focal lengths and what bends the view most, for the first stage.
std::vector<int> CoarseParameters(const CameraModel& camera) {
  if (std::holds_alternative<Unified>(camera)) return {0, 1, 4};
  if (std::holds_alternative<DoubleSphere>(camera)) return {0, 1, 4, 5};
  return {0, 1};
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The pose of a view under a camera: by its rays, then by a few steps of adjustment. None: too few rays.
std::optional<Pose> PoseOf(const CameraModel& camera, const std::vector<SeenPoint>& points, int steps) {
  std::vector<PlaneRay> rays;
  for (const SeenPoint& point : points) {
    if (const auto ray = Ray(camera, point.pixel)) rays.push_back({point.p_T.head<2>(), *ray});
  }
  if (rays.size() < kMinCorners || 3 * rays.size() < 2 * points.size()) return std::nullopt;
  const auto X_CT = PlanePoseFromRays(rays);
  if (!X_CT) return std::nullopt;
  Adjustment one{camera, {{*X_CT, points}}};
  Adjust(one, {.free = {}, .huber = 3 * RobustScale(one), .max_steps = steps});
  return one.views[0].X_CT;
}

double MedianError(const CameraModel& camera, const Pose& X_CT, const std::vector<SeenPoint>& points) {
  std::vector<double> errors;
  for (const SeenPoint& point : points) {
    const auto error = PixelError(camera, X_CT, point);
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
double Misfit(const CameraModel& camera, const std::vector<std::vector<SeenPoint>>& views) {
  constexpr std::size_t kSome = 8, kSomePoints = 30;
  constexpr double kLost_px = 50;
  double sum = 0;
  const std::size_t count = std::min(kSome, views.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<SeenPoint>& all = views[i * views.size() / count];
    std::vector<SeenPoint> points;
    const std::size_t few = std::min(kSomePoints, all.size());
    for (std::size_t j = 0; j < few; ++j) points.push_back(all[j * all.size() / few]);
    const auto X_CT = PoseOf(camera, points, 4);
    sum += X_CT ? std::min(MedianError(camera, *X_CT, points), kLost_px) : kLost_px;
  }
  return sum / static_cast<double>(count);
}

}  // namespace

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

PlacedViews PlaceViews(const CameraModel& camera, const std::vector<std::vector<SeenPoint>>& views) {
  PlacedViews placed{{camera, {}}, {}};
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto X_CT = PoseOf(camera, views[i], 10);
    if (!X_CT) continue;
    placed.adjustment.views.push_back({*X_CT, views[i]});
    placed.numbers.push_back(i);
  }
  return placed;
}

std::optional<CalibrationStart> StartCalibration(const CameraModel& like, const std::vector<int>& free,
                                                 const std::vector<std::vector<SeenPoint>>& views) {
  double reach_px = 0;
  for (const std::vector<SeenPoint>& view : views) {
    for (const SeenPoint& point : view) reach_px = std::max(reach_px, (point.pixel - MiddleOf(like)).norm());
  }
  std::vector<Adjustment> ends;
  for (const std::vector<CameraModel>& shape : Starts(like, reach_px)) {
    std::vector<double> misfits;
    for (const CameraModel& start : shape) misfits.push_back(Misfit(start, views));
    if (misfits.empty()) continue;
    const auto least = std::min_element(misfits.begin(), misfits.end()) - misfits.begin();
    Adjustment a{shape[static_cast<std::size_t>(least)], {}};
    for (const std::vector<int>& stage : {CoarseParameters(like), free}) {
      a = PlaceViews(a.camera, views).adjustment;
      if (a.views.empty()) break;
      Adjust(a, {.free = stage, .huber = 2 * RobustScale(a), .max_steps = 30});
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
  CalibrationStart start{ends[0].camera, std::nullopt};
  for (const Adjustment& a : ends) {
    const double f = Parameters(ends[0].camera)[0];
    if (cost(a) < cost(ends[0]) + 9 && std::abs(Parameters(a.camera)[0] / f - 1) > 0.03)
      start.rival = a.camera;
  }
  return start;
}

}  // namespace kestrel::vision
