// SPDX-License-Identifier: Apache-2.0
#include "sim/instrument/beam.h"

#include <limits>

#include "sim/world/frames.h"

namespace kestrel::sim {

Beam BeamIn(const mjModel* model, const mjData* data) {
  const int vehicle = mj_name2id(model, mjOBJ_BODY, "vehicle");
  return [model, data, vehicle](const Eigen::Vector3d& p_N, const Eigen::Vector3d& direction_N) {
    constexpr double kBehind_m = 1e-6;  // where the beam goes on behind a part of the aircraft
    constexpr mjtByte kAlsoStatic = 1;
    double along[3];
    VectorToMujoco(direction_N, along);
    for (double passed_m = 0;;) {
      double from[3];
      VectorToMujoco(p_N + passed_m * direction_N, from);
      int geom = -1;
      const double distance_m = mj_ray(model, data, from, along, nullptr, kAlsoStatic, vehicle, &geom);
      if (geom < 0) return std::numeric_limits<double>::infinity();
      passed_m += distance_m;
      if (model->body_rootid[model->geom_bodyid[geom]] != vehicle) return passed_m;
      passed_m += kBehind_m;
    }
  };
}

}  // namespace kestrel::sim
