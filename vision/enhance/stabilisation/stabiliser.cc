// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/stabiliser.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "geometry/pose.h"
#include "vision/camera/views.h"
#include "vision/enhance/stabilisation/bounded_path.h"
#include "vision/enhance/stabilisation/row_warps.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWidest_rad = 1.9;            // of the view that is made of a wide lens
constexpr double kAnchored = 0.3;              // share of the view that the reference must fill
constexpr double kStrength_s = 0.3;            // over which the strength changes
constexpr double kAhead = 0.75, kAhead_s = 2;  // of the lag, and at most: how far ahead a bound is foreseen
constexpr double kRim_px = 0.5;                // of the image that a bound view leaves out
constexpr int kGridSteps = 4;                  // of the grid by which a view is within the image

Pinhole VirtualCamera(const std::optional<CameraModel>& camera) {
  if (!camera) return {};
  if (const auto* pinhole = std::get_if<Pinhole>(&*camera)) return *pinhole;
  if (const auto pinhole = CentralPinhole(*camera, kWidest_rad)) return *pinhole;
  throw std::invalid_argument("the camera does not see along its own axis");
}

// What is shown of a picture of this size, as a homography and the size of the view.
std::pair<Matrix3d, cv::Size> Shown(const cv::Size& size, double crop, bool scale) {
  Matrix3d Z = Matrix3d::Identity();
  cv::Size shown = size;
  if (!scale)  // even, as videos have it
    shown = {std::max(2, 2 * static_cast<int>(crop * size.width / 2)),
             std::max(2, 2 * static_cast<int>(crop * size.height / 2))};
  else
    Z(0, 0) = Z(1, 1) = 1 / crop;
  Z(0, 2) = (shown.width - 1) / 2.0 - Z(0, 0) * (size.width - 1) / 2.0;
  Z(1, 2) = (shown.height - 1) / 2.0 - Z(1, 1) * (size.height - 1) / 2.0;
  return {Z, shown};
}

}  // namespace

Stabiliser::Stabiliser(const StabiliserOptions& options, const std::optional<CameraModel>& camera,
                       double rate_hz)
    : options_(options),
      camera_(camera),
      virtual_(VirtualCamera(camera)),
      turned_(options.by != "vision"),
      reference_(options.mode == "reference"),
      before_(static_cast<int>(std::ceil(rate_hz / options.cutoff_hz))),
      lag_(reference_                  ? 0
           : options.mode == "offline" ? before_
                                       : static_cast<int>(std::lround(options.lag_s * rate_hz))),
      ahead_(options.bound ? static_cast<int>(std::lround(std::min(kAhead_s * rate_hz, kAhead * lag_))) : 0),
      around_(std::min(ahead_ / 2, static_cast<int>(std::lround(kStrength_s * rate_hz / 2)))),
      cutoff_(std::min(0.49, options.cutoff_hz / rate_hz)),
      follower_(options, camera_, virtual_, reference_),
      weights_(reference_ ? 0 : before_, lag_, cutoff_) {
  if (turned_ && !camera_) throw std::invalid_argument("by '" + options.by + "' needs a camera");
  if (options.level && !turned_)
    throw std::invalid_argument("a level view needs a camera's attitude, not 'vision'");
}

Matrix3d Stabiliser::FromDirections(const Quaterniond& R_NV) const {
  if (!turned_) return Matrix3d::Identity();
  return virtual_.K() * R_NV.conjugate().toRotationMatrix();
}

Quaterniond Stabiliser::Level(const Quaterniond& R_NV, const Vector3d& down_N) const {
  const Vector3d z = R_NV * Vector3d::UnitZ(), across = down_N.cross(z);
  if (across.norm() < 0.05) return R_NV;  // straight down or up nothing is level
  Matrix3d R;
  R.col(0) = across.normalized(), R.col(1) = z.cross(R.col(0)), R.col(2) = z;
  return Quaterniond(R);
}

std::optional<StabilisedImage> Stabiliser::Step(const cv::Mat& image, double t_s,
                                                const ImageAttitudes& attitudes) {
  if (turned_ && image.size() != cv::Size(WidthPx(*camera_), HeightPx(*camera_)))
    throw std::invalid_argument("an image of another size than the camera's");
  Image& now = images_.emplace_back();
  now.pixels = image.clone(), now.t_s = t_s, now.number = taken_++;
  now.readout_s = attitudes.readout_s;
  cv::Mat grey = now.pixels;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  now.followed = follower_.Step(grey, t_s, attitudes);
  if (reference_) {
    AnchorIfLost(now);
    planned_ = now.number + 1;
  } else {
    MakePlans(now.number);
  }
  if (shown_ + lag_ >= taken_) return std::nullopt;
  return Show(At(shown_));
}

std::optional<StabilisedImage> Stabiliser::Finish() {
  if (shown_ == taken_) return std::nullopt;
  // All images have come, by which those that are left are planned for good.
  if (!reference_ && !finishing_)
    for (std::int64_t i = shown_; i < taken_; ++i) MakePlan(At(i), taken_ - 1);
  finishing_ = true, planned_ = taken_;
  return Show(At(shown_));
}

// Of the image that is due, and, since a bound is to be foreseen, of later ones by the images that have come: again and
// again as these grow more.
void Stabiliser::MakePlans(std::int64_t newest) {
  const std::int64_t due = newest - lag_;
  if (due < 0) return;
  for (const double share : {1.0, 0.5, 0.2}) {
    const std::int64_t last = due + std::lround(share * ahead_);
    for (std::int64_t i = due == 0 ? 0 : last; i <= last; ++i) MakePlan(At(i), newest);
    planned_ = std::max(planned_, last + 1);
    if (due == 0 || ahead_ == 0) break;
  }
  MakePlan(At(due), newest);
}

// Where what is shown of an image lies in a smooth path: the mean of where it is seen in the images around it, each of
// which counts as PathWeights says. No path is kept as numbers that would grow with all that the camera has passed.
void Stabiliser::MakePlan(Image& image, std::int64_t newest) {
  const std::int64_t oldest = std::max(images_.front().number, image.number - before_);
  int before = 0, after = 0;
  const auto at = [&](int offset) -> const FollowedImage& { return At(image.number + offset).followed; };
  while (image.number - before > oldest && !at(-before).begins) ++before;
  while (after < lag_ && image.number + after < newest && !at(after + 1).begins) ++after;
  Plan& plan = image.plan.emplace();
  const FollowedImage& here = image.followed;
  const auto [Z, shown] =
      Shown(turned_ ? cv::Size(virtual_.width_px, virtual_.height_px) : image.pixels.size(), options_.crop,
            options_.scale);
  const Matrix3d Z_back = Z.inverse();
  const double w = shown.width - 1, h = shown.height - 1;
  for (const Vector2d& corner : {Vector2d(0, 0), Vector2d(w, 0), Vector2d(w, h), Vector2d(0, h)})
    plan.corners.push_back({Transfer(Z_back, corner), {}});

  // The rotation, and with it where it points to.
  Quaterniond R_NV = here.R_NC;
  if (turned_) {
    const Eigen::VectorXd& weights = weights_.Of(before, after);
    // "Down" goes its smooth way too, since N turns slowly by what its rotations err; where much of it was not seen
    // the weights that are left mean nothing, and all of it counts alike.
    Vector3d down_N = Vector3d::Zero(), mean_N = Vector3d::Zero();
    double weight = 0;
    for (int k = -before; k <= after; ++k) {
      plan.turn += weights(before + k) * LogRotation(here.R_NC.conjugate() * at(k).R_NC);
      if (!at(k).down_N) continue;
      down_N += weights(before + k) * *at(k).down_N, weight += weights(before + k), mean_N += *at(k).down_N;
    }
    if (weight < 0.8) down_N = mean_N;
    R_NV = here.R_NC * ExpRotation(plan.turn);
    if (options_.level && down_N.norm() > 1e-6) {
      R_NV = Level(R_NV, down_N.normalized());
      plan.turn = LogRotation(here.R_NC.conjugate() * R_NV);
    }
  }
  if (image.readout_s != 0) plan.row_warps = RowWarpsOf(image, before, after);
  // Where the corners are in the images before and after, as far as they stay in sight of one another.
  const Matrix3d M = FromDirections(R_NV), M_back = M.inverse();
  const double far = 4.0 * (shown.width + shown.height);
  std::vector<Vector2d> seen;  // the corners, by the rows that saw them
  ImageView rows;
  rows.rows = image.pixels.rows;
  if (!turned_) rows.row_warps = plan.row_warps;
  for (const PointPair& corner : plan.corners)
    seen.push_back(SourceOf(rows, nullptr, corner.from).value_or(corner.from));
  std::map<int, std::vector<Vector2d>> places;
  const auto place = [&](int k, const Matrix3d& G) {
    const Matrix3d H = M * G * M_back;
    std::vector<Vector2d>& of = places[k];
    for (std::size_t c = 0; c < plan.corners.size(); ++c) {
      const PointPair& corner = plan.corners[c];
      const Vector3d p = H * seen[c].homogeneous();
      if (!(p.z() > 0.1) || !(p.hnormalized() - corner.from).allFinite() ||
          (p.hnormalized() - corner.from).norm() > far)
        return false;
      of.push_back(p.hnormalized());
    }
    return true;
  };
  place(0, Matrix3d::Identity());
  int seen_before = 0, seen_after = 0;
  Matrix3d G = Matrix3d::Identity();
  for (; seen_before < before; ++seen_before) {
    G = at(-seen_before).G.inverse() * G;
    G /= G(2, 2);
    if (!place(-seen_before - 1, G)) break;
  }
  G = Matrix3d::Identity();
  for (; seen_after < after; ++seen_after) {
    G = at(seen_after + 1).G * G;
    G /= G(2, 2);
    if (!place(seen_after + 1, G)) break;
  }
  const Eigen::VectorXd& weights = weights_.Of(seen_before, seen_after);
  for (std::size_t c = 0; c < plan.corners.size(); ++c) {
    plan.corners[c].to.setZero();
    for (int k = -seen_before; k <= seen_after; ++k)
      plan.corners[c].to += weights(seen_before + k) * places[k][c];
  }
  if (options_.bound) Bound(image);
}

std::vector<Matrix3d> Stabiliser::RowWarpsOf(const Image& image, int before, int after) {
  const auto at = [&](int offset) -> const Image& { return At(image.number + offset); };
  if (turned_) {  // rows have their attitudes; what else moves goes on evenly from the image before to that after
    Matrix3d later = Matrix3d::Identity(), earlier = Matrix3d::Identity();
    double between_s = 0;
    if (after > 0) later = at(1).followed.G, between_s += at(1).t_s - image.t_s;
    if (before > 0) earlier = image.followed.G.inverse(), between_s += image.t_s - at(-1).t_s;
    if (!(between_s > 0)) return {};
    const Matrix3d drift = (later / later(2, 2) - earlier / earlier(2, 2)) * image.readout_s / between_s;
    return {Matrix3d::Identity() - drift / 2, Matrix3d::Identity() + drift / 2};
  }
  constexpr int kSide = 6;
  const int side = std::min({before, after, kSide});
  if (side == 0) return {};
  std::vector<Matrix3d> to(static_cast<std::size_t>(2 * side + 1), Matrix3d::Identity());
  for (int k = 1; k <= side; ++k) {
    const auto later = static_cast<std::size_t>(side + k), earlier = static_cast<std::size_t>(side - k);
    to[later] = at(k).followed.G * to[later - 1];
    to[earlier] = at(1 - k).followed.G.inverse() * to[earlier + 1];
  }
  return RowWarps(to, image.readout_s * 2 * side / (at(side).t_s - at(-side).t_s));
}

// By how much a view may be shifted as it is, and what strength it needs where no shift is enough.
void Stabiliser::Bound(Image& image) {
  Plan& plan = *image.plan;
  const ImageView view = ViewOf(image, 1, {0, 0});
  const Vector2d rim(kRim_px, kRim_px), end(image.pixels.cols - 1, image.pixels.rows - 1);
  Vector2d least = end, greatest(0, 0);
  for (int y = 0; y <= kGridSteps; ++y) {
    for (int x = 0; x <= kGridSteps; ++x) {
      const auto at =
          SourceOf(view, camera_ ? &*camera_ : nullptr,
                   {x * (view.size.width - 1.0) / kGridSteps, y * (view.size.height - 1.0) / kGridSteps});
      if (at) least = least.cwiseMin(*at), greatest = greatest.cwiseMax(*at);
    }
  }
  plan.lower = greatest - (end - rim), plan.upper = least - rim;
  const Vector2d middle = (plan.lower + plan.upper) / 2;
  plan.lower = plan.lower.cwiseMin(middle), plan.upper = plan.upper.cwiseMax(middle);
  plan.most = MostStrength(image, 1, Vector2d::Zero().cwiseMax(plan.lower).cwiseMin(plan.upper));
}

// The greatest share of the strength and the shift with which the view stays within the image.
double Stabiliser::MostStrength(const Image& image, double strength, const Vector2d& shift) const {
  const auto inside = [&](double share) {
    return ShareInside(ViewOf(image, share * strength, share * shift), image.pixels.size(), kGridSteps) == 1;
  };
  if (inside(1)) return 1;
  constexpr int kHalvings = 8;
  double low = 0, high = 1;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (inside(middle) ? low : high) = middle;
  }
  return low;
}

// The smoothest way of the view within its bounds, as far as they are foreseen.
Vector2d Stabiliser::Shift(const Image& image) {
  if (image.followed.begins) last_shifts_ = {Vector2d::Zero(), Vector2d::Zero()};
  int n = 1;
  while (n <= ahead_ && image.number + n < planned_ && !At(image.number + n).followed.begins) ++n;
  Vector2d shift;
  for (int d = 0; d < 2; ++d) {
    Eigen::VectorXd lower(n), upper(n);
    for (int i = 0; i < n; ++i) {
      const Plan& plan = *At(image.number + i).plan;
      lower(i) = plan.lower(d), upper(i) = plan.upper(d);
    }
    shift(d) = BoundedPath(lower, upper, {last_shifts_[0](d), last_shifts_[1](d)}, cutoff_)(0);
  }
  last_shifts_ = {last_shifts_[1], shift};
  return shift;
}

// The mean, over the images around, of the least that is around each of them: it never exceeds the image's own, and
// changes slowly.
double Stabiliser::Strength(const Image& image) {
  const auto most = [&](std::int64_t number) {
    return At(std::clamp(number, images_.front().number, planned_ - 1)).plan->most;
  };
  const std::int64_t from = image.number;
  double sum = 0;
  for (std::int64_t i = from - around_; i <= from + around_; ++i) {
    double least = image.plan->most;
    for (std::int64_t k = i - around_; k <= i + around_; ++k) least = std::min(least, most(k));
    sum += least;
  }
  return sum / (2 * around_ + 1);
}

ImageView Stabiliser::ViewOf(const Image& image, double strength, const Vector2d& shift) const {
  const FollowedImage& followed = image.followed;
  const auto [Z, shown] =
      Shown(turned_ ? cv::Size(virtual_.width_px, virtual_.height_px) : image.pixels.size(), options_.crop,
            options_.scale);
  ImageView view;
  view.rows = image.pixels.rows;
  view.size = shown, view.turned = turned_, view.virtual_camera = virtual_,
  view.R_NC_rows = followed.R_NC_rows;
  if (reference_) {
    view.R_NV = R_NC_reference_;
    const Matrix3d M = FromDirections(view.R_NV);
    view.H = Z * M * G_to_reference_ * M.inverse();
  } else {
    view.R_NV = followed.R_NC * ExpRotation(strength * image.plan->turn);
    std::vector<PointPair> corners = image.plan->corners;
    for (PointPair& corner : corners) corner.to = corner.from + strength * (corner.to - corner.from) + shift;
    view.H = Z * FitHomography(corners).value_or(Matrix3d::Identity());
    const Matrix3d M = FromDirections(view.R_NV);
    for (const Matrix3d& warp : image.plan->row_warps) view.row_warps.push_back(M * warp * M.inverse());
  }
  view.H /= view.H(2, 2);
  return view;
}

// Of an even grid over the view.
double Stabiliser::ShareInside(const ImageView& view, const cv::Size& size, int steps) const {
  constexpr double kRounding_px = 0.01;  // what rounding may do
  int inside = 0;
  for (int y = 0; y <= steps; ++y) {
    for (int x = 0; x <= steps; ++x) {
      const auto at = SourceOf(view, camera_ ? &*camera_ : nullptr,
                               {x * (view.size.width - 1.0) / steps, y * (view.size.height - 1.0) / steps});
      inside += at && at->x() > -kRounding_px && at->y() > -kRounding_px &&
                at->x() < size.width - 1 + kRounding_px && at->y() < size.height - 1 + kRounding_px;
    }
  }
  return static_cast<double>(inside) / ((steps + 1) * (steps + 1));
}

void Stabiliser::AnchorIfLost(Image& now) {
  G_to_reference_ = G_to_reference_ * now.followed.G.inverse();
  const bool begins = now.followed.begins;
  constexpr int kFine = 9;
  const bool lost = !begins && ShareInside(ViewOf(now, 1, {0, 0}), now.pixels.size(), kFine) < kAnchored;
  if (lost) now.followed.state = StabilisedState::kReanchored, follower_.Anchor();
  if (!lost && !begins) return;
  G_to_reference_.setIdentity(), R_NC_reference_ = now.followed.R_NC;
  if (options_.level && now.followed.down_N) R_NC_reference_ = Level(R_NC_reference_, *now.followed.down_N);
}

void Stabiliser::DrawBorder(const Image& image, const cv::Mat& shown, StabilisedImage& result) {
  const CameraModel* camera = camera_ ? &*camera_ : nullptr;
  const bool whole = cv::countNonZero(shown) == static_cast<int>(shown.total());
  if (options_.border == "blurred" && !whole) {
    cv::Mat beyond = DrawViewBeyond(result.view, camera, image.pixels);
    const int side = std::max(3, shown.cols / 16) | 1;
    cv::blur(beyond, beyond, {side, side});
    result.image.copyTo(beyond, shown);
    result.image = beyond;
  }
  if (options_.border != "filled") return;
  // What was shown of earlier images goes along with the scene.
  const Matrix3d H = result.view.H * FromDirections(result.view.R_NV);
  cv::Mat filled = result.image, known = shown.clone();
  if (!earlier_.empty() && !image.followed.begins && earlier_.size() == filled.size()) {
    cv::Mat map;
    cv::eigen2cv(Matrix3d(H * image.followed.G * earlier_H_.inverse()), map);
    cv::Mat moved, moved_known;
    cv::warpPerspective(earlier_, moved, map, filled.size(), cv::INTER_LINEAR);
    cv::warpPerspective(earlier_known_, moved_known, map, filled.size(), cv::INTER_LINEAR);
    moved_known = moved_known == 255;
    known |= moved_known;
    if (!whole) moved.copyTo(filled, moved_known & ~shown);
  }
  earlier_ = filled.clone(), earlier_known_ = known, earlier_H_ = H;
}

StabilisedImage Stabiliser::Show(Image& image) {
  StabilisedImage result;
  const FollowedImage& followed = image.followed;
  result.t_s = image.t_s, result.number = image.number, result.state = followed.state;
  result.points = followed.points, result.inliers = followed.inliers, result.rms_px = followed.rms_px;
  Vector2d shift(0, 0);
  if (!reference_ && options_.bound) {
    result.strength = Strength(image), shift = Shift(image);
    const double share = MostStrength(image, result.strength, shift);
    result.strength *= share, shift *= share;
  }
  result.view = ViewOf(image, result.strength, shift);
  cv::Mat shown;
  const bool black = options_.border == "black";
  result.image = DrawView(result.view, camera_ ? &*camera_ : nullptr, image.pixels, black ? nullptr : &shown);
  if (!black) DrawBorder(image, shown, result);
  image.pixels.release();
  ++shown_;
  const int kept = reference_ ? 0 : before_ + 2 * around_ + 1;
  while (!images_.empty() && images_.front().number + kept < shown_) images_.pop_front();
  return result;
}

}  // namespace kestrel::vision
