// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/free_body.h"

#include <memory>
#include <stdexcept>
#include <string>

#include "sim/world/frames.h"

namespace kestrel::sim {

FreeBody::FreeBody(double mass_kg, const Eigen::Vector3d& inertia_kg_m2, mjModel* model, const char* name)
    : body_(mj_name2id(model, mjOBJ_BODY, name)) {
  if (body_ < 0) throw std::invalid_argument("the model has no body named " + std::string(name));
  const int joint = model->body_jntadr[body_];
  if (joint < 0 || model->jnt_type[joint] != mjJNT_FREE) {
    throw std::invalid_argument("the body " + std::string(name) + " has no free joint");
  }
  position_ = model->jnt_qposadr[joint];
  velocity_ = model->jnt_dofadr[joint];

  model->body_mass[body_] = mass_kg;
  mju_copy3(model->body_inertia + 3 * body_, inertia_kg_m2.data());
  mju_zero3(model->body_ipos + 3 * body_);
  mju_unit4(model->body_iquat + 4 * body_);

  // mj_setConst brings what is derived from mass and inertia up to date. It also measures the model afresh,
  // over what the file says of its extent and centre, which the near and far planes of every camera depend
  // on.
  const mjStatistic file = model->stat;
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(model), mj_deleteData);
  mj_setConst(model, data.get());
  model->stat.extent = file.extent;
  model->stat.meansize = file.meansize;
  mju_copy3(model->stat.center, file.center);
}

Pose FreeBody::X_NB(const mjData* data) const { return PoseFromMujoco(data->qpos + position_); }
Eigen::Vector3d FreeBody::v_N(const mjData* data) const { return VectorFromMujoco(data->qvel + velocity_); }
Eigen::Vector3d FreeBody::w_B(const mjData* data) const {
  return VectorFromMujoco(data->qvel + velocity_ + 3);
}

void FreeBody::Push(const Wrench& wrench, mjData* data) const {
  const Pose X = X_NB(data);
  mjtNum* const applied = data->xfrc_applied + 6 * body_;  // force, then torque, at the centre of mass, in M
  VectorToMujoco(X.R * wrench.force, applied);
  VectorToMujoco(X.R * wrench.torque, applied + 3);
}

}  // namespace kestrel::sim
