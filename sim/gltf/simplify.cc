// SPDX-License-Identifier: Apache-2.0
// By clustering of vertices: J. Rossignac and P. Borrel, Multi-resolution 3D approximations for rendering complex
// scenes, 1993; here with cells that grow with the distance from the origin.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

#include "sim/gltf/mesh.h"

namespace kestrel::sim::gltf {
namespace {

using Eigen::Vector3f;

constexpr float kNear_m = 20;  // within which cells are of one size
constexpr int kMostSteps = 12;
constexpr float kEdgeCosine = 0.3f;  // of the angle between normals

// As seen from the origin.
float Elevation(const Vector3f& p) { return std::atan2(p.z(), p.head<2>().norm()); }

// The cell of each vertex, and how many there are.
struct Cells {
  std::vector<int> of;
  int count = 0;
};

// Numbers things by what they have in common.
class Numbering {
 public:
  int Of(const std::array<int, 5>& key) { return numbers_.try_emplace(key, Size()).first->second; }
  int Size() const { return static_cast<int>(numbers_.size()); }

 private:
  struct Hash {
    std::size_t operator()(const std::array<int, 5>& key) const {
      std::size_t hash = 0;
      for (const int k : key) hash = (hash ^ static_cast<unsigned>(k)) * 0x9e3779b97f4a7c15u;
      return hash ^ hash >> 29;
    }
  };
  std::unordered_map<std::array<int, 5>, int, Hash> numbers_;
};

Cells CellsOf(const Mesh& mesh, float size) {
  Cells cells;
  Numbering numbering;
  for (const Vector3f& p : mesh.positions) {
    const float far = p.norm() / kNear_m;
    const Vector3f q = p / kNear_m * (far > 1e-6f ? std::log1p(far) / far : 1) / size;
    cells.of.push_back(numbering.Of({static_cast<int>(std::floor(q.x())), static_cast<int>(std::floor(q.y())),
                                     static_cast<int>(std::floor(q.z())), 0, 0}));
  }
  cells.count = numbering.Size();
  return cells;
}

// The triangles whose corners lie in three cells, each such three once.
std::vector<std::size_t> Remaining(const Mesh& mesh, const Cells& cells) {
  std::vector<std::size_t> remaining;
  Numbering numbering;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    std::array<int, 3> in;
    for (int k = 0; k < 3; ++k)
      in[static_cast<std::size_t>(k)] = cells.of[static_cast<std::size_t>(mesh.faces[f][k])];
    if (in[0] == in[1] || in[1] == in[2] || in[2] == in[0]) continue;
    std::rotate(in.begin(), std::min_element(in.begin(), in.end()), in.end());
    const int before = numbering.Size();
    if (numbering.Of({in[0], in[1], in[2], 0, 0}) == before) remaining.push_back(f);
  }
  return remaining;
}

struct Kept {
  Cells cells;
  std::vector<std::size_t> faces;
  // Of the vertices in each cell the one seen highest from the origin: the skyline stays.
  std::vector<Vector3f> points;
};

Kept Keep(const Mesh& mesh, std::size_t faces) {
  Kept kept;
  float size = 0.004f;
  for (int step = 0; step < kMostSteps; ++step) {
    kept.cells = CellsOf(mesh, size);
    kept.faces = Remaining(mesh, kept.cells);
    if (kept.faces.size() <= faces) break;
    size *=
        std::clamp(std::sqrt(static_cast<float>(kept.faces.size()) / static_cast<float>(faces)), 1.1f, 4.0f);
  }
  kept.points.resize(static_cast<std::size_t>(kept.cells.count));
  std::vector<float> highest(kept.points.size(), -std::numeric_limits<float>::infinity());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto cell = static_cast<std::size_t>(kept.cells.of[v]);
    const Vector3f& p = mesh.positions[v];
    const float elevation = Elevation(p);
    if (elevation <= highest[cell]) continue;
    highest[cell] = elevation;
    kept.points[cell] = p;
  }
  return kept;
}

}  // namespace

Mesh Simplified(const Mesh& mesh, std::size_t faces) {
  if (mesh.faces.size() <= faces) return mesh;
  const Kept kept = Keep(mesh, faces);
  Mesh simple;
  Numbering numbering;
  std::vector<int> becomes;    // of each vertex
  std::vector<float> highest;  // of each vertex that is made, as of its cell
  std::vector<std::size_t> firsts(kept.points.size(), mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto cell = static_cast<std::size_t>(kept.cells.of[v]);
    const std::size_t first = firsts[cell] = std::min(firsts[cell], v);
    // Across an edge, and across a seam of the picture, each side has a vertex of its own.
    std::array<int, 5> key{kept.cells.of[v], mesh.normals[v].dot(mesh.normals[first]) < kEdgeCosine, 0, 0, 0};
    if (!mesh.st.empty())
      for (int k = 0; k < 2; ++k)
        key[static_cast<std::size_t>(2 + k)] =
            static_cast<int>(std::lround(mesh.st[v][k] - mesh.st[first][k]));
    const int made = numbering.Of(key);
    becomes.push_back(made);
    const auto at = static_cast<std::size_t>(made);
    const float elevation = Elevation(mesh.positions[v]);
    if (at == highest.size()) {
      simple.positions.push_back(kept.points[cell]);
      simple.normals.push_back(Vector3f::Zero());
      if (!mesh.st.empty()) simple.st.push_back(Eigen::Vector2f::Zero());
      highest.push_back(-std::numeric_limits<float>::infinity());
    }
    simple.normals[at] += mesh.normals[v];
    if (elevation <= highest[at]) continue;
    highest[at] = elevation;
    if (!mesh.st.empty()) simple.st[at] = mesh.st[v];
  }
  for (Vector3f& n : simple.normals) n = n.norm() > 1e-6f ? n.normalized() : Vector3f::UnitZ();
  for (const std::size_t f : kept.faces) {
    simple.faces.emplace_back();
    for (int k = 0; k < 3; ++k) simple.faces.back()[k] = becomes[static_cast<std::size_t>(mesh.faces[f][k])];
  }
  return simple;
}

bool IsPainted(const Mesh& mesh) {
  if (mesh.st.empty()) return false;
  for (const Eigen::Vector3i& face : mesh.faces) {
    const auto st = [&](int k) { return mesh.st[static_cast<std::size_t>(face[k])]; };
    if ((st(0) - st(1)).norm() > 1e-6f || (st(0) - st(2)).norm() > 1e-6f) return false;
  }
  return true;
}

Mesh SimplifiedPainted(const Mesh& mesh, std::size_t faces) {
  const Kept kept = Keep(mesh, faces);
  Mesh simple;
  for (const std::size_t f : kept.faces) {
    const auto first = static_cast<int>(simple.positions.size());
    for (const int corner : mesh.faces[f]) {
      const auto v = static_cast<std::size_t>(corner);
      simple.positions.push_back(kept.points[static_cast<std::size_t>(kept.cells.of[v])]);
      simple.normals.push_back(mesh.normals[v]);
      simple.st.push_back(mesh.st[v]);
    }
    simple.faces.emplace_back(first, first + 1, first + 2);
  }
  return simple;
}

}  // namespace kestrel::sim::gltf
