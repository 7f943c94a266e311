// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace kestrel::sim::gltf {

// Triangles, counterclockwise as seen, with what each vertex has. st: empty, or the place in a picture, whose first
// row is at t = 0.
struct Mesh {
  std::vector<Eigen::Vector3f> positions, normals;
  std::vector<Eigen::Vector2f> st;
  std::vector<Eigen::Vector3i> faces;

  // st of the other are dropped where this has none, unless this is still empty.
  void Append(const Mesh& other, const Eigen::Isometry3d& X);
};

// Shapes as MuJoCo has them: along z, of these half sizes.
Mesh BoxMesh(const Eigen::Vector3f& half);
Mesh EllipsoidMesh(const Eigen::Vector3f& half);
Mesh CylinderMesh(float radius, float half_length);
Mesh CapsuleMesh(float radius, float half_length);
Mesh PlaneMesh(float half_x, float half_y);  // it faces z

// The same in at most about so many triangles: vertices that are close to each other become one, and the farther
// they are from the origin the less close they need to be, as in a picture taken there.
Mesh Simplified(const Mesh& mesh, std::size_t faces);

// Whether each triangle has one place in the picture, that is one colour; and such a mesh with fewer triangles, in
// which each has three vertices of its own.
bool IsPainted(const Mesh& mesh);
Mesh SimplifiedPainted(const Mesh& mesh, std::size_t faces);

}  // namespace kestrel::sim::gltf
