// SPDX-License-Identifier: Apache-2.0
#include "sim/view/view_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/tait_bryan.h"
#include "sim/world/frames.h"

namespace kestrel::sim {
namespace {

constexpr double kFollow_s = 0.25, kTurn_s = 0.9;  // how soon chase is where it wants to be
constexpr double kFirst_rad = -2.3;                // where orbit begins: from behind, to the right
constexpr double kLower = 0.17;      // of the picture's height, the middle below the aircraft by tower
constexpr double kTurn_deg_s = 14;   // of orbit
constexpr double kLowest_m = 0.15;   // above the ground
constexpr double kEye_m = 1.7;       // a person's
constexpr double kTowerSize = 0.16;  // of the picture's width, the aircraft by tower
constexpr double kTightest_deg = 3;
constexpr double kSmallest = 0.09;  // at least, where the horizon would else be in it
constexpr double kFarPad_m = 30, kFarTower_m = 150;
constexpr double kAway_m = 1e6;
constexpr double kRoom = 0.9;  // of the way to what stands in the sight
const Eigen::Vector3d kUp(0, 0, -1);

// Looks from one place at another; up: what is up in the picture. Along that, north is.
Pose LookAt(const Eigen::Vector3d& from, const Eigen::Vector3d& at, const Eigen::Vector3d& up = kUp) {
  Eigen::Matrix3d R;
  R.col(2) = (at - from).normalized();
  Eigen::Vector3d right = R.col(2).cross(up);
  if (right.norm() < 1e-3) right = R.col(2).cross(Eigen::Vector3d::UnitX().eval());
  R.col(0) = right.normalized();
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
    : model_(model), still_(MakeData(model)), parameters_(parameters), radius_m_(AircraftRadius_m(model)) {
  distance_m_ = parameters.distance_m;
  if (distance_m_ == 0) distance_m_ = radius_m_ * (parameters.kind == "top" ? 12 : 7);
  for (int j = 0; j < model->njnt; ++j)
    if (model->jnt_type[j] == mjJNT_FREE) still_->qpos[model->jnt_qposadr[j] + 2] = -kAway_m;
  for (int i = 0; i < model->nmocap; ++i) still_->mocap_pos[3 * i + 2] = -kAway_m;
  mj_kinematics(model, still_.get());
}

Eigen::Vector3d ViewCamera::InSight(const Eigen::Vector3d& place, const Eigen::Vector3d& aircraft) const {
  const Eigen::Vector3d from = SwapNedNwu(aircraft), off = SwapNedNwu(place) - from;
  const mjtByte seen[mjNGROUP] = {1, 1, 1};
  int geom = -1;
  const double share = mj_ray(model_, still_.get(), from.data(), off.data(), seen, 1, -1, &geom);
  return share < 0 || share > 1 / kRoom ? place : aircraft + kRoom * share * (place - aircraft);
}

void ViewCamera::Begin(const Truth& truth) {
  begin_s_ = truth.t_s;
  const Eigen::Vector2d heading = HeadingOf(truth.X_NB.R);
  followed_ = {truth.t_s, truth.X_NB.p, heading};
  if (parameters_.position) {
    tower_ = PlaceOf(*parameters_.position);
    return;
  }
  // To the left of and behind what lies before the nose, from where both the start and the pad are in view; of a pad
  // that is far away, the start. As far away as one looks up at a slope that does not hurt.
  const Eigen::Vector3d off = truth.X_NB.p - truth.X_NT.p;
  const bool by_pad = off.head<2>().norm() < kFarPad_m;
  const double height_m = by_pad ? -off.z() : -truth.X_NB.p.z();
  const double room = std::clamp(off.head<2>().norm() * by_pad + 2.2 * height_m, 14 * radius_m_, kFarTower_m);
  const Eigen::Vector2d beside = 0.8 * Eigen::Vector2d(heading.y(), -heading.x()) - 0.6 * heading;
  tower_ << (by_pad ? truth.X_NT.p : truth.X_NB.p).head<2>() + room * beside,
      (by_pad ? std::min(0.0, truth.X_NT.p.z()) : 0.0) - kEye_m;
  tower_ = InSight(tower_, truth.X_NB.p);
}

void ViewCamera::Follow(const Truth& truth) {
  if (!followed_) Begin(truth);
  const Eigen::Vector2d heading = HeadingOf(truth.X_NB.R);
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
  const auto watch = [&](const Eigen::Vector3d& place, double rise) {
    return ViewAim{LookAt(InSight(above_ground(place), p), p + rise * distance_m_ * kUp), fov};
  };
  if (parameters_.kind == "chase") {
    const Eigen::Vector3d ahead(followed_->ahead.x(), followed_->ahead.y(), 0);
    return watch(followed_->p + distance_m_ * (0.29 * kUp - 0.957 * ahead), 0.07);
  }
  if (parameters_.kind == "orbit") {
    const double angle = Radians(kTurn_deg_s) * (truth.t_s - begin_s_) + kFirst_rad;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    return watch(p + distance_m_ * (0.94 * out + 0.34 * kUp), 0.03);
  }
  if (parameters_.kind == "top") return {LookAt(p + distance_m_ * kUp, p, Eigen::Vector3d::UnitX()), fov};
  if (parameters_.kind == "tower") return FromTower(p);
  return {LookAt(tower_, parameters_.look_at ? PlaceOf(*parameters_.look_at) : p), fov};
}

ViewAim ViewCamera::FromTower(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d off = p - tower_;
  const auto field = [&](double size) { return 2 * std::atan(radius_m_ / (size * off.norm())); };
  // The horizon stays in the picture below an aircraft that is in its upper third, while that is large enough.
  const double shape = static_cast<double>(parameters_.height_px) / parameters_.width_px;
  const double elevation = std::atan2(-off.z(), off.head<2>().norm());
  const double with_horizon = 2 * std::atan(std::tan(0.75 * std::clamp(elevation + 0.03, 0.0, 1.2)) / shape);
  const double widest = Radians(parameters_.fov_deg);
  const double fov = std::clamp(std::clamp(with_horizon, field(kTowerSize), field(kSmallest)),
                                Radians(kTightest_deg), widest);
  const Eigen::Vector3d lower = p - off.norm() * std::tan(kLower * fov * shape) * kUp;
  return {LookAt(tower_, lower), fov};
}

}  // namespace kestrel::sim
