// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/render_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "sim/render/pyramid/pyramid_cache.h"
#include "sim/render/ray/instruction_set.h"
#include "sim/world/frames.h"
#include "sim/world/scene.h"

namespace kestrel::sim::ray {
namespace {

constexpr float kOpaque = 0.995f;  // MuJoCo's own threshold
constexpr int kMaxLights = 8;      // as many as OpenGL has

std::string NameOf(const mjModel* m, int type, int id) {
  const char* name = mj_id2name(m, type, id);
  return name ? fmt::format("'{}'", name) : fmt::format("number {}", id);
}

// The list of what MuJoCo draws, with the materials that it gives to each.
struct Drawn {
  mjvScene scene;
  DataPtr data;
  explicit Drawn(const mjModel* m) : data(MakeData(m)) {
    mj_kinematics(m, data.get());
    mj_comPos(m, data.get());
    mj_camlight(m, data.get());
    mjv_defaultScene(&scene);
    mjv_makeScene(m, &scene, m->ngeom + 1000);
    mjvOption visible;
    mjv_defaultOption(&visible);
    std::fill(visible.flags, visible.flags + mjNVISFLAG, 0);
    visible.flags[mjVIS_TEXTURE] = visible.flags[mjVIS_STATIC] = visible.flags[mjVIS_SKIN] = 1;
    std::fill(visible.sitegroup, visible.sitegroup + mjNGROUP, 0);
    mjvCamera unused;
    mjv_defaultCamera(&unused);
    mjv_updateScene(m, data.get(), &visible, nullptr, &unused, mjCAT_ALL, &scene);
  }
  ~Drawn() { mjv_freeScene(&scene); }
};

Eigen::Vector3f HalfSize(const mjModel* m, int g) {
  const Eigen::Vector3f s = Eigen::Map<const Eigen::Vector3d>(m->geom_size + 3 * g).cast<float>();
  switch (m->geom_type[g]) {
    case mjGEOM_SPHERE:
      return {s.x(), s.x(), s.x()};
    case mjGEOM_CAPSULE:
    case mjGEOM_CYLINDER:
      return {s.x(), s.x(), s.y()};
    default:
      return s;
  }
}

void BoundThing(Geom& t) {
  t.box_half = t.size;
  switch (t.type) {
    case mjGEOM_PLANE:
      for (int k = 0; k < 2; ++k)
        if (t.size[k] <= 0) t.box_half[k] = 1e9f;
      t.box_half.z() = 0;
      break;
    case mjGEOM_CAPSULE:
      t.box_half.z() += t.size.x();
      break;
    case mjGEOM_MESH:
    case mjGEOM_HFIELD:
      t.box_centre = 0.5f * (t.triangles->low + t.triangles->high);
      t.box_half = 0.5f * (t.triangles->high - t.triangles->low);
      break;
    default:
      break;
  }
  // Room for what rounding may do.
  t.box_half = t.box_half * 1.0001f + Eigen::Vector3f::Constant(1e-4f);
}

// How OpenGL's generated texture coordinates lie on the geom; size: as MuJoCo draws it.
void MapTexture(const mjModel* m, int material, Geom& t) {
  const int texture = m->mat_texid[material];
  const bool uniform = m->mat_texuniform[material];
  const float* repeat = m->mat_texrepeat + 2 * material;
  const bool metric = t.type == mjGEOM_PLANE || t.type == mjGEOM_MESH ||
                      t.type == mjGEOM_HFIELD;  // listed in metres, not as a unit shape
  if (t.triangles && t.triangles->has_st) {
    t.mapping = Mapping::kExplicit;
  } else if (m->tex_type[texture] == mjTEXTURE_2D) {
    t.mapping = Mapping::kPlanar;
    const auto scale = [&](int k) {
      const float size = t.size[k];
      if (uniform || !(size > 0)) return 0.5f * repeat[k];
      return 0.5f * repeat[k] / size;
    };
    t.scale_s = scale(0);
    t.scale_t = -scale(1);
  } else {
    t.mapping = Mapping::kCube;
    for (int k = 0; k < 3; ++k) {
      const float unit = metric ? 1 : 1 / std::max(t.size[k], 1e-9f);
      t.cube_scale[k] = uniform ? unit * t.size[k] : unit;
    }
  }
}

bool IsSheet(const Geom& t) {
  constexpr float kThickest_m = 0.05f, kNarrowest_m = 1, kTerrain_m = 1000;
  if (t.type == mjGEOM_PLANE || t.type == mjGEOM_HFIELD) return true;
  if (!t.still) return false;
  if (t.triangles) return t.box_half.maxCoeff() > kTerrain_m;
  return t.type == mjGEOM_BOX && t.size.z() < kThickest_m / 2 &&
         t.size.head<2>().maxCoeff() > kNarrowest_m / 2 && t.size.head<2>().minCoeff() > 2 * t.size.z();
}

bool IsThin(const Geom& t, float distance, float pixel_rad) {
  if (t.type == mjGEOM_PLANE || t.triangles) return false;
  Eigen::Vector3f half = t.box_half;
  std::sort(half.data(), half.data() + 3);
  return half[1] < pixel_rad * std::max(distance - t.box_half.norm(), 0.0f);
}

void PlaceLight(const Light& light, int index, const ScenePose& world, const Eigen::Matrix3d& R_CM,
                const Eigen::Vector3d& p_MC, LightInstance& placed) {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ(), position = Eigen::Vector3d::Zero();
  if (light.id >= 0) {
    direction = R_CM * world.light_d[index];
    position = R_CM * (world.light_p[index] - p_MC);
  }
  for (int k = 0; k < 3; ++k) {
    placed.direction[k] = static_cast<float>(direction[k]);
    placed.position[k] = static_cast<float>(position[k]);
  }
}

Air AirOf(const mjModel* m) {
  Air air;
  const int number = mj_name2id(m, mjOBJ_NUMERIC, "visibility_m");
  if (number < 0 || m->numeric_size[number] < 1 || m->numeric_data[m->numeric_adr[number]] <= 0) return air;
  constexpr double kFade = 3.912;  // of contrast, at the visibility: to 2 %
  air.per_m = static_cast<float>(kFade / m->numeric_data[m->numeric_adr[number]]);
  for (int i = 0; i < m->ntex; ++i) {
    if (m->tex_type[i] != mjTEXTURE_SKYBOX) continue;
    // The rows in the middle of the four upright faces, of six one above the other.
    const int width = m->tex_width[i], face = m->tex_height[i] / 6;
    for (const int side : {0, 1, 4, 5}) {
      const mjtByte* row =
          m->tex_rgb + m->tex_adr[i] + 3 * static_cast<std::ptrdiff_t>(width) * (side * face + face / 2);
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c) air.rgb[c] += row[3 * x + c] / (4.0f * static_cast<float>(width));
    }
    break;
  }
  return air;
}

}  // namespace

RenderScene CompileScene(const mjModel* m, bool shadows) {
  RenderScene things;
  const Drawn drawn(m);
  const PyramidCache pyramids(m);
  std::map<int, const Pyramid*> textures;
  const auto texture = [&](int id) {
    const Pyramid*& found = textures[id];
    if (!found) {
      things.textures.push_back(pyramids.Of(id));
      found = things.textures.back().get();
    }
    return found;
  };
  std::map<std::pair<int, int>, Triangles*> meshes;
  for (int i = 0; i < drawn.scene.ngeom; ++i) {
    const mjvGeom& g = drawn.scene.geoms[i];
    if (g.type == mjGEOM_SKIN) {
      throw std::runtime_error(fmt::format("The ray renderer does not draw skins, and the model has one: {}.",
                                           NameOf(m, mjOBJ_SKIN, g.objid)));
    }
    if (g.objtype != mjOBJ_GEOM) {
      throw std::runtime_error(
          fmt::format("The ray renderer draws geoms alone, and the model has the {} {}.",
                      g.objtype == mjOBJ_ACTUATOR ? "slider-crank" : mju_type2Str(g.objtype),
                      NameOf(m, g.objtype, g.objid)));
    }
    if (g.rgba[3] <= 0) continue;
    Geom t;
    t.geom = g.objid;
    t.type = g.type;
    t.size = HalfSize(m, t.geom);
    t.rgba = Eigen::Map<const Eigen::Vector4f>(g.rgba);
    t.emission = g.emission;
    t.specular = g.specular;
    t.shininess = g.shininess;
    t.still = m->body_weldid[m->geom_bodyid[t.geom]] == 0 && m->body_mocapid[m->geom_bodyid[t.geom]] < 0;
    switch (t.type) {
      case mjGEOM_PLANE:
      case mjGEOM_SPHERE:
      case mjGEOM_CAPSULE:
      case mjGEOM_ELLIPSOID:
      case mjGEOM_CYLINDER:
      case mjGEOM_BOX:
        break;
      case mjGEOM_MESH:
      case mjGEOM_HFIELD: {
        const int id = m->geom_dataid[t.geom];
        Triangles*& found = meshes[{t.type, id}];
        if (!found) {
          things.meshes.push_back(std::make_unique<Triangles>(
              t.type == mjGEOM_MESH ? Triangles::OfMesh(m, id) : Triangles::OfHeightField(m, id)));
          found = things.meshes.back().get();
        }
        if (shadows || t.rgba[3] < kOpaque) found->MakeTree(InstructionSet());
        t.triangles = found;
        break;
      }
      default:
        throw std::runtime_error(
            fmt::format("The ray renderer does not draw geoms of type {}, and the model has one: {}.", t.type,
                        NameOf(m, mjOBJ_GEOM, t.geom)));
    }
    if (const int material = m->geom_matid[t.geom]; material >= 0 && g.texid >= 0) {
      if (t.triangles && t.triangles->has_st && m->tex_type[g.texid] != mjTEXTURE_2D) {
        throw std::runtime_error(fmt::format(
            "The ray renderer does not draw a cube texture on a mesh with texture coordinates of its own, "
            "and the model has one: geom {}.",
            NameOf(m, mjOBJ_GEOM, t.geom)));
      }
      t.texture = texture(g.texid);
      MapTexture(m, material, t);
    }
    BoundThing(t);
    t.sheet = IsSheet(t);
    t.bright = t.emission * t.rgba.head<3>().minCoeff() >= 1;
    t.baked = t.still && t.triangles && t.texture && t.emission >= 1;
    t.bound = static_cast<float>(m->geom_rbound[t.geom]);
    if (t.type == mjGEOM_PLANE && t.size.x() == 0 && t.size.y() == 0 && things.haze.thing < 0) {
      things.haze.thing = static_cast<int>(things.all.size());
      things.haze.width = m->vis.map.haze;
      things.haze.rgb = Eigen::Map<const Eigen::Vector3f>(m->vis.rgba.haze);
    }
    things.all.push_back(t);
  }
  for (int i = 0; i < m->ntex && !things.sky; ++i)
    if (m->tex_type[i] == mjTEXTURE_SKYBOX) things.sky = texture(i);
  if (!things.sky) things.haze.thing = -1;
  things.air = AirOf(m);

  int next =
      0;  // the lights of the scene are the headlight, then the active ones of the model in their order
  for (int i = 0; i < std::min(drawn.scene.nlight, kMaxLights); ++i) {
    const mjvLight& l = drawn.scene.lights[i];
    Light light;
    if (!l.headlight) {
      while (!m->light_active[next]) ++next;
      light.id = next++;
    }
    light.directional = l.directional || l.headlight;
    light.shadows = l.castshadow;
    const auto rgb = [](const float* v) { return Eigen::Vector3f(v[0], v[1], v[2]); };
    light.ambient = rgb(l.ambient);
    light.diffuse = rgb(l.diffuse);
    light.specular = rgb(l.specular);
    light.attenuation = rgb(l.attenuation);
    // OpenGL knows cones up to 90 degrees, and no cone at all.
    light.cutoff_cos = l.cutoff > 90 ? -2.0f : std::cos(l.cutoff * 3.14159265f / 180);
    light.exponent = l.exponent;
    things.lights.push_back(light);
  }
  things.lit = !things.lights.empty();
  return things;
}

ScenePose PoseOfScene(const RenderScene& things, const mjData* data) {
  ScenePose world;
  for (const Geom& t : things.all) {
    world.R.emplace_back(Eigen::Matrix3d(
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->geom_xmat + 9 * t.geom)));
    world.p.emplace_back(data->geom_xpos + 3 * t.geom);
  }
  for (const Light& l : things.lights) {
    world.light_p.emplace_back(l.id < 0 ? Eigen::Vector3d::Zero().eval()
                                        : Eigen::Vector3d(data->light_xpos + 3 * l.id));
    world.light_d.emplace_back(l.id < 0 ? Eigen::Vector3d::UnitZ().eval()
                                        : Eigen::Vector3d(data->light_xdir + 3 * l.id));
  }
  return world;
}

ScenePose Interpolate(const RenderScene& things, const ScenePose& a, const ScenePose& b, double share) {
  ScenePose world = a;
  for (std::size_t i = 0; i < things.all.size(); ++i) {
    if (things.all[i].still) continue;
    world.R[i] = a.R[i].slerp(share, b.R[i]);
    world.p[i] = a.p[i] + share * (b.p[i] - a.p[i]);
  }
  for (std::size_t i = 0; i < things.lights.size(); ++i) {
    world.light_p[i] = a.light_p[i] + share * (b.light_p[i] - a.light_p[i]);
    world.light_d[i] = (a.light_d[i] + share * (b.light_d[i] - a.light_d[i])).normalized();
  }
  return world;
}

void InstantiateScene(const RenderScene& things, const ScenePose& world, const Pose& X_NC, float pixel_rad,
                      SceneInstance& placement) {
  // M and N share their origin; their axes differ by sign alone.
  Eigen::Matrix3d R_MC;
  for (int k = 0; k < 3; ++k) R_MC.col(k) = SwapNedNwu(X_NC.R * Eigen::Vector3d::Unit(k));
  const Eigen::Vector3d p_MC = SwapNedNwu(X_NC.p);
  const Eigen::Matrix3d R_CM = R_MC.transpose();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) placement.R_MC[3 * r + c] = static_cast<float>(R_MC(r, c));

  for (int k = 0; k < 3; ++k) placement.eye_M[k] = static_cast<float>(p_MC[k]);

  placement.lights.resize(things.lights.size());
  bool all_directional = true;
  for (std::size_t i = 0; i < things.lights.size(); ++i) {
    PlaceLight(things.lights[i], static_cast<int>(i), world, R_CM, p_MC, placement.lights[i]);
    all_directional = all_directional && things.lights[i].directional;
  }

  placement.things.resize(things.all.size());
  placement.transparent.clear();
  for (std::size_t i = 0; i < things.all.size(); ++i) {
    const Geom& t = things.all[i];
    GeomInstance& placed = placement.things[i];
    const Eigen::Matrix3d R_GM = world.R[i].toRotationMatrix().transpose();
    const Eigen::Matrix3d R_GC = R_GM * R_MC;
    const Eigen::Vector3d eye_M = p_MC - world.p[i];
    const Eigen::Vector3d o = R_GM * eye_M;
    const Eigen::Vector3d towards_C = -(R_CM * eye_M);
    placed.distance = static_cast<float>(towards_C.norm());
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) placed.R[3 * r + c] = static_cast<float>(R_GC(r, c));
      placed.o[r] = static_cast<float>(o[r]);
      placed.towards[r] = static_cast<float>(towards_C[r] / std::max(towards_C.norm(), 1e-12));
    }
    placed.behind = t.type == mjGEOM_PLANE && o.z() < 0;
    placed.thin = IsThin(t, placed.distance, pixel_rad);
    placed.transparent = t.rgba[3] < kOpaque || placed.behind;
    placed.alpha = placed.behind ? 0.3f * t.rgba[3] : t.rgba[3];
    if (placed.transparent) {
      placed.order = t.type == mjGEOM_PLANE ? 1e10f : placed.distance - t.bound;
      placement.transparent.push_back(static_cast<int>(i));
    }

    // On a flat side under parallel light without highlights the colour is the same everywhere.
    bool highlights = false;
    for (const Light& l : things.lights)
      highlights = highlights || (t.specular > 0 && l.specular.maxCoeff() > 0);
    placed.flat = (t.type == mjGEOM_PLANE || t.type == mjGEOM_BOX) && all_directional && !highlights;
    if (!placed.flat) continue;
    const Eigen::Vector3f rgb = t.rgba.head<3>();
    for (int side = 0; side < 6; ++side) {
      Eigen::Vector3f lit = t.emission * rgb;
      if (!things.lit) lit += 0.3f * rgb;
      for (std::size_t l = 0; l < things.lights.size(); ++l) {
        const LightInstance& light = placement.lights[l];
        const Eigen::Map<const Eigen::Vector3f> direction_C(light.direction);
        float cosine = 0;
        for (int k = 0; k < 3; ++k)
          cosine -= placed.R[3 * (side / 2) + k] * direction_C[k] * (side % 2 == 0 ? 1.0f : -1.0f);
        lit += rgb.cwiseProduct(things.lights[l].ambient + std::max(cosine, 0.0f) * things.lights[l].diffuse);
      }
      for (int k = 0; k < 3; ++k) placed.face[side][k] = 255 * std::clamp(lit[k], 0.0f, 1.0f);
    }
  }
  std::stable_sort(placement.transparent.begin(), placement.transparent.end(),
                   [&](int a, int b) { return placement.things[a].order < placement.things[b].order; });
}

}  // namespace kestrel::sim::ray
