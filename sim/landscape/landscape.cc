// SPDX-License-Identifier: Apache-2.0
#include "sim/landscape/landscape.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/recent/recent.h"
#include "base/yaml/yaml_fields.h"
#include "sim/landscape/ground.h"
#include "sim/landscape/scenery.h"
#include "sim/landscape/sky.h"
#include "sim/landscape/terrain.h"

namespace kestrel::sim {
namespace {

using namespace landscape;

constexpr int kSkyTexels = 512;     // to a side of the cube
constexpr int kPlainTexels = 1024;  // to a side of the plane, and of the lawn
constexpr float kLawnHalf_m = 30;   // finer ground round the origin
constexpr float kLawnHeight_m = 0.005;
constexpr int kRoundTexels[2] = {4096, 384};  // along azimuth and distance

// The parts, which hold on to each other.
struct Parts {
  Terrain terrain;
  Sky sky;
  Ground ground;
  Parts(const LandscapeParameters& p, std::uint64_t seed)
      : terrain(p, seed), sky(p, seed), ground(p, seed, terrain, sky) {}
  Parts(const Parts&) = delete;
};

std::uint64_t SeedOf(const LandscapeParameters& p, std::uint64_t run_seed) {
  return p.seed ? p.seed : run_seed;
}

void Put(const Colour& colour, mjtByte* rgb) {
  for (int k = 0; k < 3; ++k)
    rgb[k] = static_cast<mjtByte>(std::lround(255 * std::clamp(colour[k], 0.0f, 1.0f)));
}

// Calls paint(row) for every row. What a row shows depends on nothing but its number.
template <class Paint>
void InRows(int rows, const Paint& paint) {
  const int threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 8);
  std::atomic<int> next = 0;
  const auto run = [&] {
    for (int row = next++; row < rows; row = next++) paint(row);
  };
  std::vector<std::jthread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(run);
  run();
}

// Red, green and blue of each texel.
using Picture = std::vector<mjtByte>;

Picture Blank(int columns, int rows) {
  return Picture(3 * static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
}

// Puts a picture, or the first part of one, into that of this name and number of columns.
void Hang(const Picture& picture, const char* name, int columns, mjModel* m) {
  const int id = mj_name2id(m, mjOBJ_TEXTURE, name);
  if (id < 0 || m->tex_width[id] != columns)
    throw std::runtime_error("The model holds no landscape to be painted.");
  std::copy(picture.begin(), picture.end(), m->tex_rgb + m->tex_adr[id]);
}

// A square of level ground, whose light MuJoCo multiplies again; the first row is the west, columns go north.
Picture PaintedPlain(const Ground& ground, const Colour& light, float half_m) {
  Picture picture = Blank(kPlainTexels, kPlainTexels);
  const float texel = 2 * half_m / kPlainTexels;
  InRows(kPlainTexels, [&](int row) {
    mjtByte* rgb = picture.data() + 3 * static_cast<std::ptrdiff_t>(row) * kPlainTexels;
    for (int column = 0; column < kPlainTexels; ++column, rgb += 3) {
      const float north = (static_cast<float>(column) + 0.5f) * texel - half_m;
      const float east = (static_cast<float>(row) + 0.5f) * texel - half_m;
      Put(ground.At(north, east, texel).cwiseQuotient(light), rgb);
    }
  });
  return picture;
}

Picture PaintedRound(const Ground& ground) {
  Picture picture = Blank(kRoundTexels[0], kRoundTexels[1]);
  const float spread = std::log(kOuter_m / kInner_m);
  InRows(kRoundTexels[1], [&](int row) {
    mjtByte* rgb = picture.data() + 3 * static_cast<std::ptrdiff_t>(row) * kRoundTexels[0];
    const float r = kInner_m * std::exp(spread * (static_cast<float>(row) + 0.5f) / kRoundTexels[1]);
    const float texel = r * spread / kRoundTexels[1];
    for (int column = 0; column < kRoundTexels[0]; ++column, rgb += 3) {
      const float azimuth =
          2 * std::numbers::pi_v<float> * (static_cast<float>(column) + 0.5f) / kRoundTexels[0];
      Put(ground.At(r * std::cos(azimuth), r * std::sin(azimuth), texel), rgb);
    }
  });
  return picture;
}

// The faces of the cube as OpenGL numbers and turns them; its axes are x north, y up, z east.
Picture PaintedSky(const Sky& sky) {
  Picture picture = Blank(kSkyTexels, 6 * kSkyTexels);
  InRows(6 * kSkyTexels, [&](int row) {
    mjtByte* rgb = picture.data() + 3 * static_cast<std::ptrdiff_t>(row) * kSkyTexels;
    const float t = (2 * static_cast<float>(row % kSkyTexels) + 1) / kSkyTexels - 1;
    for (int column = 0; column < kSkyTexels; ++column, rgb += 3) {
      const float s = (2 * static_cast<float>(column) + 1) / kSkyTexels - 1;
      const Eigen::Vector3f faces[6] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t},
                                        {s, -1, -t}, {s, -t, 1},  {-s, -t, -1}};
      const Eigen::Vector3f& q = faces[row / kSkyTexels];
      Put(sky.At(Eigen::Vector3f(q.x(), q.z(), q.y()).normalized()), rgb);
    }
  });
  return picture;
}

std::string Rgb(const Colour& c) { return fmt::format("{} {} {}", c.x(), c.y(), c.z()); }

// What MuJoCo's own light makes of level ground: never black, so that it can be divided by.
Colour PlainLight(const Sky& sky) { return sky.LevelLight().cwiseMax(0.02f).cwiseMin(1.0f); }

// Haze may be brighter than anything that this light can make of the ground: where it is thick within the
// plane, the plane glows by itself, as all that lies farther off does.
float PlainGlow(const Sky& sky) {
  const Colour black = Colour::Zero(), edge = sky.Hazed(black, kPlaneHalf_m, 0);
  const float thick = edge.maxCoeff() / std::max(1e-6f, sky.Hazed(black, 1e9f, 0).maxCoeff());
  return std::max(0.0f, 2 * thick - 1) * (1 - PlainLight(sky).minCoeff());
}

struct Pictures {
  Picture plain, lawn, round, sky;
  Picture colours;  // of the faces of what stands on the ground
};

Pictures Paint(const LandscapeParameters& p, std::uint64_t seed) {
  const Parts parts(p, seed);
  const Colour light = PlainLight(parts.sky);
  Pictures all;
  all.plain = PaintedPlain(parts.ground, (light.array() + PlainGlow(parts.sky)).cwiseMin(1.0f), kPlaneHalf_m);
  all.lawn = PaintedPlain(parts.ground, light, kLawnHalf_m);
  all.round = PaintedRound(parts.ground);
  all.sky = PaintedSky(parts.sky);
  const Scenery scenery = MakeScenery(p, seed, parts.terrain, parts.sky, parts.ground);
  all.colours = Blank(static_cast<int>(scenery.colours.size()), 1);
  for (std::size_t face = 0; face < scenery.colours.size(); ++face)
    Put(scenery.colours[face], &all.colours[3 * face]);
  return all;
}

}  // namespace

LandscapeModel MakeLandscape(const LandscapeParameters& p, std::uint64_t run_seed) {
  const Parts parts(p, SeedOf(p, run_seed));
  LandscapeModel model;
  std::string meshes, geoms;
  const auto add = [&](const std::string& name, const char* material, const Mesh& mesh) {
    model.files["landscape_" + name + ".msh"] = Msh(mesh);
    meshes += fmt::format(R"(<mesh name="{0}" file="landscape_{0}.msh"/>)", name);
    geoms +=
        fmt::format(R"(<geom name="{0}" type="mesh" mesh="{0}" material="{1}" contype="0" conaffinity="0"/>)",
                    name, material);
  };
  add("round", "round", parts.terrain.ToMesh());
  const Scenery scenery = MakeScenery(p, SeedOf(p, run_seed), parts.terrain, parts.sky, parts.ground);
  if (!scenery.colours.empty()) add("scenery", "scenery", scenery.mesh);

  const Eigen::Vector3f sun = parts.sky.sun();
  const Colour ambient = static_cast<float>(p.light) * p.ambient.cast<float>();
  const Colour sunlight =
      sun.z() > 0 ? Colour(static_cast<float>(p.light) * p.sunlight.cast<float>()) : Colour::Zero();
  model.mjcf = fmt::format(
      R"(<mujoco model="landscape">
  <statistic center="0 0 0" extent="100"/>
  <visual><headlight active="0"/><quality shadowsize="4096"/></visual>
  <asset>
    <texture name="sky" type="skybox" builtin="flat" width="{0}" height="{1}"/>
    <texture name="plain" type="2d" builtin="flat" width="{2}" height="{2}"/>
    <texture name="lawn" type="2d" builtin="flat" width="{2}" height="{2}"/>
    <texture name="round" type="2d" builtin="flat" width="{3}" height="{4}"/>
    <texture name="scenery" type="2d" builtin="flat" width="{5}" height="{5}"/>
    <material name="plain" texture="plain" specular="0" emission="{16}"/>
    <material name="lawn" texture="lawn" specular="0"/>
    <material name="round" texture="round" specular="0" emission="1"/>
    <material name="scenery" texture="scenery" specular="0" emission="1"/>
    {6}
  </asset>
  <worldbody>
    <light name="sun" directional="true" pos="0 0 60" dir="{7} {8} {9}" ambient="{10}" diffuse="{11}" specular="0 0 0"/>
    <geom name="ground" type="plane" size="{12} {12} 1" material="plain"/>
    <geom name="lawn" type="box" pos="0 0 {13}" size="{14} {14} {13}" material="lawn" contype="0" conaffinity="0"/>
    {15}
  </worldbody>
</mujoco>)",
      kSkyTexels, 6 * kSkyTexels, kPlainTexels, kRoundTexels[0], kRoundTexels[1], kPalette, meshes, -sun.x(),
      sun.y(), -std::max(sun.z(), 0.01f), Rgb(ambient), Rgb(sunlight), kPlaneHalf_m, kLawnHeight_m / 2,
      kLawnHalf_m, geoms, PlainGlow(parts.sky));
  return model;
}

void PaintLandscape(const LandscapeParameters& p, std::uint64_t run_seed, mjModel* m) {
  // To paint takes longer than all else of a flight's start. Who gives a landscape a seed of its own flies in it again;
  // otherwise it is that of one run, and its pictures need not be held.
  static Recent<std::string, Pictures> recent(1);
  const auto paint = [&] { return Paint(p, SeedOf(p, run_seed)); };
  const auto pictures = p.seed ? recent.Of(ToYaml(p), paint) : std::make_shared<const Pictures>(paint());
  Hang(pictures->plain, "plain", kPlainTexels, m);
  Hang(pictures->lawn, "lawn", kPlainTexels, m);
  Hang(pictures->round, "round", kRoundTexels[0], m);
  Hang(pictures->sky, "sky", kSkyTexels, m);
  Hang(pictures->colours, "scenery", kPalette, m);
}

}  // namespace kestrel::sim
