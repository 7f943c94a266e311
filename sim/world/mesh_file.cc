// SPDX-License-Identifier: Apache-2.0
#include "sim/world/mesh_file.h"

#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "base/user_file.h"
#include "sim/world/mesh_texture.h"

namespace kestrel::sim {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxDepth = 200;  // of nodes within nodes

struct Material {
  Eigen::Vector4f rgba = Eigen::Vector4f::Ones();
  int texture = -1;
  unsigned st_channel = 0;
  bool two_sided = false;
};

// How a linear share of light shows (IEC 61966-2-1): glTF's factors are such shares.
float Shown(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear
                              : 1.055f * std::pow(std::clamp(linear, 0.0f, 1.0f), 1 / 2.4f) - 0.055f;
}

class Reader {
 public:
  Reader(const fs::path& file, const std::string& up)
      : file_(file), is_obj_(fs::path(file).extension() == ".obj" || file.extension() == ".OBJ") {
    // Each row: an axis of M in the file's axes.
    if (up == "y")
      to_M_ << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    else
      to_M_ << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  }

  MeshFile Read() {
    if (!IsFile(file_)) throw std::runtime_error(fmt::format("{}.", NoSuchFile(file_)));
    if (fs::file_size(file_) > kMaxDataBytes)
      Refuse(fmt::format("has {} MB; valid: up to {} MB", fs::file_size(file_) >> 20, kMaxDataBytes >> 20));
    Assimp::Importer importer;
    scene_ =
        importer.ReadFile(file_.string(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices |
                                              aiProcess_TransformUVCoords | aiProcess_ValidateDataStructure);
    if (!scene_ || !scene_->mRootNode)
      Refuse(fmt::format("does not load: {}; valid: OBJ or glTF (.obj, .gltf, .glb)",
                         scene_ ? "it has no scene" : importer.GetErrorString()));
    materials_.resize(scene_->mNumMaterials);
    for (unsigned i = 0; i < scene_->mNumMaterials; ++i) materials_[i] = MaterialOf(*scene_->mMaterials[i]);
    Walk(*scene_->mRootNode, Eigen::Matrix4f::Identity(), 0);
    for (auto& [material, part] : parts_)
      if (!part.mesh.faces.empty()) out_.parts.push_back(std::move(part));
    if (out_.parts.empty()) Refuse("has no triangle; valid: a file with a mesh");
    return std::move(out_);
  }

 private:
  [[noreturn]] void Refuse(const std::string& why) const {
    throw std::runtime_error(fmt::format("The mesh {} {}.", file_.string(), why));
  }

  Material MaterialOf(const aiMaterial& m) {
    Material material;
    aiColor4D rgba;
    const bool linear = m.Get(AI_MATKEY_BASE_COLOR, rgba) == aiReturn_SUCCESS;
    if (linear || m.Get(AI_MATKEY_COLOR_DIFFUSE, rgba) == aiReturn_SUCCESS)
      material.rgba = {rgba.r, rgba.g, rgba.b, rgba.a};
    if (linear)
      for (int k = 0; k < 3; ++k) material.rgba[k] = Shown(material.rgba[k]);
    if (float opacity = 1; m.Get(AI_MATKEY_OPACITY, opacity) == aiReturn_SUCCESS)
      material.rgba[3] = std::min(material.rgba[3], opacity);
    material.rgba = material.rgba.cwiseMax(0).cwiseMin(1);
    int two_sided = 0;
    m.Get(AI_MATKEY_TWOSIDED, two_sided);
    material.two_sided = is_obj_ || two_sided != 0;
    for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
      aiString name;
      if (m.GetTexture(type, 0, &name) != aiReturn_SUCCESS || name.length == 0) continue;
      material.texture = TextureNamed(name.C_Str());
      int channel = 0;
      m.Get(AI_MATKEY_UVWSRC(type, 0), channel);
      material.st_channel = static_cast<unsigned>(std::clamp(channel, 0, AI_MAX_NUMBER_OF_TEXTURECOORDS - 1));
      // Some programs write black beside a picture, and mean the picture.
      if (material.rgba.head<3>().isZero()) material.rgba.head<3>().setOnes();
      break;
    }
    return material;
  }

  int TextureNamed(const std::string& name) {
    const auto [known, is_new] = textures_.try_emplace(name, static_cast<int>(out_.textures.size()));
    if (is_new) {
      const aiTexture* embedded = scene_->GetEmbeddedTexture(name.c_str());
      try {
        out_.textures.push_back(embedded ? EmbeddedTexture(*embedded) : TextureBeside(file_, name));
      } catch (const std::runtime_error& e) {
        Refuse(e.what());
      }
    }
    return known->second;
  }

  void Walk(const aiNode& node, const Eigen::Matrix4f& above, int depth) {
    if (depth > kMaxDepth) Refuse(fmt::format("has nodes more than {} deep; valid: fewer", kMaxDepth));
    Eigen::Matrix4f X;
    const aiMatrix4x4& t = node.mTransformation;
    X << t.a1, t.a2, t.a3, t.a4, t.b1, t.b2, t.b3, t.b4, t.c1, t.c2, t.c3, t.c4, t.d1, t.d2, t.d3, t.d4;
    X = above * X;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) Add(*scene_->mMeshes[node.mMeshes[i]], X);
    for (unsigned i = 0; i < node.mNumChildren; ++i) Walk(*node.mChildren[i], X, depth + 1);
  }

  void Add(const aiMesh& mesh, const Eigen::Matrix4f& X) {
    const Material material =
        mesh.mMaterialIndex < materials_.size() ? materials_[mesh.mMaterialIndex] : Material{};
    const aiVector3D* st = material.texture >= 0 ? mesh.mTextureCoords[material.st_channel] : nullptr;
    MeshPart& part = parts_[{mesh.mMaterialIndex, st != nullptr}];
    part.rgba = material.rgba;
    part.texture = st ? material.texture : -1;

    const Eigen::Matrix3f A = to_M_ * X.topLeftCorner<3, 3>();
    const Eigen::Vector3f p = to_M_ * X.topRightCorner<3, 1>();
    const float determinant = A.determinant();
    const Eigen::Matrix3f of_normals =
        (determinant < 0 ? -1.0f : 1.0f) * A.determinant() * A.inverse().transpose();
    const auto vertex = [&](unsigned v) -> Eigen::Vector3f {
      const aiVector3D& q = mesh.mVertices[v];
      return A * Eigen::Vector3f(q.x, q.y, q.z) + p;
    };
    const auto normal = [&](unsigned v) -> Eigen::Vector3f {
      const aiVector3D& n = mesh.mNormals[v];
      return (of_normals * Eigen::Vector3f(n.x, n.y, n.z)).normalized();
    };
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // a point or a line
      unsigned corner[3] = {face.mIndices[0], face.mIndices[1], face.mIndices[2]};
      if (determinant < 0) std::swap(corner[1], corner[2]);
      Eigen::Vector3f at[3];
      for (int k = 0; k < 3; ++k) {
        if (corner[k] >= mesh.mNumVertices) Refuse("names a vertex that it does not have");
        at[k] = vertex(corner[k]);
        if (!at[k].allFinite() || at[k].cwiseAbs().maxCoeff() > 1e6f)
          Refuse("has a vertex that is no place within 1000 km; valid: coordinates in metres");
      }
      const Eigen::Vector3f flat = (at[1] - at[0]).cross(at[2] - at[0]).normalized();
      if (!flat.allFinite() || flat.isZero()) continue;  // a triangle without an area
      Triangle(part.mesh, mesh, st, corner, at, flat, normal, 1);
      if (material.two_sided) {
        std::swap(corner[1], corner[2]);
        std::swap(at[1], at[2]);
        Triangle(part.mesh, mesh, st, corner, at, -flat, normal, -1);
      }
      triangles_ += material.two_sided ? 2 : 1;
      if (triangles_ > kMaxMeshTriangles)
        Refuse(
            fmt::format("has more than {} triangles (those seen from both sides count twice); valid: so "
                        "many, as a program that reduces meshes makes them",
                        kMaxMeshTriangles));
    }
  }

  template <class Normal>
  void Triangle(landscape::Mesh& out, const aiMesh& mesh, const aiVector3D* st, const unsigned (&corner)[3],
                const Eigen::Vector3f (&at)[3], const Eigen::Vector3f& flat, const Normal& normal,
                float side) {
    const int first = static_cast<int>(out.vertices.size());
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3f n = mesh.HasNormals() ? (side * normal(corner[k])).eval() : flat;
      if (!n.allFinite() || n.isZero()) n = flat;
      out.vertices.push_back(at[k]);
      out.normals.push_back(n);
      Eigen::Vector2f place = Eigen::Vector2f::Zero();
      if (st) place = {st[corner[k]].x, 1 - st[corner[k]].y};  // of Assimp's pictures the last row is at 0
      if (!place.allFinite()) place.setZero();
      out.st.push_back(place);
    }
    out.faces.emplace_back(first, first + 1, first + 2);
  }

  fs::path file_;
  bool is_obj_;
  Eigen::Matrix3f to_M_;
  const aiScene* scene_ = nullptr;
  MeshFile out_;
  std::vector<Material> materials_;
  std::map<std::string, int> textures_;
  std::map<std::pair<unsigned, bool>, MeshPart> parts_;
  std::size_t triangles_ = 0;
};

}  // namespace

MeshFile ReadMeshFile(const fs::path& file, const std::string& up) { return Reader(file, up).Read(); }

}  // namespace kestrel::sim
