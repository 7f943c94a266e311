// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/snapshots.h"

#include <algorithm>
#include <cmath>

#include "sim/world/frames.h"

namespace kestrel::sim {
namespace {

constexpr double kPerPeriod = 8;  // instants in a period of the fastest vibration

mjModel Lean(const mjModel* model) {
  mjModel lean = *model;
  lean.njmax = lean.nconmax = 1;  // contacts and their forces: megabytes
  lean.nstack = 1;
  return lean;
}

}  // namespace

Snapshot SnapshotOf(const mjModel* model, const mjData* data, double t_s) {
  Snapshot m;
  m.t_s = t_s;
  m.qpos.assign(data->qpos, data->qpos + model->nq);
  m.mocap_pos.assign(data->mocap_pos, data->mocap_pos + 3 * model->nmocap);
  m.mocap_quat.assign(data->mocap_quat, data->mocap_quat + 4 * model->nmocap);
  return m;
}

SnapshotInterpolator::SnapshotInterpolator(const mjModel* model, const Pose& X_BC, const Vibration& vibration)
    : model_(model), lean_(Lean(model)), X_BC_(X_BC), vibration_(vibration) {}

std::span<const SceneState> SnapshotInterpolator::Of(const std::vector<Snapshot>& snapshots, double from_s,
                                                     double until_s) {
  states_.clear();
  const auto earlier = [](const Snapshot& m, double t) { return m.t_s < t; };
  auto first = std::lower_bound(snapshots.begin(), snapshots.end(), from_s, earlier);
  auto last = std::lower_bound(first, snapshots.end(), until_s, earlier);
  if (first != snapshots.begin() && (first == snapshots.end() || first->t_s > from_s)) --first;
  if (last == snapshots.end()) --last;
  for (auto m = first; m != last; ++m) {
    const double gap_s = (m + 1)->t_s - m->t_s;
    const int parts =
        vibration_.still()
            ? 1
            : std::max(1, static_cast<int>(std::ceil(kPerPeriod * vibration_.highest_hz() * gap_s)));
    for (int i = 0; i < parts; ++i)
      Add(m->t_s + gap_s * i / parts, *m, *(m + 1), static_cast<double>(i) / parts);
  }
  Add(last->t_s, *last, *last, 0);
  return states_;
}

void SnapshotInterpolator::Add(double t_s, const Snapshot& before, const Snapshot& after, double share) {
  if (data_.size() == states_.size()) data_.push_back(MakeData(&lean_));
  mjData* data = data_[states_.size()].get();
  std::copy(before.qpos.begin(), before.qpos.end(), data->qpos);
  std::copy(before.mocap_pos.begin(), before.mocap_pos.end(), data->mocap_pos);
  std::copy(before.mocap_quat.begin(), before.mocap_quat.end(), data->mocap_quat);
  if (share > 0) {
    mj_differentiatePos(model_, data->qvel, 1, before.qpos.data(), after.qpos.data());
    mj_integratePos(model_, data->qpos, data->qvel, share);
    for (int i = 0; i < 3 * model_->nmocap; ++i)
      data->mocap_pos[i] += share * (after.mocap_pos[i] - before.mocap_pos[i]);
    for (int i = 0; i < model_->nmocap; ++i) {
      mjtNum* q = data->mocap_quat + 4 * i;
      mjtNum turn[3];
      mju_subQuat(turn, after.mocap_quat.data() + 4 * i, q);
      mju_quatIntegrate(q, turn, share);
    }
  }
  mj_kinematics(model_, data);
  mj_camlight(model_, data);
  Pose X_BC = before.X_BC.value_or(X_BC_);
  if (before.X_BC && after.X_BC && share > 0)
    X_BC = {X_BC.R.slerp(share, after.X_BC->R), X_BC.p + share * (after.X_BC->p - X_BC.p)};
  Pose X_NC = before.X_NC.value_or(PoseFromMujoco(data->qpos) * X_BC);
  if (before.X_NC && after.X_NC && share > 0)
    X_NC = {X_NC.R.slerp(share, after.X_NC->R), X_NC.p + share * (after.X_NC->p - X_NC.p)};
  if (!vibration_.still()) X_NC = X_NC * vibration_.At(t_s);
  states_.push_back({t_s, data, X_NC});
}

}  // namespace kestrel::sim
