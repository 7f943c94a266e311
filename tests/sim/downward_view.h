// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {

// Every ray within 27.5 degrees of straight down from the vehicle's mount must meet the plane below, not the
// vehicle. The data are after mj_forward.
inline void ExpectFreeDownwardView(const mjModel* model, const mjData* data) {
  const Eigen::Vector3d camera(data->site_xpos + 3 * mj_name2id(model, mjOBJ_SITE, "camera_mount"));
  int rays = 0;
  for (double off_axis = 0; off_axis <= 27.5; off_axis += 0.5) {
    for (double around = 0; around < 360; around += 3, ++rays) {
      const double t = Radians(off_axis), a = Radians(around);
      const double ray[3] = {std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), -std::cos(t)};
      int geom = -1;
      ASSERT_GT(mj_ray(model, data, camera.data(), ray, nullptr, 1, -1, &geom), 0);
      ASSERT_EQ(model->geom_type[geom], mjGEOM_PLANE) << off_axis << ' ' << around;
    }
  }
  EXPECT_EQ(rays, 56 * 120);
}

}  // namespace kestrel::sim
