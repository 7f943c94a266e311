// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/mesh/triangles.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <utility>

namespace kestrel::sim::ray {
namespace {

Eigen::Vector3f Normal(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  return (b - a).cross(c - a).normalized();
}

}  // namespace

// MuJoCo draws a mesh with the normals of its vertices, but where it has no texture coordinates and a
// corner's normal is more than acos(0.8) away from the triangle's, with the triangle's.
Triangles Triangles::OfMesh(const mjModel* m, int mesh) {
  Triangles t;
  const int first = m->mesh_vertadr[mesh], st_first = m->mesh_texcoordadr[mesh];
  t.has_st = st_first >= 0;
  for (int v = 0; v < m->mesh_vertnum[mesh]; ++v)
    t.vertices.emplace_back(Eigen::Map<const Eigen::Vector3f>(m->mesh_vert + 3 * (first + v)));
  for (int f = m->mesh_faceadr[mesh]; f < m->mesh_faceadr[mesh] + m->mesh_facenum[mesh]; ++f) {
    const Eigen::Map<const Eigen::Vector3i> face(m->mesh_face + 3 * f);
    t.faces.emplace_back(face);
    const Eigen::Vector3f flat = Normal(t.vertices[face[0]], t.vertices[face[1]], t.vertices[face[2]]);
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3f normal = Eigen::Map<const Eigen::Vector3f>(m->mesh_normal + 3 * (first + face[k]));
      if (!t.has_st && !(normal.dot(flat) >= 0.8f)) normal = flat;
      Eigen::Vector2f st = Eigen::Vector2f::Zero();
      if (t.has_st) st = Eigen::Map<const Eigen::Vector2f>(m->mesh_texcoord + 2 * (st_first + face[k]));
      t.corners.push_back({normal, st});
    }
  }
  t.Finish();
  return t;
}

// The grid's two triangles a cell, as MuJoCo cuts it, with walls and a bottom.
Triangles Triangles::OfHeightField(const mjModel* m, int field) {
  Triangles t;
  const int rows = m->hfield_nrow[field], columns = m->hfield_ncol[field];
  const mjtNum* size = m->hfield_size + 4 * field;
  const float* data = m->hfield_data + m->hfield_adr[field];
  const auto corner = [&](int r, int c, bool top) {
    return Eigen::Vector3f(static_cast<float>(size[0] * (2.0 * c / (columns - 1) - 1)),
                           static_cast<float>(size[1] * (2.0 * r / (rows - 1) - 1)),
                           static_cast<float>(top ? data[r * columns + c] * size[2] : -size[3]));
  };
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) t.vertices.push_back(corner(r, c, true));
  const auto top = [&](int r, int c) { return r * columns + c; };
  for (int r = 0; r + 1 < rows; ++r) {
    for (int c = 0; c + 1 < columns; ++c) {
      t.faces.emplace_back(top(r + 1, c), top(r, c), top(r + 1, c + 1));
      t.faces.emplace_back(top(r, c), top(r, c + 1), top(r + 1, c + 1));
    }
  }
  // A wall under each edge of the rim, walked round with the field on the left, seen from above.
  std::vector<std::pair<int, int>> rim;
  for (int c = 0; c + 1 < columns; ++c) rim.emplace_back(0, c);
  for (int r = 0; r + 1 < rows; ++r) rim.emplace_back(r, columns - 1);
  for (int c = columns - 1; c > 0; --c) rim.emplace_back(rows - 1, c);
  for (int r = rows - 1; r > 0; --r) rim.emplace_back(r, 0);
  const int below = static_cast<int>(t.vertices.size());
  for (const auto& [r, c] : rim) t.vertices.push_back(corner(r, c, false));
  const int n = static_cast<int>(rim.size());
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    const int a = top(rim[i].first, rim[i].second), b = top(rim[j].first, rim[j].second);
    t.faces.emplace_back(below + i, below + j, b);
    t.faces.emplace_back(below + i, b, a);
  }
  const int bottom = static_cast<int>(t.vertices.size());
  for (const auto& [r, c] :
       {std::pair{0, 0}, std::pair{rows - 1, 0}, std::pair{rows - 1, columns - 1}, std::pair{0, columns - 1}})
    t.vertices.push_back(corner(r, c, false));
  t.faces.emplace_back(bottom, bottom + 1, bottom + 2);
  t.faces.emplace_back(bottom, bottom + 2, bottom + 3);
  for (const Eigen::Vector3i& f : t.faces) {
    const Eigen::Vector3f flat = Normal(t.vertices[f[0]], t.vertices[f[1]], t.vertices[f[2]]);
    for (int k = 0; k < 3; ++k) t.corners.push_back({flat, Eigen::Vector2f::Zero()});
  }
  t.Finish();
  return t;
}

void Triangles::Divide(std::vector<int>::iterator begin, std::vector<int>::iterator end) {
  constexpr std::ptrdiff_t kLeast = 256;  // faces of a part
  const auto middle_of = [&](int f) -> Eigen::Vector3f {
    return (vertices[faces[f][0]] + vertices[faces[f][1]] + vertices[faces[f][2]]) / 3;
  };
  Eigen::AlignedBox3f box, middles;
  for (auto f = begin; f != end; ++f) {
    for (int k = 0; k < 3; ++k) box.extend(vertices[faces[*f][k]]);
    middles.extend(middle_of(*f));
  }
  const std::size_t own = parts.size();
  // Somewhat larger, for what rounding does.
  parts.push_back({box.center(), 0.5001f * box.sizes() + Eigen::Vector3f::Constant(1e-4f), 0});
  if (end - begin > 2 * kLeast) {
    Eigen::Index axis;
    middles.sizes().maxCoeff(&axis);
    const auto half = begin + (end - begin) / 2;
    std::nth_element(begin, half, end, [&](int a, int b) {
      const float at_a = middle_of(a)[axis], at_b = middle_of(b)[axis];
      return at_a != at_b ? at_a < at_b : a < b;
    });
    Divide(begin, half);
    Divide(half, end);
  }
  parts[own].next = parts.size();
}

void Triangles::Finish() {
  low = high = vertices.empty() ? Eigen::Vector3f::Zero().eval() : vertices.front();
  for (const Eigen::Vector3f& v : vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  std::vector<int> all(faces.size());
  std::iota(all.begin(), all.end(), 0);
  Divide(all.begin(), all.end());
  if (has_st) {
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const Eigen::Vector3f a = vertices[faces[f][1]] - vertices[faces[f][0]];
      const Eigen::Vector3f b = vertices[faces[f][2]] - vertices[faces[f][0]];
      Eigen::Matrix3f edges;
      edges << a, b, a.cross(b);
      Eigen::Matrix<float, 2, 3> change;
      change << corners[3 * f + 1].st - corners[3 * f].st, corners[3 * f + 2].st - corners[3 * f].st,
          Eigen::Vector2f::Zero();
      const Eigen::Matrix<float, 2, 3> gradient = change * edges.inverse();
      st_gradient.push_back(gradient.allFinite() ? gradient : Eigen::Matrix<float, 2, 3>::Zero().eval());
    }
  }
  if (!corners.empty() && std::all_of(corners.begin(), corners.end(),
                                      [&](const Corner& c) { return c.normal == corners.front().normal; }))
    one_normal = corners.front().normal;
  plain_facets = has_st && one_normal;
  for (std::size_t f = 0; f < faces.size() && plain_facets; ++f)
    plain_facets = corners[3 * f].st == corners[3 * f + 1].st && corners[3 * f].st == corners[3 * f + 2].st;
  blocks = MakeBlocks(vertices, faces);
}

void Triangles::MakeTree(const std::string& instruction_set) {
  if (!tree_) tree_.emplace(vertices, faces, instruction_set);
}

}  // namespace kestrel::sim::ray
