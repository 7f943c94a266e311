// SPDX-License-Identifier: Apache-2.0
#include "sim/gltf/geom_mesh.h"

#include <algorithm>
#include <cmath>

#include "sim/gltf/pictures.h"

namespace kestrel::sim::gltf {
namespace {

using Eigen::Vector3f;

constexpr float kEndless_m = 1000;  // half of it

Mesh OfMesh(const mjModel* m, int id) {
  Mesh mesh;
  const int first = m->mesh_vertadr[id], st_first = m->mesh_texcoordadr[id];
  for (int v = 0; v < m->mesh_vertnum[id]; ++v) {
    mesh.positions.emplace_back(m->mesh_vert + 3 * (first + v));
    mesh.normals.emplace_back(m->mesh_normal + 3 * (first + v));
    if (st_first >= 0) mesh.st.emplace_back(m->mesh_texcoord + 2 * (st_first + v));
  }
  for (int f = m->mesh_faceadr[id]; f < m->mesh_faceadr[id] + m->mesh_facenum[id]; ++f)
    mesh.faces.emplace_back(m->mesh_face + 3 * f);
  return mesh;
}

// Its upper side.
Mesh OfHeightField(const mjModel* m, int id) {
  Mesh mesh;
  const int rows = m->hfield_nrow[id], columns = m->hfield_ncol[id];
  const mjtNum* size = m->hfield_size + 4 * id;
  const float* heights = m->hfield_data + m->hfield_adr[id];
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      mesh.positions.emplace_back(static_cast<float>(size[0] * (2.0 * c / (columns - 1) - 1)),
                                  static_cast<float>(size[1] * (2.0 * r / (rows - 1) - 1)),
                                  static_cast<float>(heights[r * columns + c] * size[2]));
  mesh.normals.assign(mesh.positions.size(), Vector3f::Zero());
  const auto at = [&](int r, int c) { return r * columns + c; };
  for (int r = 0; r + 1 < rows; ++r) {
    for (int c = 0; c + 1 < columns; ++c) {
      mesh.faces.emplace_back(at(r + 1, c), at(r, c), at(r + 1, c + 1));
      mesh.faces.emplace_back(at(r, c), at(r, c + 1), at(r + 1, c + 1));
    }
  }
  for (const Eigen::Vector3i& face : mesh.faces) {
    const auto corner = [&](int k) { return static_cast<std::size_t>(face[k]); };
    const Vector3f& p = mesh.positions[corner(0)];
    const Vector3f normal = (mesh.positions[corner(1)] - p).cross(mesh.positions[corner(2)] - p);
    for (int k = 0; k < 3; ++k) mesh.normals[corner(k)] += normal;
  }
  for (Vector3f& normal : mesh.normals) normal.normalize();
  return mesh;
}

// The half sizes of the unit shape that MuJoCo draws, by which pictures are stretched.
Vector3f StretchOf(const mjModel* m, int geom) {
  const Vector3f size = Eigen::Map<const Eigen::Vector3d>(m->geom_size + 3 * geom).cast<float>();
  switch (m->geom_type[geom]) {
    case mjGEOM_SPHERE:
      return Vector3f::Constant(size.x());
    case mjGEOM_CAPSULE:
    case mjGEOM_CYLINDER:
      return {size.x(), size.x(), size.y()};
    default:
      return size;
  }
}

// Gives each triangle vertices of its own.
void Separate(Mesh& mesh) {
  Mesh apart;
  for (const Eigen::Vector3i& face : mesh.faces) {
    const auto first = static_cast<int>(apart.positions.size());
    for (const int corner : face) {
      apart.positions.push_back(mesh.positions[static_cast<std::size_t>(corner)]);
      apart.normals.push_back(mesh.normals[static_cast<std::size_t>(corner)]);
    }
    apart.faces.emplace_back(first, first + 1, first + 2);
  }
  mesh = std::move(apart);
}

// The texture coordinates that OpenGL generates for MuJoCo.
void PutPicture(const mjModel* m, int geom, int material, Mesh& mesh) {
  const int type = m->geom_type[geom];
  const bool metric = type == mjGEOM_PLANE || type == mjGEOM_MESH || type == mjGEOM_HFIELD;
  const bool uniform = m->mat_texuniform[material];
  const Vector3f stretch = StretchOf(m, geom);
  if (m->tex_type[m->mat_texid[material]] == mjTEXTURE_2D) {
    const auto scale = [&](int k) {
      const float repeat = 0.5f * m->mat_texrepeat[2 * material + k];
      return uniform || !(stretch[k] > 0) ? repeat : repeat / stretch[k];
    };
    for (const Vector3f& p : mesh.positions)
      mesh.st.emplace_back(scale(0) * p.x() - 0.5f, -scale(1) * p.y() - 0.5f);
    return;
  }
  Separate(mesh);
  Vector3f unit = Vector3f::Ones();
  if (metric && uniform) unit = stretch;
  if (!metric && !uniform) unit = stretch.cwiseMax(1e-9f).cwiseInverse();
  for (std::size_t v = 0; v < mesh.positions.size(); v += 3) {
    const auto direction = [&](std::size_t k) -> Vector3f {
      return mesh.positions[v + k].cwiseProduct(unit);
    };
    const int side = FaceOf(direction(0) + direction(1) + direction(2));
    for (std::size_t k = 0; k < 3; ++k) mesh.st.push_back(PlaceInCube(direction(k), side));
  }
}

}  // namespace

Mesh GeomMesh(const mjModel* m, int geom) {
  const Vector3f size = Eigen::Map<const Eigen::Vector3d>(m->geom_size + 3 * geom).cast<float>();
  Mesh mesh;
  switch (m->geom_type[geom]) {
    case mjGEOM_PLANE:
      mesh = PlaneMesh(size.x() > 0 ? size.x() : kEndless_m, size.y() > 0 ? size.y() : kEndless_m);
      break;
    case mjGEOM_SPHERE:
      mesh = EllipsoidMesh(Vector3f::Constant(size.x()));
      break;
    case mjGEOM_ELLIPSOID:
      mesh = EllipsoidMesh(size);
      break;
    case mjGEOM_CAPSULE:
      mesh = CapsuleMesh(size.x(), size.y());
      break;
    case mjGEOM_CYLINDER:
      mesh = CylinderMesh(size.x(), size.y());
      break;
    case mjGEOM_BOX:
      mesh = BoxMesh(size);
      break;
    case mjGEOM_MESH:
      mesh = OfMesh(m, m->geom_dataid[geom]);
      break;
    case mjGEOM_HFIELD:
      mesh = OfHeightField(m, m->geom_dataid[geom]);
      break;
    default:
      break;
  }
  const int material = m->geom_matid[geom];
  if (material < 0 || m->mat_texid[material] < 0)
    mesh.st.clear();
  else if (mesh.st.empty())
    PutPicture(m, geom, material, mesh);
  return mesh;
}

std::size_t FacesOf(const mjModel* m, int geom) {
  const int id = m->geom_dataid[geom];
  if (m->geom_type[geom] == mjGEOM_MESH) return static_cast<std::size_t>(m->mesh_facenum[id]);
  if (m->geom_type[geom] == mjGEOM_HFIELD)
    return 2 * static_cast<std::size_t>(m->hfield_nrow[id] - 1) *
           static_cast<std::size_t>(m->hfield_ncol[id] - 1);
  return 0;
}

}  // namespace kestrel::sim::gltf
