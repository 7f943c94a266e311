// SPDX-License-Identifier: Apache-2.0
#include "sim/gltf/mesh.h"

#include <cmath>
#include <numbers>

namespace kestrel::sim::gltf {
namespace {

using Eigen::Vector3f;

constexpr float kTurn = 2 * std::numbers::pi_v<float>;
constexpr int kAround = 16, kBands = 8;  // of what is round

int Put(Mesh& mesh, const Vector3f& position, const Vector3f& normal) {
  mesh.positions.push_back(position);
  mesh.normals.push_back(normal);
  return static_cast<int>(mesh.positions.size()) - 1;
}

// Rings of vertices, from +z to -z, as a closed surface.
struct Ring {
  float radius, z, normal_radius, normal_z;
};

Mesh Turned(const std::vector<Ring>& rings) {
  Mesh mesh;
  for (const Ring& ring : rings) {
    for (int j = 0; j <= kAround; ++j) {
      const float a = kTurn * static_cast<float>(j) / kAround, c = std::cos(a), s = std::sin(a);
      Put(mesh, {ring.radius * c, ring.radius * s, ring.z},
          {ring.normal_radius * c, ring.normal_radius * s, ring.normal_z});
    }
  }
  const auto at = [](std::size_t i, int j) { return static_cast<int>(i) * (kAround + 1) + j; };
  for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
    if (rings[i].radius == rings[i + 1].radius && rings[i].z == rings[i + 1].z) continue;  // an edge
    for (int j = 0; j < kAround; ++j) {
      if (rings[i].radius > 0) mesh.faces.emplace_back(at(i, j), at(i + 1, j), at(i, j + 1));
      if (rings[i + 1].radius > 0) mesh.faces.emplace_back(at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
    }
  }
  return mesh;
}

}  // namespace

void Mesh::Append(const Mesh& other, const Eigen::Isometry3d& X) {
  const Eigen::Isometry3f to = X.cast<float>();
  const auto first = static_cast<int>(positions.size());
  for (const Vector3f& p : other.positions) positions.push_back(to * p);
  for (const Vector3f& n : other.normals) normals.push_back(to.linear() * n);
  st.insert(st.end(), other.st.begin(), other.st.end());
  for (const Eigen::Vector3i& face : other.faces) faces.emplace_back(face.array() + first);
}

Mesh BoxMesh(const Vector3f& half) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {1.0f, -1.0f}) {
      const Vector3f normal = side * Vector3f::Unit(axis), u = Vector3f::Unit((axis + 1) % 3),
                     v = normal.cross(u);
      int corner[4];
      for (int k = 0; k < 4; ++k) {
        const Vector3f at = normal + (k == 1 || k == 2 ? 1.0f : -1.0f) * u + (k >= 2 ? 1.0f : -1.0f) * v;
        corner[k] = Put(mesh, half.cwiseProduct(at), normal);
      }
      mesh.faces.emplace_back(corner[0], corner[1], corner[2]);
      mesh.faces.emplace_back(corner[0], corner[2], corner[3]);
    }
  }
  return mesh;
}

Mesh EllipsoidMesh(const Vector3f& half) {
  std::vector<Ring> rings;
  for (int i = 0; i <= kBands; ++i) {
    const float polar = kTurn / 2 * static_cast<float>(i) / kBands;
    const float radius = i == 0 || i == kBands ? 0 : std::sin(polar), z = std::cos(polar);
    rings.push_back({radius, z, radius, z});
  }
  Mesh mesh = Turned(rings);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    mesh.positions[v] = mesh.positions[v].cwiseProduct(half);
    mesh.normals[v] = mesh.normals[v].cwiseQuotient(half).normalized();
  }
  return mesh;
}

Mesh CylinderMesh(float radius, float half_length) {
  return Turned({{0, half_length, 0, 1},
                 {radius, half_length, 0, 1},
                 {radius, half_length, 1, 0},
                 {radius, -half_length, 1, 0},
                 {radius, -half_length, 0, -1},
                 {0, -half_length, 0, -1}});
}

Mesh CapsuleMesh(float radius, float half_length) {
  std::vector<Ring> rings;
  for (const float end : {1.0f, -1.0f}) {
    for (int i = 0; i <= kBands / 2; ++i) {
      const float polar = kTurn / 4 * (static_cast<float>(2 * i) / kBands + (end < 0 ? 1 : 0));
      const bool tip = end > 0 ? i == 0 : i == kBands / 2;
      const float across = tip ? 0 : std::sin(polar), z = std::cos(polar);
      rings.push_back({radius * across, radius * z + end * half_length, across, z});
    }
  }
  return Turned(rings);
}

Mesh PlaneMesh(float half_x, float half_y) {
  Mesh mesh;
  for (const float x : {-half_x, half_x})
    for (const float y : {-half_y, half_y}) Put(mesh, {x, y, 0}, Vector3f::UnitZ());
  mesh.faces = {{0, 2, 1}, {1, 2, 3}};
  return mesh;
}

}  // namespace kestrel::sim::gltf
