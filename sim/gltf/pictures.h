// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>

namespace kestrel::sim::gltf {

// A texture of the model as CV_8UC3, blue first, of at most so many texels to a side: rows as MuJoCo has them, the first at
// t = 0. A cube is its six faces below each other, in OpenGL's order.
cv::Mat PictureOf(const mjModel* model, int texture, int most_texels);

// Where a direction lies in the picture of a cube; face: 0 to 5, or -1: that to which the direction points.
Eigen::Vector2f PlaceInCube(const Eigen::Vector3f& direction, int face = -1);
int FaceOf(const Eigen::Vector3f& direction);

// The model's sky all round as data URL of a small JPEG, of twice as many columns as rows: columns are azimuth from
// south by west, north and east to south, rows are elevation from the zenith to the nadir. Empty: it has none.
std::string SkyUrl(const mjModel* model);

}  // namespace kestrel::sim::gltf
