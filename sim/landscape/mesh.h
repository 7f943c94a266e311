// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace kestrel::sim::landscape {

// Triangles for the compiler of MuJoCo. In M: x north, y west, z up; counterclockwise as seen.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices, normals;
  std::vector<Eigen::Vector2f> st;
  std::vector<Eigen::Vector3i> faces;
};

// As a file of MuJoCo's binary format MSH.
std::string Msh(const Mesh& mesh);

}  // namespace kestrel::sim::landscape
