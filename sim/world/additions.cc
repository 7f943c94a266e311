// SPDX-License-Identifier: Apache-2.0
#include "sim/world/additions.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "geometry/tait_bryan.h"
#include "sim/world/ground_photo.h"
#include "sim/world/mesh_file.h"

namespace kestrel::sim {
namespace {

// A hull has a volume: what is flat, or almost, gets a thousandth of its size.
void Thicken(landscape::Mesh& mesh) {
  constexpr float kFlat = 1e-3f;
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    mean += vertex / static_cast<float>(mesh.vertices.size());
  Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
  for (const Eigen::Vector3f& vertex : mesh.vertices) spread += (vertex - mean) * (vertex - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(spread /
                                                            static_cast<float>(mesh.vertices.size()));
  const float size = std::sqrt(axes.eigenvalues()[2]);
  if (std::sqrt(std::max(axes.eigenvalues()[0], 0.0f)) > kFlat * size) return;
  const Eigen::Vector3f across = kFlat * size * axes.eigenvectors().col(0);
  const std::size_t count = mesh.vertices.size();
  for (std::size_t i = 0; i < count; ++i) {
    mesh.vertices.push_back(mesh.vertices[i] - across);
    mesh.vertices[i] += across;
  }
}

// A file's meshes and materials, once for all the places where it stands.
class MeshAssets {
 public:
  explicit MeshAssets(AdditionsModel& model) : model_(model) {}

  struct Asset {
    std::string name;
    std::vector<std::string> parts;
    Eigen::Vector3f low, high;
    bool has_hull = false;
  };

  Asset& Of(const MeshParameters& p) {
    const auto [found, is_new] = assets_.try_emplace({p.file, p.up, p.scale});
    if (is_new) Add(p, found->second);
    return found->second;
  }

  // All of the file as one mesh without a look.
  void AddHull(const MeshParameters& p) {
    Asset& asset = Of(p);
    if (std::exchange(asset.has_hull, true)) return;
    landscape::Mesh all;
    for (const MeshPart& part : files_.at({p.file, p.up}).parts) {
      const int first = static_cast<int>(all.vertices.size());
      all.vertices.insert(all.vertices.end(), part.mesh.vertices.begin(), part.mesh.vertices.end());
      for (const Eigen::Vector3i& face : part.mesh.faces) all.faces.push_back(face.array() + first);
    }
    Thicken(all);
    AddMesh(asset.name + ".hull", all, p.scale);
  }

 private:
  void AddMesh(const std::string& name, const landscape::Mesh& mesh, double scale) {
    model_.files[name + ".msh"] = landscape::Msh(mesh);
    model_.mjcf +=
        fmt::format(R"(<asset><mesh name="{0}" file="{0}.msh" scale="{1} {1} {1}"/></asset>)", name, scale);
  }

  void Add(const MeshParameters& p, Asset& asset) {
    const auto [file, is_new] = files_.try_emplace({p.file, p.up});
    if (is_new) file->second = ReadMeshFile(p.file, p.up);
    asset.name = fmt::format("mesh {}", assets_.size());
    asset.low.setConstant(std::numeric_limits<float>::max());
    asset.high = -asset.low;
    for (std::size_t i = 0; i < file->second.textures.size(); ++i) {
      const cv::Mat& texture = file->second.textures[i];
      const std::string name = fmt::format("{}.texture {}", asset.name, i);
      model_.textures.emplace_back(name, texture);
      model_.mjcf += fmt::format(
          R"(<asset><texture name="{}" type="2d" builtin="flat" width="{}" height="{}"/></asset>)", name,
          texture.cols, texture.rows);
    }
    for (const MeshPart& part : file->second.parts) {
      const std::string name = fmt::format("{}.{}", asset.name, asset.parts.size());
      AddMesh(name, part.mesh, p.scale);
      const std::string texture =
          part.texture < 0 ? "" : fmt::format(R"( texture="{}.texture {}")", asset.name, part.texture);
      model_.mjcf += fmt::format(R"(<asset><material name="{}"{} specular="0" rgba="{} {} {} {}"/></asset>)",
                                 name, texture, part.rgba[0], part.rgba[1], part.rgba[2], part.rgba[3]);
      asset.parts.push_back(name);
      for (const Eigen::Vector3f& vertex : part.mesh.vertices) {
        asset.low = asset.low.cwiseMin(vertex);
        asset.high = asset.high.cwiseMax(vertex);
      }
    }
    asset.low *= static_cast<float>(p.scale);
    asset.high *= static_cast<float>(p.scale);
  }

  AdditionsModel& model_;
  std::map<std::pair<std::string, std::string>, MeshFile> files_;
  std::map<std::tuple<std::string, std::string, double>, Asset> assets_;
};

void AddMesh(const MeshParameters& p, MeshAssets& assets, AdditionsModel& model) {
  constexpr const char* kUnseen = R"(rgba="0 0 0 0" group="3")";
  const MeshAssets::Asset& asset = assets.Of(p);
  const Eigen::Quaterniond R(Eigen::AngleAxisd(-Radians(p.yaw_deg), Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d origin(p.position_m.x(), -p.position_m.y(), p.height_m);
  const auto add = [&](const std::string& shape, const Eigen::Vector3d& at, const std::string& look) {
    model.mjcf += fmt::format(R"(<worldbody><geom {} pos="{} {} {}" quat="{} 0 0 {}" {}/></worldbody>)",
                              shape, at.x(), at.y(), at.z(), R.w(), R.z(), look);
  };
  for (const std::string& part : asset.parts)
    add(fmt::format(R"(type="mesh" mesh="{}")", part), origin,
        fmt::format(R"(material="{}" contype="0" conaffinity="0")", part));
  if (p.collides == "hull") {
    assets.AddHull(p);
    add(fmt::format(R"(type="mesh" mesh="{}.hull")", asset.name), origin, kUnseen);
  } else if (p.collides == "box") {
    const Eigen::Vector3d half = ((asset.high - asset.low) / 2).cwiseMax(1e-3f).cast<double>();
    add(fmt::format(R"(type="box" size="{} {} {}")", half.x(), half.y(), half.z()),
        origin + R * ((asset.low + asset.high) / 2).cast<double>(), kUnseen);
  }
}

}  // namespace

AdditionsModel MakeAdditions(const WorldAdditions& additions) {
  AdditionsModel model;
  if (additions.ground_photo) AddGroundPhoto(*additions.ground_photo, model);
  MeshAssets assets(model);
  for (const MeshParameters& mesh : additions.meshes) AddMesh(mesh, assets, model);
  model.mjcf = "<mujoco>" + model.mjcf + "</mujoco>";
  return model;
}

void PaintAdditions(const AdditionsModel& additions, mjModel* m) {
  for (const auto& [name, picture] : additions.textures) {
    const int id = mj_name2id(m, mjOBJ_TEXTURE, name.c_str());
    if (id < 0 || m->tex_width[id] != picture.cols || m->tex_height[id] != picture.rows)
      throw std::runtime_error("The model holds no additions to be painted.");
    std::copy(picture.datastart, picture.dataend, m->tex_rgb + m->tex_adr[id]);
  }
}

}  // namespace kestrel::sim
