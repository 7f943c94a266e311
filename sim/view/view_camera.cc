// SPDX-License-Identifier: Apache-2.0
#include "sim/view/view_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/tait_bryan.h"
#include "sim/world/scene.h"

namespace kestrel::sim {
namespace {

constexpr double kFollow_s = 0.25, kTurn_s = 0.9;  // how soon chase is where it wants to be
constexpr double kTurn_deg_s = 14;                 // of orbit
constexpr double kLowest_m = 0.15;                 // above the ground
constexpr double kEye_m = 1.7;                     // a person's
constexpr double kTowerSize = 0.16;                // of the picture's width, the aircraft by tower
constexpr double kTightest_deg = 3;
constexpr double kFarPad_m = 30;
const Eigen::Vector3d kUp(0, 0, -1);

// Looks from one place at another; up: what is up in the picture, which may not lie along that.
Pose LookAt(const Eigen::Vector3d& from, const Eigen::Vector3d& at, const Eigen::Vector3d& up = kUp) {
  Eigen::Matrix3d R;
  R.col(2) = (at - from).normalized();
  R.col(0) = R.col(2).cross(up).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return {Eigen::Quaterniond(R), from};
}

Eigen::Vector3d PlaceOf(const ViewPlace& p) { return {p.north_m, p.east_m, -p.height_m}; }

// Level, unit: by the nose, and by the belly of an aircraft that stands on its tail.
Eigen::Vector2d HeadingOf(const Eigen::Quaterniond& R_NB) {
  const Eigen::Vector2d nose = (R_NB * Eigen::Vector3d::UnitX()).head<2>();
  if (nose.norm() > 0.05) return nose.normalized();
  return (R_NB * Eigen::Vector3d::UnitZ()).head<2>().normalized();
}

}  // namespace

double AircraftRadius_m(const mjModel* model) {
  const DataPtr data = MakeData(model);
  mj_kinematics(model, data.get());
  const int vehicle = mj_name2id(model, mjOBJ_BODY, "vehicle");
  const Eigen::Map<const Eigen::Vector3d> origin(data->xpos + 3 * vehicle);
  double radius = 0.05;
  for (int g = 0; g < model->ngeom; ++g) {
    if (model->body_rootid[model->geom_bodyid[g]] != vehicle || model->geom_group[g] > 2) continue;
    const Eigen::Map<const Eigen::Vector3d> at(data->geom_xpos + 3 * g);
    radius = std::max(radius, (at - origin).norm() + model->geom_rbound[g]);
  }
  return radius;
}

ViewCamera::ViewCamera(const mjModel* model, const ViewParameters& parameters)
    : parameters_(parameters), radius_m_(AircraftRadius_m(model)) {
  distance_m_ = parameters.distance_m;
  if (distance_m_ == 0)
    distance_m_ = radius_m_ * (parameters.kind == "top" ? 12 : parameters.kind == "orbit" ? 6.5 : 7);
}

void ViewCamera::Follow(const Truth& truth) {
  const Eigen::Vector2d heading = HeadingOf(truth.X_NB.R);
  if (!followed_) {
    begin_s_ = truth.t_s;
    followed_ = {truth.t_s, truth.X_NB.p, heading};
    if (parameters_.position) {
      tower_ = PlaceOf(*parameters_.position);
    } else {
      // To the left of and behind what lies before the nose, from where both the start and the pad are in view; of a
      // pad that is far away, the start.
      const Eigen::Vector3d off = truth.X_NB.p - truth.X_NT.p;
      const bool by_pad = off.head<2>().norm() < kFarPad_m;
      const double room =
          by_pad ? std::clamp(0.9 * off.norm() + 5 * radius_m_, 14 * radius_m_, 25.0) : 14 * radius_m_;
      const Eigen::Vector2d beside = 0.8 * Eigen::Vector2d(heading.y(), -heading.x()) - 0.6 * heading;
      tower_ << (by_pad ? truth.X_NT.p : truth.X_NB.p).head<2>() + room * beside,
          (by_pad ? std::min(0.0, truth.X_NT.p.z()) : 0.0) - kEye_m;
    }
  }
  const double dt = truth.t_s - followed_->t_s;
  const auto share = [&](double time_s) { return 1 - std::exp(-dt / time_s); };
  followed_->t_s = truth.t_s;
  followed_->p += share(kFollow_s) * (truth.X_NB.p - followed_->p);
  const double turn = std::atan2(followed_->ahead.x() * heading.y() - followed_->ahead.y() * heading.x(),
                                 followed_->ahead.dot(heading));
  followed_->ahead = Eigen::Rotation2Dd(share(kTurn_s) * turn) * followed_->ahead;
}

ViewAim ViewCamera::At(const Truth& truth) {
  Follow(truth);
  const Eigen::Vector3d& p = truth.X_NB.p;
  const double fov = Radians(parameters_.fov_deg);
  const auto above_ground = [](Eigen::Vector3d place) {
    place.z() = std::min(place.z(), -kLowest_m);
    return place;
  };
  if (parameters_.kind == "chase") {
    const Eigen::Vector3d ahead(followed_->ahead.x(), followed_->ahead.y(), 0);
    const Eigen::Vector3d from = followed_->p + distance_m_ * (0.36 * kUp - 0.93 * ahead);
    return {LookAt(above_ground(from), p), fov};
  }
  if (parameters_.kind == "orbit") {
    const double angle = Radians(kTurn_deg_s) * (truth.t_s - begin_s_) - 2.3;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    return {LookAt(above_ground(p + distance_m_ * (0.94 * out + 0.34 * kUp)), p), fov};
  }
  if (parameters_.kind == "top") return {LookAt(p + distance_m_ * kUp, p, Eigen::Vector3d::UnitX()), fov};
  const Eigen::Vector3d at = parameters_.look_at ? PlaceOf(*parameters_.look_at) : p;
  const Eigen::Vector3d off = at - tower_;
  // Straight up or down, north is up in the picture.
  const Eigen::Vector3d up =
      off.head<2>().norm() > 1e-3 * off.norm() ? kUp : Eigen::Vector3d(Eigen::Vector3d::UnitX());
  ViewAim aim{LookAt(tower_, at, up), fov};
  if (parameters_.kind == "tower")
    aim.fov_rad =
        std::clamp(2 * std::atan(radius_m_ / (kTowerSize * off.norm())), Radians(kTightest_deg), fov);
  return aim;
}

}  // namespace kestrel::sim
