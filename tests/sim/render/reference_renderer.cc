// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/render/reference_renderer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "sim/world/frames.h"

namespace kestrel::sim::reference {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;  // as MuJoCo stores them

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kOpaque = 0.995;              // alpha from which MuJoCo takes a geom for opaque
constexpr double kFar_m = 500;                 // of the OpenGL renderer
constexpr double kSkyDistance = 0.7 * kFar_m;  // radius and half height of the cylinder that carries the sky

struct Line {
  Vector3d origin, direction;  // unit
  Vector3d At(double t) const { return origin + t * direction; }
};

// A surface that faces the ray, in the frame of its geom.
struct Crossing {
  double t = 0;
  Vector3d normal;                     // outward, unit
  Vector3d q;                          // the coordinates that textures go by
  std::optional<Vector2d> texcoord{};  // of a mesh that has its own
};

using Crossings = std::vector<Crossing>;

// ---- shapes

void CrossPlane(const Line& line, const Vector3d& half, Crossings& out) {
  const double t = -line.origin.z() / line.direction.z();
  const Vector3d p = line.At(t);
  if (!(t > 0) || (half.x() > 0 && std::abs(p.x()) > half.x()) ||
      (half.y() > 0 && std::abs(p.y()) > half.y()))
    return;
  out.push_back({t, Vector3d::UnitZ(), p});
}

void CrossBox(const Line& line, const Vector3d& half, Crossings& out) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      if (line.direction[axis] * side >= 0) continue;
      const double t = (side * half[axis] - line.origin[axis]) / line.direction[axis];
      const Vector3d q = line.At(t).cwiseQuotient(half);
      const int b = (axis + 1) % 3, c = (axis + 2) % 3;
      if (t > 0 && std::abs(q[b]) <= 1 && std::abs(q[c]) <= 1)
        out.push_back({t, side * Vector3d::Unit(axis), q});
    }
  }
}

// Where the line enters the unit sphere round the origin of its coordinates; the direction need not be unit.
std::optional<double> EnterSphere(const Vector3d& origin, const Vector3d& direction) {
  const double a = direction.squaredNorm(), b = origin.dot(direction), c = origin.squaredNorm() - 1;
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return std::nullopt;
  const double t = (-b - std::sqrt(discriminant)) / a;
  return t > 0 ? std::optional(t) : std::nullopt;
}

// The same for the endless unit cylinder along z.
std::optional<double> EnterTube(const Vector3d& origin, const Vector3d& direction) {
  return EnterSphere({origin.x(), origin.y(), 0}, {direction.x(), direction.y(), 0});
}

void CrossEllipsoid(const Line& line, const Vector3d& half, Crossings& out) {
  const auto t = EnterSphere(line.origin.cwiseQuotient(half), line.direction.cwiseQuotient(half));
  if (!t) return;
  const Vector3d q = line.At(*t).cwiseQuotient(half);
  out.push_back({*t, q.cwiseQuotient(half).normalized(), q});
}

void CrossBarrel(const Line& line, const Vector3d& half, Crossings& out) {
  const auto t = EnterTube(line.origin / half.x(), line.direction / half.x());
  if (!t) return;
  const Vector3d p = line.At(*t);
  if (std::abs(p.z()) <= half.z())
    out.push_back({*t, Vector3d(p.x(), p.y(), 0).normalized(), p.cwiseQuotient(half)});
}

void CrossCylinder(const Line& line, const Vector3d& half, Crossings& out) {
  CrossBarrel(line, half, out);
  for (const double side : {-1.0, 1.0}) {
    if (line.direction.z() * side >= 0) continue;
    const double t = (side * half.z() - line.origin.z()) / line.direction.z();
    const Vector3d p = line.At(t);
    if (t > 0 && p.head<2>().norm() <= half.x())
      out.push_back({t, side * Vector3d::UnitZ(), p.cwiseQuotient(half)});
  }
}

void CrossCapsule(const Line& line, const Vector3d& half, Crossings& out) {
  CrossBarrel(line, half, out);
  for (const double side : {-1.0, 1.0}) {
    const Vector3d centre(0, 0, side * half.z());
    const auto t = EnterSphere((line.origin - centre) / half.x(), line.direction / half.x());
    if (!t) continue;
    const Vector3d n = (line.At(*t) - centre) / half.x();
    if (n.z() * side > 0) out.push_back({*t, n, n + side * Vector3d::UnitZ()});
  }
}

using Triangle = std::array<Vector3d, 3>;  // counter-clockwise from the front

// How far it is to the front of a triangle, and the weights of its corners there.
struct TriangleHit {
  double t;
  Vector3d weights, normal;
};

std::optional<TriangleHit> CrossTriangle(const Line& line, const Triangle& v) {
  // A line meets a triangle if it passes all edges on the same side.
  const Triangle from_eye{v[0] - line.origin, v[1] - line.origin, v[2] - line.origin};
  Vector3d weights;
  for (int i = 0; i < 3; ++i) {
    weights[i] = -line.direction.dot(from_eye[(i + 1) % 3].cross(from_eye[(i + 2) % 3]));
    if (weights[i] < 0) return std::nullopt;
  }
  const Vector3d normal = (v[1] - v[0]).cross(v[2] - v[0]);
  const double slope = normal.dot(line.direction), t = normal.dot(from_eye[0]) / slope;
  if (!(slope < 0) || !(t > 0)) return std::nullopt;
  return TriangleHit{t, weights / weights.sum(), normal.normalized()};
}

void CrossMesh(const Line& line, const mjModel* m, int mesh, Crossings& out) {
  for (int face = m->mesh_faceadr[mesh]; face < m->mesh_faceadr[mesh] + m->mesh_facenum[mesh]; ++face) {
    std::array<int, 3> corners;
    std::array<Vector3d, 3> v;
    for (int i = 0; i < 3; ++i) {
      corners[i] = m->mesh_face[3 * face + i];
      v[i] = Eigen::Map<const Eigen::Vector3f>(m->mesh_vert + 3 * (corners[i] + m->mesh_vertadr[mesh]))
                 .cast<double>();
    }
    const auto hit = CrossTriangle(line, v);
    if (!hit) continue;
    Vector3d normal = Vector3d::Zero();
    Vector2d texcoord = Vector2d::Zero();
    const bool mapped = m->mesh_texcoordadr[mesh] >= 0;
    for (int i = 0; i < 3; ++i) {
      const Vector3d smooth =
          Eigen::Map<const Eigen::Vector3f>(m->mesh_normal + 3 * (corners[i] + m->mesh_vertadr[mesh]))
              .cast<double>();
      normal += hit->weights[i] * (smooth.dot(hit->normal) < 0.8 ? hit->normal : smooth);
      if (mapped)
        texcoord += hit->weights[i] * Eigen::Map<const Eigen::Vector2f>(
                                          m->mesh_texcoord + 2 * (corners[i] + m->mesh_texcoordadr[mesh]))
                                          .cast<double>();
    }
    out.push_back(
        {hit->t, normal.normalized(), line.At(hit->t), mapped ? std::optional(texcoord) : std::nullopt});
  }
}

// A surface of triangles over a grid, walls down from its rim, and a floor.
std::vector<Triangle> HeightField(const mjModel* m, int field) {
  const int last_row = m->hfield_nrow[field] - 1, last_column = m->hfield_ncol[field] - 1;
  const mjtNum* const size = m->hfield_size + 4 * field;
  const auto at = [&](int r, int c, double z) {
    return Vector3d(size[0] * (2.0 * c / last_column - 1), size[1] * (2.0 * r / last_row - 1), z);
  };
  const auto top = [&](int r, int c) {
    return at(r, c, size[2] * m->hfield_data[m->hfield_adr[field] + r * (last_column + 1) + c]);
  };
  const auto floor = [&](int r, int c) { return at(r, c, -size[3]); };
  std::vector<Triangle> all;
  const auto quad = [&](const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
    all.push_back({a, b, c});
    all.push_back({a, c, d});
  };
  for (int r = 0; r < last_row; ++r)
    for (int c = 0; c < last_column; ++c) quad(top(r, c), top(r, c + 1), top(r + 1, c + 1), top(r + 1, c));
  for (int r = 0; r < last_row; ++r) {
    quad(floor(r + 1, 0), floor(r, 0), top(r, 0), top(r + 1, 0));
    quad(floor(r, last_column), floor(r + 1, last_column), top(r + 1, last_column), top(r, last_column));
  }
  for (int c = 0; c < last_column; ++c) {
    quad(floor(0, c), floor(0, c + 1), top(0, c + 1), top(0, c));
    quad(floor(last_row, c + 1), floor(last_row, c), top(last_row, c), top(last_row, c + 1));
  }
  quad(floor(0, 0), floor(last_row, 0), floor(last_row, last_column), floor(0, last_column));
  return all;
}

void CrossHeightField(const Line& line, const std::vector<Triangle>& field, Crossings& out) {
  for (const Triangle& triangle : field)
    if (const auto hit = CrossTriangle(line, triangle)) out.push_back({hit->t, hit->normal, line.At(hit->t)});
}

// ---- textures: red, green, blue from 0 to 1

struct Picture {
  const mjtByte* rgb;
  int width, height;
  Vector3d Texel(int column, int row) const {
    return Eigen::Map<const Eigen::Matrix<mjtByte, 3, 1>>(rgb + 3 * (row * width + column)).cast<double>() /
           255;
  }
};

Picture PictureOf(const mjModel* m, int texture) {
  return {m->tex_rgb + m->tex_adr[texture], m->tex_width[texture], m->tex_height[texture]};
}

// Between the four texels whose centres are nearest; texel(column, row) may be asked for one beyond the edge.
Vector3d Interpolated(const Vector2d& st, int width, int height,
                      const std::function<Vector3d(int, int)>& texel) {
  const double u = st.x() * width - 0.5, v = st.y() * height - 0.5;
  const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
  const double fu = u - column, fv = v - row;
  return (1 - fv) * ((1 - fu) * texel(column, row) + fu * texel(column + 1, row)) +
         fv * ((1 - fu) * texel(column, row + 1) + fu * texel(column + 1, row + 1));
}

Vector3d Repeated(const Picture& picture, const Vector2d& st) {
  const auto wrapped = [](int i, int n) { return ((i % n) + n) % n; };
  return Interpolated(st, picture.width, picture.height, [&](int column, int row) {
    return picture.Texel(wrapped(column, picture.width), wrapped(row, picture.height));
  });
}

// OpenGL's cube: faces +x, -x, +y, -y, +z, -z, each with a right and a down of its own.
struct OnFace {
  int axis;
  double sign;
  Vector2d st;  // from the upper left corner of the face, 0 to 1
};

OnFace FaceOf(const Vector3d& d) {
  int axis = 0;
  const double major = d.cwiseAbs().maxCoeff(&axis), sign = d[axis] < 0 ? -1 : 1;
  const std::array<Vector2d, 3> right_down{Vector2d(-sign * d.z(), -d.y()), Vector2d(d.x(), sign * d.z()),
                                           Vector2d(sign * d.x(), -d.y())};
  return {axis, sign, (right_down[axis] / major + Vector2d::Ones()) / 2};
}

Vector3d DirectionOf(const OnFace& at) {
  const double right = 2 * at.st.x() - 1, down = 2 * at.st.y() - 1;
  const std::array<Vector3d, 3> d{Vector3d(at.sign, -down, -at.sign * right),
                                  Vector3d(right, at.sign, at.sign * down),
                                  Vector3d(at.sign * right, -down, at.sign)};
  return d[at.axis];
}

// A texel beyond the edge of a face is the one next to that edge on the neighbouring face.
Vector3d OnCube(const mjModel* m, int texture, const Vector3d& d) {
  const Picture picture = PictureOf(m, texture);
  const int n = picture.width;
  const OnFace at = FaceOf(d);
  return Interpolated(at.st, n, n, [&](int column, int row) {
    if (column < 0 || column >= n) row = std::clamp(row, 0, n - 1);
    const OnFace centre = FaceOf(DirectionOf({at.axis, at.sign, Vector2d(column + 0.5, row + 0.5) / n}));
    const int first_row =
        picture.height == n ? 0 : n * (2 * centre.axis + (centre.sign < 0));  // one for all, or six
    const auto index = [&](double s) { return std::clamp(static_cast<int>(s * n), 0, n - 1); };
    return picture.Texel(index(centre.st.x()), first_row + index(centre.st.y()));
  });
}

// ---- geoms as they are drawn

struct Material {
  Vector3d rgb;
  double alpha = 1, emission = 0, specular = 0.5, shininess = 0.5;
  int texture = -1;
};

Material MaterialOf(const mjModel* m, int geom) {
  const float* rgba = m->geom_rgba + 4 * geom;
  const int id = m->geom_matid[geom];
  Material material;
  if (id >= 0) {
    material.emission = m->mat_emission[id];
    material.specular = m->mat_specular[id];
    material.shininess = m->mat_shininess[id];
    material.texture = m->mat_texid[id];
    const bool untouched = rgba[0] == 0.5F && rgba[1] == 0.5F && rgba[2] == 0.5F && rgba[3] == 1;
    if (untouched) rgba = m->mat_rgba + 4 * id;
  }
  material.rgb = Eigen::Map<const Eigen::Vector3f>(rgba).cast<double>();
  material.alpha = rgba[3];
  return material;
}

Vector3d HalfSize(const mjModel* m, int geom) {
  const mjtNum* s = m->geom_size + 3 * geom;
  switch (m->geom_type[geom]) {
    case mjGEOM_SPHERE:
      return {s[0], s[0], s[0]};
    case mjGEOM_CAPSULE:
    case mjGEOM_CYLINDER:
      return {s[0], s[0], s[1]};
    default:
      return {s[0], s[1], s[2]};
  }
}

bool Shown(const mjModel* m, int geom) { return m->geom_group[geom] <= 2 && MaterialOf(m, geom).alpha > 0; }

Vector3d TextureAt(const mjModel* m, int geom, const Crossing& at) {
  const int material = m->geom_matid[geom], texture = material < 0 ? -1 : m->mat_texid[material];
  if (texture < 0) return Vector3d::Ones();
  if (at.texcoord) return Repeated(PictureOf(m, texture), *at.texcoord);
  const Vector3d half = HalfSize(m, geom);
  const bool uniform = m->mat_texuniform[material];
  if (m->tex_type[texture] != mjTEXTURE_2D)
    return OnCube(m, texture, uniform ? at.q.cwiseProduct(half) : at.q);
  Vector2d repeat(m->mat_texrepeat[2 * material], m->mat_texrepeat[2 * material + 1]);
  const int type = m->geom_type[geom];
  const bool metric = type == mjGEOM_PLANE || type == mjGEOM_MESH || type == mjGEOM_HFIELD;
  for (int k = 0; k < 2; ++k) {
    if (metric && half[k] > 0) repeat[k] /= half[k];
    if (uniform && half[k] > 0) repeat[k] *= half[k];
  }
  return Repeated(PictureOf(m, texture),
                  {0.5 * repeat.x() * at.q.x() - 0.5, -0.5 * repeat.y() * at.q.y() - 0.5});
}

// ---- one view of one state

class View {
 public:
  View(const mjModel* m, const mjData* d, const Pose& X_NC, bool shadows = false)
      : m_(m),
        d_(d),
        shadows_(shadows),
        eye_(SwapNedNwu(X_NC.p)),
        gaze_(SwapNedNwu(X_NC.R * Vector3d::UnitZ())) {
    for (int i = 0; i < m->nhfield; ++i) fields_.push_back(HeightField(m, i));
    for (int i = m->ntex - 1; i >= 0; --i)
      if (m->tex_type[i] == mjTEXTURE_SKYBOX) sky_ = i;
    for (int i = m->ngeom - 1; i >= 0; --i)
      if (Shown(m, i) && m->geom_type[i] == mjGEOM_PLANE && m->geom_size[3 * i] == 0 &&
          m->geom_size[3 * i + 1] == 0)
        endless_plane_ = i;
    for (int i = 0; i < m->ngeom; ++i) {
      if (!Shown(m, i)) continue;
      (Alpha(i) < kOpaque ? transparent_ : opaque_).push_back(i);
    }
    std::stable_sort(transparent_.begin(), transparent_.end(),
                     [&](int a, int b) { return SortingDistance(a) < SortingDistance(b); });
  }

  // Red, green, blue from 0 to 1 along a direction.
  Vector3d Colour(const Vector3d& direction_M) const {
    const Line ray{eye_, direction_M};
    Vector3d colour = Vector3d::Zero();
    double end = kInfinity;
    for (const int geom : opaque_) {
      for (const Crossing& at : CrossingsOf(geom, ray)) {
        if (at.t > end) continue;  // of two at the same depth the later is drawn over the first
        end = at.t;
        colour = Lit(geom, at, ray);
      }
    }
    if (sky_ >= 0) Sky(ray, colour, end);
    for (const int geom : transparent_) Blend(geom, ray, end, colour);
    for (std::size_t i = transparent_.size(); i-- > 0;) Blend(transparent_[i], ray, end, colour);
    return colour;
  }

  std::vector<Hit> Hits(const Vector3d& direction_M) const {
    const Line ray{eye_, direction_M};
    std::vector<Hit> hits;
    for (int geom = m_->ngeom - 1; geom >= 0; --geom) {
      if (!Shown(m_, geom)) continue;
      for (const Crossing& at : CrossingsOf(geom, ray))
        if (sky_ < 0 || at.t < SkyDistance(ray))
          hits.push_back({at.t, geom, Rotation(geom) * at.normal, Alpha(geom) >= kOpaque});
    }
    std::stable_sort(hits.begin(), hits.end(),
                     [](const Hit& a, const Hit& b) { return a.distance_m < b.distance_m; });
    return hits;
  }

 private:
  Matrix3 Rotation(int geom) const { return Eigen::Map<const Matrix3>(d_->geom_xmat + 9 * geom); }
  Vector3d Position(int geom) const { return Eigen::Map<const Vector3d>(d_->geom_xpos + 3 * geom); }
  // Height over the plane of a geom's x and y.
  double EyeHeight(int geom) const { return (eye_ - Position(geom)).dot(Rotation(geom).col(2)); }
  bool Behind(int geom) const { return m_->geom_type[geom] == mjGEOM_PLANE && EyeHeight(geom) < 0; }
  double Alpha(int geom) const { return MaterialOf(m_, geom).alpha * (Behind(geom) ? 0.3 : 1); }
  double SortingDistance(int geom) const {
    if (m_->geom_type[geom] == mjGEOM_PLANE) return 1e10;
    return (Position(geom) - eye_).norm() - m_->geom_rbound[geom];
  }
  Crossings CrossingsOf(int geom, const Line& ray) const {
    const double reach = m_->geom_rbound[geom];  // 0: endless
    if (reach > 0 && (Position(geom) - ray.origin).cross(ray.direction).norm() > 1.001 * reach) return {};
    const Matrix3 R = Rotation(geom);
    const Line line{R.transpose() * (ray.origin - Position(geom)), R.transpose() * ray.direction};
    const Vector3d half = HalfSize(m_, geom);
    Crossings out;
    switch (m_->geom_type[geom]) {
      case mjGEOM_PLANE:
        CrossPlane(line, half, out);
        break;
      case mjGEOM_HFIELD:
        CrossHeightField(line, fields_[m_->geom_dataid[geom]], out);
        break;
      case mjGEOM_SPHERE:
      case mjGEOM_ELLIPSOID:
        CrossEllipsoid(line, half, out);
        break;
      case mjGEOM_CAPSULE:
        CrossCapsule(line, half, out);
        break;
      case mjGEOM_CYLINDER:
        CrossCylinder(line, half, out);
        break;
      case mjGEOM_BOX:
        CrossBox(line, half, out);
        break;
      case mjGEOM_MESH:
        CrossMesh(line, m_, m_->geom_dataid[geom], out);
        break;
      default:
        break;
    }
    return out;
  }

  Vector3d Lit(int geom, const Crossing& at, const Line& ray) const {
    const Material material = MaterialOf(m_, geom);
    const Vector3d p = ray.At(at.t), n = Rotation(geom) * at.normal;
    const int headlight = m_->vis.headlight.active ? 1 : 0;
    std::vector<int> lights;  // -1: the headlight
    if (headlight) lights.push_back(-1);
    for (int i = 0; i < m_->nlight; ++i)
      if (m_->light_active[i]) lights.push_back(i);
    Vector3d light = material.emission * material.rgb;
    if (lights.empty()) light += 0.3 * material.rgb;
    if (lights.size() > 8) lights.resize(8);  // OpenGL has no more
    for (const int i : lights) {
      const bool head = i < 0;
      const auto rgb = [](const float* c) -> Vector3d {
        return Eigen::Map<const Eigen::Vector3f>(c).cast<double>();
      };
      const Vector3d ambient = rgb(head ? m_->vis.headlight.ambient : m_->light_ambient + 3 * i);
      const Vector3d diffuse = rgb(head ? m_->vis.headlight.diffuse : m_->light_diffuse + 3 * i);
      const Vector3d specular = rgb(head ? m_->vis.headlight.specular : m_->light_specular + 3 * i);
      const Vector3d beam = head ? gaze_ : Vector3d(Eigen::Map<const Vector3d>(d_->light_xdir + 3 * i));
      Vector3d to_light = -beam.normalized();
      double strength = 1, distance = kInfinity;
      if (!head && !m_->light_directional[i]) {
        const Vector3d away = Eigen::Map<const Vector3d>(d_->light_xpos + 3 * i) - p;
        const double d = distance = away.norm();
        to_light = away / d;
        const float* const a = m_->light_attenuation + 3 * i;
        strength = 1 / (a[0] + d * (a[1] + d * a[2]));
        const double along = std::max(0.0, -to_light.dot(beam.normalized()));
        const double cutoff = m_->light_cutoff[i] * std::numbers::pi / 180;
        if (m_->light_cutoff[i] <= 90)  // OpenGL takes no wider cone: such a lamp shines to all sides
          strength *= along < std::cos(cutoff) ? 0 : std::pow(along, m_->light_exponent[i]);
      }
      if (shadows_ && !head && m_->light_castshadow[i] && material.alpha >= kOpaque &&
          Hidden({p + 1e-6 * n, to_light}, distance))
        continue;
      Vector3d sum = ambient.cwiseProduct(material.rgb);
      const double incidence = n.dot(to_light);
      if (incidence > 0) {
        sum += incidence * diffuse.cwiseProduct(material.rgb);
        const double reflected = std::max(0.0, n.dot((to_light - ray.direction).normalized()));
        sum += std::pow(reflected, 128 * material.shininess) * material.specular * specular;
      }
      light += strength * sum;
    }
    return light.cwiseMin(1).cwiseProduct(TextureAt(m_, geom, at));
  }

  bool Hidden(const Line& ray, double distance) const {
    for (const int geom : opaque_)
      for (const Crossing& at : CrossingsOf(geom, ray))
        if (at.t < distance) return true;
    return false;
  }

  double SkyDistance(const Line& ray) const {
    return kSkyDistance / std::max(ray.direction.head<2>().norm(), std::abs(ray.direction.z()));
  }

  // Over what is there up to end; end moves to what hides the transparent geoms behind it.
  void Sky(const Line& ray, Vector3d& colour, double& end) const {
    const Vector3d d = ray.direction;
    if (SkyDistance(ray) < end) {
      end = SkyDistance(ray);
      colour = OnCube(m_, sky_, {d.x(), d.z(), -d.y()});
    }
    if (endless_plane_ < 0) return;
    // A truncated cone, from the plane at a share 1 - r of the sky's distance up to the eye's height at all
    // of it.
    const double height = EyeHeight(endless_plane_), r = m_->vis.map.haze;
    const Vector3d up = Rotation(endless_plane_).col(2);
    const double sunk = -d.dot(up), out = std::sqrt(std::max(0.0, 1 - sunk * sunk));
    if (height < 0 || sunk < 0) return;
    // t sunk = height (1 - h), t out = kSkyDistance (1 - r (1 - h)), h: share of the eye's height.
    const double t = kSkyDistance / (out + r * kSkyDistance * sunk / height);
    const double h = 1 - t * sunk / height;
    if (h < 0 || t >= end) return;
    const double full = r / (1 + r);
    const double alpha = h < full ? h / full : (1 - h) / (1 - full);
    colour += alpha * (Eigen::Map<const Eigen::Vector3f>(m_->vis.rgba.haze).cast<double>() - colour);
    end = t;
  }

  void Blend(int geom, const Line& ray, double end, Vector3d& colour) const {
    for (const Crossing& at : CrossingsOf(geom, ray))
      if (at.t <= end) colour += Alpha(geom) * (Lit(geom, at, ray) - colour);
  }

  const mjModel* m_;
  const mjData* d_;
  bool shadows_;
  Vector3d eye_, gaze_;
  std::vector<std::vector<Triangle>> fields_;
  int sky_ = -1, endless_plane_ = -1;
  std::vector<int> opaque_, transparent_;  // the latter as they are drawn first: near to far
};

const Hit* FirstOpaque(const std::vector<Hit>& hits) {
  const auto hit = std::find_if(hits.begin(), hits.end(), [](const Hit& h) { return h.opaque; });
  return hit == hits.end() ? nullptr : &*hit;
}

Vector3d Direction(const Pose& X_NC, const Vector3d& ray_C) {
  return SwapNedNwu(X_NC.R * ray_C).normalized();
}

}  // namespace

cv::Mat Render(const mjModel* model, const mjData* data, const Pose& X_NC, const vision::CameraModel& camera,
               int n, bool shadows) {
  const View view(model, data, X_NC, shadows);
  cv::Mat image(vision::HeightPx(camera), vision::WidthPx(camera), CV_8UC3, cv::Scalar::all(0));
  image.forEach<cv::Vec3b>([&](cv::Vec3b& pixel, const int* place) {
    const Vector2d centre(place[1], place[0]);
    if (!vision::Ray(camera, centre)) return;
    Vector3d sum = Vector3d::Zero();
    int rays = 0;
    for (int i = 0; i < n * n; ++i) {
      const Vector2d offset((i % n + 0.5) / n - 0.5, (i / n + 0.5) / n - 0.5);  // NOLINT: whole rows
      const auto ray = vision::Ray(camera, centre + offset);
      if (!ray) continue;
      sum += view.Colour(Direction(X_NC, *ray));
      ++rays;
    }
    for (int k = 0; k < 3; ++k) pixel[2 - k] = cv::saturate_cast<uchar>(255 * sum[k] / rays);
  });
  return image;
}

std::vector<std::vector<Hit>> Hits(const mjModel* model, const mjData* data, const Pose& X_NC,
                                   const vision::CameraModel& camera) {
  const View view(model, data, X_NC);
  std::vector<std::vector<Hit>> hits;
  for (int v = 0; v < vision::HeightPx(camera); ++v) {
    for (int u = 0; u < vision::WidthPx(camera); ++u) {
      const auto ray = vision::Ray(camera, Vector2d(u, v));
      hits.push_back(ray ? view.Hits(Direction(X_NC, *ray)) : std::vector<Hit>{});
    }
  }
  return hits;
}

SurfaceErrors ErrorsOf(const Surfaces& seen, const mjModel* model, const mjData* data, const Pose& X_NC,
                       const vision::CameraModel& camera) {
  const auto hits = Hits(model, data, X_NC, camera);
  SurfaceErrors errors;
  for (int v = 0; v < vision::HeightPx(camera); ++v) {
    for (int u = 0; u < vision::WidthPx(camera); ++u) {
      if (!vision::Ray(camera, Vector2d(u, v))) continue;
      const Hit* const hit = FirstOpaque(hits[v * vision::WidthPx(camera) + u]);
      if (seen.geom.at<int>(v, u) != (hit ? hit->geom : -1)) {
        ++errors.other_geom;
      } else if (hit) {
        errors.depth = std::max(errors.depth, std::abs(seen.depth_m.at<float>(v, u) / hit->distance_m - 1));
      }
    }
  }
  return errors;
}

cv::Mat Flow(const mjModel* model, const mjData* data, const Pose& X_NC, const mjData* next_data,
             const Pose& X_NC_next, const vision::CameraModel& camera) {
  const auto rotation = [](const mjData* d, int geom) -> Matrix3 {
    return Eigen::Map<const Matrix3>(d->geom_xmat + 9 * geom);
  };
  const auto position = [](const mjData* d, int geom) -> Vector3d {
    return Eigen::Map<const Vector3d>(d->geom_xpos + 3 * geom);
  };
  const auto hits = Hits(model, data, X_NC, camera);
  cv::Mat flow(vision::HeightPx(camera), vision::WidthPx(camera), CV_64FC2, cv::Scalar::all(std::nan("")));
  flow.forEach<cv::Vec2d>([&](cv::Vec2d& pixel, const int* place) {
    const Vector2d uv(place[1], place[0]);
    const auto ray = vision::Ray(camera, uv);
    if (!ray) return;
    Vector3d p_C = X_NC_next.R.conjugate() * (X_NC.R * *ray);
    const auto& on_ray = hits[place[0] * flow.cols + place[1]];
    if (const Hit* const hit = FirstOpaque(on_ray)) {
      const int geom = hit->geom;
      const Vector3d p_M = SwapNedNwu(X_NC * (hit->distance_m * *ray));
      const Vector3d p_G = rotation(data, geom).transpose() * (p_M - position(data, geom));
      const Vector3d next_M = rotation(next_data, geom) * p_G + position(next_data, geom);
      p_C = X_NC_next.Inverse() * SwapNedNwu(next_M);
    }
    if (const auto next = vision::Project(camera, p_C))
      pixel = cv::Vec2d(next->x() - uv.x(), next->y() - uv.y());
  });
  return flow;
}

}  // namespace kestrel::sim::reference
