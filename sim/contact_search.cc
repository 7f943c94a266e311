// SPDX-License-Identifier: Apache-2.0
#include "sim/contact_search.h"

#include <algorithm>

namespace kestrel::sim {
namespace {

constexpr double kRoom_m = 0.5;  // far more than a step moves

bool MayTouchAnything(const mjModel* m, int geom) {
  return m->geom_contype[geom] != 0 || m->geom_conaffinity[geom] != 0;
}

}  // namespace

ContactSearch::ContactSearch(const mjModel* model, const mjData* data) {
  const int vehicle = mj_name2id(model, mjOBJ_BODY, "vehicle");
  const int joint = vehicle < 0 ? -1 : model->body_jntadr[vehicle];
  as_it_is_ = joint < 0 || model->jnt_type[joint] != mjJNT_FREE || model->npair > 0 ||
              (model->opt.enableflags & mjENBL_OVERRIDE) != 0 ||
              (model->opt.disableflags & mjDSBL_CONTACT) != 0;
  if (as_it_is_) return;
  place_ = model->jnt_qposadr[joint];
  for (int g = 0; g < model->ngeom; ++g) {
    if (!MayTouchAnything(model, g)) continue;
    const int body = model->geom_bodyid[g], moves_with = model->body_weldid[body];
    const bool is_carried = model->body_mocapid[model->body_rootid[body]] >= 0;
    const Eigen::Map<const Eigen::Vector3d> at(data->geom_xpos + 3 * g);
    const double reach = model->geom_rbound[g] + model->geom_margin[g];
    if (moves_with == vehicle) {
      const Eigen::Map<const Eigen::Vector3d> origin(data->xpos + 3 * vehicle);
      radius_ = std::max(radius_, (at - origin).norm() + reach);
    } else if (moves_with != 0 || is_carried) {
      as_it_is_ = true;
    } else if (model->geom_type[g] == mjGEOM_PLANE) {
      const mjtNum* const R = data->geom_xmat + 9 * g;
      planes_.push_back({at + reach * Eigen::Vector3d(R[2], R[5], R[8]), {R[2], R[5], R[8]}});
    } else {
      balls_.push_back({at, reach});
    }
  }
  radius_ += kRoom_m;
}

bool ContactSearch::MayTouch(const Eigen::Vector3d& vehicle) const {
  return std::any_of(planes_.begin(), planes_.end(),
                     [&](const Plane& p) { return p.normal.dot(vehicle - p.point) <= radius_; }) ||
         std::any_of(balls_.begin(), balls_.end(),
                     [&](const Ball& b) { return (vehicle - b.centre).norm() <= radius_ + b.radius; });
}

void ContactSearch::Set(mjModel* model, const mjData* data) const {
  if (as_it_is_) return;
  const bool search = MayTouch(Eigen::Map<const Eigen::Vector3d>(data->qpos + place_));
  const int bits = model->opt.disableflags;
  const int wanted = search ? bits & ~mjDSBL_CONTACT : bits | mjDSBL_CONTACT;
  if (bits != wanted) model->opt.disableflags = wanted;
}

}  // namespace kestrel::sim
