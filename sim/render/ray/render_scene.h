// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/pose.h"
#include "sim/render/pyramid/pyramid.h"
#include "sim/render/ray/mesh/triangles.h"

namespace kestrel::sim::ray {

// How a texture lies on a geom. Everything in the geom's own frame, metres.
enum class Mapping {
  kNone,
  kPlanar,    // s = scale_s x - 1/2, t = scale_t y - 1/2
  kCube,      // the direction (x, y, z) times scale
  kExplicit,  // the mesh's own texture coordinates
};

// A geom as it is drawn: what does not change while the world moves. Shapes as MuJoCo has them: a plane faces
// its z (size 0: endless), a capsule and a cylinder lie along z, of half length size.z.
struct Geom {
  int geom = -1;
  int type = 0;  // mjtGeom
  Eigen::Vector3f size = Eigen::Vector3f::Zero();
  Eigen::Vector3f box_centre = Eigen::Vector3f::Zero(),
                  box_half = Eigen::Vector3f::Zero();  // holds all of it
  float bound = 0;  // radius of the sphere round its origin by which MuJoCo sorts what is transparent
  Eigen::Vector4f rgba = Eigen::Vector4f::Ones();
  float emission = 0, specular = 0, shininess = 0;
  const Pyramid* texture = nullptr;
  Mapping mapping = Mapping::kNone;
  float scale_s = 0, scale_t = 0;
  Eigen::Vector3f cube_scale = Eigen::Vector3f::Ones();
  const Triangles* triangles = nullptr;  // of a mesh or a height field
  bool still = false;                    // fixed to the world
  bool sheet = false;   // ground, or as flat and wide as that: it casts no shadow that one would see
  bool bright = false;  // shines so much by itself that no light on it shows
  bool baked = false;   // a still mesh whose picture has its light painted in
};

struct Light {
  int id = -1;  // of the model; -1: the headlight, which moves with the camera
  bool directional = true, shadows = false;
  Eigen::Vector3f ambient, diffuse, specular, attenuation;
  float cutoff_cos = -1, exponent = 0;
};

// Band of haze over the horizon of the first endless plane.
struct Haze {
  int thing = -1;  // the plane; -1: none
  float width = 0;
  Eigen::Vector3f rgb = Eigen::Vector3f::Zero();
};

// What is far takes the colour of the sky above the horizon, by Koschmieder's law: of contrast with it
// exp(-per_m distance) is left.
struct Air {
  float per_m = 0;                                // 0: it is clear
  Eigen::Vector3f rgb = Eigen::Vector3f::Zero();  // 0 to 255
};

// All that is drawn of a model.
struct RenderScene {
  std::vector<Geom> all;
  std::vector<Light> lights;
  std::vector<std::shared_ptr<const Pyramid>> textures;
  std::vector<std::unique_ptr<Triangles>> meshes;
  const Pyramid* sky = nullptr;
  Haze haze;
  Air air;
  bool lit = true;  // false: there is no light, and MuJoCo shines a little of its own
};

// The geoms that MuJoCo would draw, as it would draw them: groups 0 to 2, whole or part transparent. Throws
// std::runtime_error that names the first geom or texture of a kind that the ray renderer does not draw.
// shadows: whether rays go on from what is seen.
RenderScene CompileScene(const mjModel* model, bool shadows);

// A thing in the camera's frame at one instant.
struct GeomInstance {
  float R[9] = {};        // d_G = R d_C, row after row
  float o[3] = {};        // the viewpoint in G
  float towards[3] = {};  // unit direction of the geom's origin in C
  float distance = 0;
  // The colour, 0 to 255, of each side of a flat thing where the light does not vary over it: +x, -x, +y, -y,
  // +z, -z (of a plane: +z).
  float face[6][3] = {};
  bool flat = false;
  bool transparent = false;
  float alpha = 1;
  float order = 0;      // of transparent things: the nearest first
  bool behind = false;  // a plane seen from its back
  bool thin = false;    // a rod or a dot less than about two pixels wide: a pixel's ray may miss it
};

struct LightInstance {
  float direction[3], position[3];  // in C; direction: of the light's travel
};

struct SceneInstance {
  std::vector<GeomInstance> things;
  std::vector<LightInstance> lights;
  std::vector<int> transparent;  // indices, the nearest first
  float R_MC[9] = {};            // directions of the world, for the sky
  float eye_M[3] = {};           // the viewpoint in the world
};

// Where the geoms and lights of the world are: copied from mjData, so that instants can be interpolated.
struct ScenePose {
  std::vector<Eigen::Quaterniond> R;  // of each thing, in M
  std::vector<Eigen::Vector3d> p;
  std::vector<Eigen::Vector3d> light_p, light_d;
};
ScenePose PoseOfScene(const RenderScene& things, const mjData* data);
ScenePose Interpolate(const RenderScene& things, const ScenePose& a, const ScenePose& b, double share);

// pixel_rad: the angle between pixels.
void InstantiateScene(const RenderScene& things, const ScenePose& world, const Pose& X_NC, float pixel_rad,
                      SceneInstance& placement);

}  // namespace kestrel::sim::ray
