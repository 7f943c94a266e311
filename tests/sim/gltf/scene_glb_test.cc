// SPDX-License-Identifier: Apache-2.0
#include "sim/gltf/scene_glb.h"

#include <assimp/scene.h>
#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "sim/gltf/mesh.h"
#include "sim/world/frames.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

const std::filesystem::path kModels = std::filesystem::path(KESTREL_SOURCE_DIR) / "models";

SceneParameters OverTheAirfield(const char* vehicle) {
  SceneParameters p;
  p.world = kModels / "worlds/airfield/airfield.xml";
  p.vehicle = kModels / "vehicles" / vehicle / (std::string(vehicle) + ".xml");
  p.pad_texture = kModels / "pads/helipad/helipad.png";
  p.pad.size_m = {1, 1};
  p.pad_position_m = {3, -2};
  p.pad_yaw_deg = 40;
  p.targets.resize(2);
  p.occluder = p.blind = true;
  return p;
}

// Assimp knows nothing of how the file was written.
class Read {
 public:
  explicit Read(const std::string& glb) : glb_(glb) {
    scene_ = importer_.ReadFileFromMemory(glb.data(), glb.size(), 0, "glb");
    if (!scene_) throw std::runtime_error(importer_.GetErrorString());
  }
  const aiScene& scene() const { return *scene_; }
  const aiNode* Node(const char* name) const { return scene_->mRootNode->FindNode(name); }

  // From the node to the file, whose y is up.
  Eigen::Isometry3d PoseOf(const aiNode* node) const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    for (; node; node = node->mParent) {
      Eigen::Matrix4d own;
      for (unsigned r = 0; r < 4; ++r)
        for (unsigned c = 0; c < 4; ++c) own(r, c) = node->mTransformation[r][c];
      X = Eigen::Isometry3d(own) * X;
    }
    return X;
  }
  Eigen::Isometry3d PoseOf(const char* name) const { return PoseOf(Node(name)); }

  // What the file says of itself.
  nlohmann::json Text() const {
    std::uint32_t size;
    std::memcpy(&size, glb_.data() + 12, sizeof(size));
    return nlohmann::json::parse(glb_.substr(20, size));
  }

 private:
  std::string glb_;
  Assimp::Importer importer_;
  const aiScene* scene_;
};

// North, west, up as east of the file's axes: x north, y up, z east.
Eigen::Vector3d InFile(const Eigen::Vector3d& p_M) { return {p_M.x(), p_M.z(), -p_M.y()}; }

TEST(SceneGlb, HasEachThingWhereMuJoCoHasIt) {
  const ModelPtr model = MakeModel(OverTheAirfield("pelican"));
  const DataPtr data = StateOf(model.get());
  const Read read(SceneGlb(model.get(), SeenRotors(MultirotorParameters{})));
  for (const auto& [node, body] : {std::pair{"aircraft", "vehicle"},
                                   {"pad", "pad"},
                                   {"target_0", "target 0"},
                                   {"target_1", "target 1"}}) {
    const int id = mj_name2id(model.get(), mjOBJ_BODY, body);
    ASSERT_NE(read.Node(node), nullptr) << node;
    const Eigen::Isometry3d X = read.PoseOf(node);
    EXPECT_LT((X.translation() - InFile(Eigen::Vector3d(data->xpos + 3 * id))).norm(), 1e-5) << node;
    for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, 1)}) {
      mjtNum along[3];
      mju_rotVecQuat(along, axis.data(), data->xquat + 4 * id);
      EXPECT_LT((X.linear() * axis - InFile(Eigen::Vector3d(along))).norm(), 1e-5) << node;
    }
  }
  EXPECT_EQ(read.Node("deck"), nullptr);
  EXPECT_EQ(read.Node("occluder"), nullptr);
}

// Over any small piece of the surface a ray of MuJoCo's that looks straight at it meets it. Round things are
// cut into flat pieces, so not to the millimetre.
TEST(SceneGlb, ShapesLieWhereMuJoCosRaysMeetThem) {
  const ModelPtr model = CompileScene(R"(<mujoco><asset>
      <hfield name="relief" file="relief.png" size="1 1 0.4 0.1"/>
      <mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/></asset><worldbody>
    <geom type="plane" size="30 20 1" pos="0 0 -1"/>
    <geom type="box" size="0.5 0.3 0.2" pos="-6 0 1" euler="20 30 40"/>
    <geom type="sphere" size="0.6" pos="-4 0 1"/>
    <geom type="capsule" size="0.3 0.5" pos="-2 0 1" euler="50 0 10"/>
    <geom type="cylinder" size="0.4 0.2" pos="0 0 1" euler="0 70 0"/>
    <geom type="ellipsoid" size="0.6 0.3 0.2" pos="2 0 1" euler="10 20 30"/>
    <geom type="hfield" hfield="relief" pos="4 0 1"/>
    <geom type="mesh" mesh="wedge" pos="7 0 1" euler="0 0 30"/>
    </worldbody></mujoco>)");
  const DataPtr data = StateOf(model.get());
  const Read read(SceneGlb(model.get(), {}));
  const aiNode* world = read.Node("world");
  const Eigen::Isometry3d X = read.PoseOf(world);
  int pieces = 0;
  std::vector<int> met(static_cast<std::size_t>(model->ngeom));
  for (unsigned i = 0; i < world->mNumMeshes; ++i) {
    const aiMesh& mesh = *read.scene().mMeshes[world->mMeshes[i]];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      Eigen::Vector3d corner[3];
      for (int k = 0; k < 3; ++k) {
        const aiVector3D& p = mesh.mVertices[mesh.mFaces[f].mIndices[k]];
        const Eigen::Vector3d q = X * Eigen::Vector3d(p.x, p.y, p.z);
        corner[k] = {q.x(), -q.z(), q.y()};
      }
      const Eigen::Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
      constexpr double kFrom = 0.2;
      const Eigen::Vector3d eye = (corner[0] + corner[1] + corner[2]) / 3 + kFrom * normal;
      const Eigen::Vector3d ahead = -normal;
      int geom = -1;
      const double distance =
          mj_ray(model.get(), data.get(), eye.data(), ahead.data(), nullptr, 1, -1, &geom);
      ASSERT_GE(geom, 0);
      EXPECT_NEAR(distance, kFrom, 0.025) << "of geom " << geom;
      ++met[static_cast<std::size_t>(geom)];
      ++pieces;
    }
  }
  EXPECT_THAT(met, testing::Each(testing::Gt(1)));
  EXPECT_GT(pieces, 400);
}

TEST(SceneGlb, ThePadShowsItsPictureWithItsUpAlongItsX) {
  SceneParameters p = OverTheAirfield("pelican");
  p.pad_picture = cv::Mat(64, 64, CV_8UC3, cv::Scalar(255, 255, 255));
  p.pad_picture(cv::Rect(0, 0, 32, 32)) = cv::Scalar(0, 0, 200);   // red, above on the left
  p.pad_picture(cv::Rect(32, 0, 32, 32)) = cv::Scalar(0, 200, 0);  // green, above on the right
  const ModelPtr model = MakeModel(p);
  const Read read(SceneGlb(model.get(), {}));
  const aiMesh& mesh = *read.scene().mMeshes[read.Node("pad")->mMeshes[0]];
  aiString path;
  ASSERT_EQ(read.scene().mMaterials[mesh.mMaterialIndex]->GetTexture(aiTextureType_DIFFUSE, 0, &path),
            aiReturn_SUCCESS);
  const aiTexture* texture = read.scene().GetEmbeddedTexture(path.C_Str());
  ASSERT_NE(texture, nullptr);
  EXPECT_STREQ(texture->achFormatHint, "jpg");
  const cv::Mat picture =
      cv::imdecode(cv::Mat(1, static_cast<int>(texture->mWidth), CV_8UC1, texture->pcData), cv::IMREAD_COLOR);
  // Of the upper side: where it is, and its place in the picture, whose t Assimp turns upwards.
  std::vector<std::pair<aiVector3D, aiVector3D>> corners;
  aiVector3D middle;
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    if (mesh.mNormals[v].z < 0.9f) continue;
    corners.emplace_back(mesh.mVertices[v], mesh.mTextureCoords[0][v]);
    middle += mesh.mTextureCoords[0][v] * 0.25f;
  }
  ASSERT_EQ(corners.size(), 4u);
  for (const auto& [p_P, st] : corners) {
    const aiVector3D within = (st + middle) * 0.5f;
    const auto texel = [](float share, int count) {
      return static_cast<int>((share - std::floor(share)) * static_cast<float>(count));
    };
    const auto colour =
        picture.at<cv::Vec3b>(texel(1 - within.y, picture.rows), texel(within.x, picture.cols));
    const bool above = p_P.x > 0, left = p_P.y > 0;
    EXPECT_NEAR(colour[0], above ? 0 : 255, 30);
    EXPECT_NEAR(colour[1], !above ? 255 : left ? 0 : 200, 30);
    EXPECT_NEAR(colour[2], !above ? 255 : left ? 200 : 0, 30);
  }
}

TEST(SceneGlb, RotorsTurnAboutTheirHubsTheWayTheyDo) {
  const MultirotorParameters pelican;
  const HelicopterParameters sr20;
  const std::vector<SeenRotor> four = SeenRotors(pelican), two = SeenRotors(sr20);
  ASSERT_EQ(four.size(), 4u);
  ASSERT_EQ(two.size(), 2u);
  // What a motor pushes round pushes back: yaw to the right, about z of B, is by rotors that turn to the left.
  for (std::size_t i = 0; i < 4; ++i) {
    RotorSpeeds speeds{};
    speeds[i] = 500;
    const Wrench wrench = AerodynamicWrench(pelican, speeds, {0, 0, 0}, {0, 0, 0}, {10, 10, 10, 10});
    EXPECT_EQ(four[i].spin * four[i].axis_B.z() > 0, wrench.torque.z() < 0) << i;
    EXPECT_LT(
        (four[i].hub_B.head<2>() - Eigen::Vector2d(-wrench.torque.y(), wrench.torque.x()) / wrench.force.z())
            .norm(),
        0.01);
  }
  for (const auto& [vehicle, rotors] : {std::pair{"pelican", four}, {"sr20", two}}) {
    const ModelPtr model = MakeModel(OverTheAirfield(vehicle));
    const Read read(SceneGlb(model.get(), rotors));
    for (std::size_t i = 0; i < rotors.size(); ++i) {
      const aiNode* node = read.Node(("rotor_" + std::to_string(i)).c_str());
      ASSERT_NE(node, nullptr);
      const Eigen::Vector3d hub_F = SwapNedNwu(rotors[i].hub_B), axis_F = SwapNedNwu(rotors[i].axis_B);
      EXPECT_LT(((read.PoseOf("aircraft").inverse() * read.PoseOf(node)).translation() - hub_F).norm(), 1e-6);
      // What turns stays in its disc, and is not the same after a quarter of a turn.
      double farthest = 0;
      Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
      for (unsigned k = 0; k < node->mNumMeshes; ++k) {
        const aiMesh& mesh = *read.scene().mMeshes[node->mMeshes[k]];
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
          const Eigen::Vector3d p(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z);
          const Eigen::Vector3d across = p - p.dot(axis_F) * axis_F;
          farthest = std::max(farthest, across.norm());
          if (mesh.mNumVertices < 60) spread += across * across.transpose();  // no disc
        }
      }
      EXPECT_NEAR(farthest, rotors[i].radius_m, 0.05 * rotors[i].radius_m) << vehicle << i;
      const Eigen::Vector3d sizes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues();
      EXPECT_GT(sizes[2], 2 * sizes[1]) << vehicle << i;
    }
  }
  const nlohmann::json text = Read(SceneGlb(MakeModel(OverTheAirfield("sr20")).get(), two)).Text();
  int told = 0;
  for (const nlohmann::json& node : text["nodes"]) {
    if (node["name"] != "rotor_0") continue;
    EXPECT_EQ(node["extras"]["spin"], -1);  // clockwise seen from above
    EXPECT_EQ(node["extras"]["axis"][2], 1);
    ++told;
  }
  EXPECT_EQ(told, 1);
}

TEST(SceneGlb, ADeckIsAPartOfThePad) {
  SceneParameters p = OverTheAirfield("pelican");
  p.deck.emplace();
  p.occluder = false;
  const Read read(SceneGlb(MakeModel(p).get(), {}));
  ASSERT_NE(read.Node("deck"), nullptr);
  EXPECT_STREQ(read.Node("deck")->mParent->mName.C_Str(), "pad");
}

TEST(SceneGlb, ALandscapeFitsIntoAReportAndKeepsItsSkyline) {
  LandscapeParameters landscape;
  landscape.hills_deg = 4;
  SceneParameters p = OverTheAirfield("pelican");
  p.landscape = landscape;
  const ModelPtr model = MakeModel(p);
  const std::string glb = SceneGlb(model.get(), {});
  EXPECT_LT(glb.size(), 1'500'000u);
  const Read read(glb);
  EXPECT_THAT(read.Text()["nodes"].back()["extras"]["sky"].get<std::string>(),
              testing::StartsWith("data:image/jpeg;base64,"));
  // By azimuth, as seen from the origin: how far hills reach up.
  constexpr int kSectors = 24;
  std::array<double, kSectors> skyline{}, true_skyline{};
  const auto look = [](const Eigen::Vector3d& p_M, std::array<double, kSectors>& line) {
    const double r = p_M.head<2>().norm();
    if (r < 2000) return;
    const auto sector =
        static_cast<std::size_t>((std::atan2(p_M.y(), p_M.x()) / (2 * std::numbers::pi) + 0.5) * kSectors);
    line[sector % kSectors] = std::max(line[sector % kSectors], std::atan2(p_M.z(), r));
  };
  const DataPtr data = StateOf(model.get());
  for (int g = 0; g < model->ngeom; ++g) {
    if (model->geom_type[g] != mjGEOM_MESH) continue;
    const int mesh = model->geom_dataid[g];
    for (int v = model->mesh_vertadr[mesh]; v < model->mesh_vertadr[mesh] + model->mesh_vertnum[mesh]; ++v) {
      const mjtNum own[3] = {model->mesh_vert[3 * v], model->mesh_vert[3 * v + 1],
                             model->mesh_vert[3 * v + 2]};
      mjtNum p_M[3];
      mju_rotVecMat(p_M, own, data->geom_xmat + 9 * g);
      mju_addTo3(p_M, data->geom_xpos + 3 * g);
      look(Eigen::Vector3d(p_M), true_skyline);
    }
  }
  unsigned faces = 0;
  for (unsigned i = 0; i < read.scene().mNumMeshes; ++i) faces += read.scene().mMeshes[i]->mNumFaces;
  const aiNode* world = read.Node("world");
  for (unsigned i = 0; i < world->mNumMeshes; ++i) {
    const aiMesh& mesh = *read.scene().mMeshes[world->mMeshes[i]];
    for (unsigned v = 0; v < mesh.mNumVertices; ++v)
      look({mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z}, skyline);
  }
  EXPECT_LT(faces, 30'000u);
  EXPECT_GT(faces, 10'000u);
  int hills = 0;
  for (std::size_t k = 0; k < kSectors; ++k) {
    EXPECT_NEAR(skyline[k], true_skyline[k], 0.006) << k;  // a third of a degree
    hills += true_skyline[k] > 0.02;
  }
  EXPECT_GT(hills, 10);
}

// A slope under a picture: where it lies, and what of the picture is where, is linear, and stays so.
TEST(SceneGlb, FewerTrianglesLieOnTheSameSurfaceUnderTheSamePicture) {
  gltf::Mesh slope;
  constexpr int kSide = 60;
  const auto st_at = [](const Eigen::Vector3f& q) {
    return Eigen::Vector2f(0.02f * q.x() + 0.5f, 0.015f * q.y() + 0.4f);
  };
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      const float x = static_cast<float>(i) - 20, y = static_cast<float>(j) - 20;
      slope.positions.emplace_back(x, y, 0.1f * x - 0.2f * y + 3);
      slope.normals.push_back(Eigen::Vector3f(-0.1f, 0.2f, 1).normalized());
      slope.st.push_back(st_at(slope.positions.back()));
    }
  for (int i = 0; i + 1 < kSide; ++i)
    for (int j = 0; j + 1 < kSide; ++j) {
      const int at = i * kSide + j;
      slope.faces.emplace_back(at, at + kSide, at + kSide + 1);
      slope.faces.emplace_back(at, at + kSide + 1, at + 1);
    }
  EXPECT_FALSE(gltf::IsPainted(slope));
  const gltf::Mesh fewer = gltf::Simplified(slope, 1000);
  EXPECT_LE(fewer.faces.size(), 1000u);
  EXPECT_GT(fewer.faces.size(), 300u);
  for (std::size_t v = 0; v < fewer.positions.size(); ++v) {
    const Eigen::Vector3f& q = fewer.positions[v];
    EXPECT_NEAR(q.z(), 0.1f * q.x() - 0.2f * q.y() + 3, 1e-4);
    EXPECT_LT((fewer.st[v] - st_at(q)).norm(), 1e-4);
    EXPECT_GT(fewer.normals[v].dot(slope.normals[0]), 0.999);
  }
  std::size_t turned = 0;  // a few are seen from behind then: meshes are drawn from both sides
  for (const Eigen::Vector3i& face : fewer.faces) {
    const auto at = [&](int k) { return fewer.positions[static_cast<std::size_t>(face[k])]; };
    turned += (at(1) - at(0)).cross(at(2) - at(0)).z() <= 0;
  }
  EXPECT_LT(turned, fewer.faces.size() / 20);
}

}  // namespace
}  // namespace kestrel::sim
