// SPDX-License-Identifier: Apache-2.0
#include "sim/gltf/scene_glb.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "sim/gltf/geom_mesh.h"
#include "sim/gltf/gltf_file.h"
#include "sim/gltf/pictures.h"
#include "sim/world/frames.h"
#include "sim/world/scene.h"

namespace kestrel::sim {
namespace {

using namespace gltf;
using Json = nlohmann::json;

constexpr std::size_t kMostBytes = 1'500'000;
constexpr std::size_t kMostFaces = 26'000;                    // of all meshes together
constexpr std::size_t kFewFaces = 100;                        // that every mesh may have
constexpr int kTexels[] = {1024, 512, 256, 128};              // to a side, tried one after the other
constexpr double kRotorBelow_m = 0.01, kRotorAbove_m = 0.15;  // its hub: what turns with it
constexpr float kBladeChord = 0.12f, kBladeHalf_m = 0.0015f;  // chord over radius

// What is drawn in one go: of one part, one look.
struct Look {
  Eigen::Vector4f rgba;
  float emission;
  int texture;
  bool painted, both_sides;
  auto key() const {
    return std::make_tuple(rgba[0], rgba[1], rgba[2], rgba[3], emission, texture, painted, both_sides);
  }
  bool operator<(const Look& other) const { return key() < other.key(); }
};
using Part = std::map<Look, Mesh>;

Eigen::Isometry3d PoseOf(const mjtNum* position, const mjtNum* quaternion) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Map<const Eigen::Vector3d>(position);
  X.linear() =
      Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3]).toRotationMatrix();
  return X;
}

Eigen::Isometry3d GeomPose(const mjData* data, int geom) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Map<const Eigen::Vector3d>(data->geom_xpos + 3 * geom);
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->geom_xmat + 9 * geom);
  return X;
}

// As MuJoCo has it: a geom's own colour, unless it is the default and there is a material.
Look LookOf(const mjModel* m, int geom) {
  const int material = m->geom_matid[geom];
  const Eigen::Vector4f own = Eigen::Map<const Eigen::Vector4f>(m->geom_rgba + 4 * geom);
  Look look{own, 0, -1, false, false};
  if (material < 0) return look;
  if (own == Eigen::Vector4f(0.5f, 0.5f, 0.5f, 1))
    look.rgba = Eigen::Map<const Eigen::Vector4f>(m->mat_rgba + 4 * material);
  look.emission = m->mat_emission[material];
  look.texture = m->mat_texid[material];
  return look;
}

bool IsSeen(const mjModel* m, int geom) {
  constexpr int kGroups = 3;  // as the renderers draw
  return m->geom_group[geom] < kGroups && LookOf(m, geom).rgba[3] > 0;
}

const char* NameOf(const mjModel* m, mjtObj type, int id) {
  const char* name = mj_id2name(m, type, id);
  return name ? name : "";
}

// The node of what lies on a body; empty: of none.
std::string NodeOf(const mjModel* m, int body) {
  const int root = m->body_rootid[body];
  const std::string name = NameOf(m, mjOBJ_BODY, root);
  if (name == "vehicle") return "aircraft";
  if (name == "pad") return "pad";
  if (name.starts_with("target ")) return "target_" + name.substr(std::strlen("target "));
  return m->body_mocapid[root] >= 0 ? "" : "world";
}

// Which rotor a geom of the vehicle turns with; -1: with none.
int RotorOf(const std::vector<SeenRotor>& rotors, const Eigen::Vector3d& p_F) {
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    const Eigen::Vector3d from = p_F - SwapNedNwu(rotors[i].hub_B), axis = SwapNedNwu(rotors[i].axis_B);
    const double above = from.dot(axis);
    if (above > -kRotorBelow_m && above < kRotorAbove_m && (from - above * axis).norm() < rotors[i].radius_m)
      return static_cast<int>(i);
  }
  return -1;
}

// Two blades through the hub, which is the origin.
Mesh Blades(const SeenRotor& rotor) {
  const auto radius = static_cast<float>(rotor.radius_m);
  Mesh blades;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), SwapNedNwu(rotor.axis_B))
                   .toRotationMatrix();
  blades.Append(BoxMesh({radius, kBladeChord * radius / 2, kBladeHalf_m}), X);
  return blades;
}

// All that is seen, by node; "aircraft/0" is the first rotor, "pad/deck" its plate.
class Parts {
 public:
  Parts(const mjModel* m, const mjData* data, const std::vector<SeenRotor>& rotors) : m_(m), rotors_(rotors) {
    std::size_t faces = 0;
    for (int g = 0; g < m->ngeom; ++g)
      if (IsSeen(m, g)) faces += FacesOf(m, g);
    share_ =
        std::min(1.0, static_cast<double>(kMostFaces) / static_cast<double>(std::max<std::size_t>(faces, 1)));
    std::vector<bool> bladed(rotors.size());
    for (int g = 0; g < m->ngeom; ++g) {
      const int body = m->geom_bodyid[g];
      const std::string node = NodeOf(m, body);
      if (node.empty() || !IsSeen(m, g)) continue;
      const int root = m->body_rootid[body];
      const Eigen::Isometry3d X =
          PoseOf(data->xpos + 3 * root, data->xquat + 4 * root).inverse() * GeomPose(data, g);
      const int rotor = node == "aircraft" ? RotorOf(rotors, X.translation()) : -1;
      if (rotor >= 0) {
        const auto at = static_cast<std::size_t>(rotor);
        const Eigen::Translation3d to_hub(-SwapNedNwu(rotors[at].hub_B));
        Add(node + "/" + std::to_string(rotor), g, to_hub * X);
        bladed[at] = bladed[at] || m->geom_type[g] == mjGEOM_BOX;
      } else {
        const bool deck = node == "pad" && std::strcmp(NameOf(m, mjOBJ_GEOM, g), "deck") == 0;
        Add(deck ? "pad/deck" : node, g, X);
      }
    }
    // A disc alone does not show that it turns.
    for (std::size_t i = 0; i < rotors.size(); ++i) {
      if (!bladed[i])
        parts_["aircraft/" + std::to_string(i)][{{0.12f, 0.12f, 0.13f, 1}, 0, -1, false, false}].Append(
            Blades(rotors[i]), Eigen::Isometry3d::Identity());
    }
  }
  const Part& Of(const std::string& name) { return parts_[name]; }

 private:
  void Add(const std::string& name, int g, const Eigen::Isometry3d& X) {
    Look look = LookOf(m_, g);
    const bool mesh = m_->geom_type[g] == mjGEOM_MESH || m_->geom_type[g] == mjGEOM_HFIELD;
    Mesh shape = GeomMesh(m_, g);
    // In the frame of the node, whose origin is the middle of the world.
    Mesh placed;
    placed.Append(shape, X);
    if (mesh) {
      look.both_sides = true;
      const auto most =
          std::max(kFewFaces, static_cast<std::size_t>(share_ * static_cast<double>(shape.faces.size())));
      look.painted = IsPainted(placed);
      placed = look.painted ? SimplifiedPainted(placed, most) : Simplified(placed, most);
    }
    if (placed.st.empty()) look.texture = -1;
    if (!placed.faces.empty()) parts_[name][look].Append(placed, Eigen::Isometry3d::Identity());
  }

  const mjModel* m_;
  const std::vector<SeenRotor>& rotors_;
  double share_ = 1;
  std::map<std::string, Part> parts_;
};

Json Numbers(const auto& vector) { return std::vector<double>(vector.data(), vector.data() + vector.size()); }

Json LightsOf(const mjModel* m, const mjData* data) {
  Json lights = Json::array();
  for (int i = 0; i < m->nlight; ++i) {
    if (!m->light_active[i]) continue;
    const auto rgb = [&](const float* of_all) { return Numbers(Eigen::Vector3f(of_all + 3 * i)); };
    lights.push_back({{"direction", Numbers(Eigen::Vector3d(data->light_xdir + 3 * i))},
                      {"ambient", rgb(m->light_ambient)},
                      {"diffuse", rgb(m->light_diffuse)}});
  }
  if (m->vis.headlight.active)
    lights.push_back({{"direction", {0, 0, -1}},
                      {"ambient", Numbers(Eigen::Vector3f(m->vis.headlight.ambient))},
                      {"diffuse", Numbers(Eigen::Vector3f(m->vis.headlight.diffuse))}});
  return lights;
}

// The file with pictures of at most so many texels to a side.
class Writer {
 public:
  Writer(const mjModel* m, const mjData* data, int texels) : m_(m), data_(data), texels_(texels) {}

  std::string Write(Parts& parts, const std::vector<SeenRotor>& rotors) {
    Json below = {file_.AddNode(Node("world", parts.Of("world")))};
    if (const int body = Body("vehicle"); body >= 0) {
      Json aircraft = Node("aircraft", parts.Of("aircraft"), body);
      for (std::size_t i = 0; i < rotors.size(); ++i) {
        Json rotor = Node("rotor_" + std::to_string(i), parts.Of("aircraft/" + std::to_string(i)));
        rotor["translation"] = Numbers(SwapNedNwu(rotors[i].hub_B));
        rotor["extras"] = {{"axis", Numbers(SwapNedNwu(rotors[i].axis_B))}, {"spin", rotors[i].spin}};
        aircraft["children"].push_back(file_.AddNode(rotor));
      }
      below.push_back(file_.AddNode(aircraft));
    }
    if (const int body = Body("pad"); body >= 0) {
      Json pad = Node("pad", parts.Of("pad"), body);
      if (const Part& deck = parts.Of("pad/deck"); !deck.empty())
        pad["children"].push_back(file_.AddNode(Node("deck", deck)));
      below.push_back(file_.AddNode(pad));
    }
    for (int i = 0, body; (body = Body(("target " + std::to_string(i)).c_str())) >= 0; ++i)
      below.push_back(
          file_.AddNode(Node("target_" + std::to_string(i), parts.Of("target_" + std::to_string(i)), body)));
    const double half = std::sqrt(0.5);
    Json root = {{"name", "north west up"}, {"rotation", {-half, 0, 0, half}}, {"children", below}};
    root["extras"] = {{"lights", LightsOf(m_, data_)}};
    if (const std::string sky = SkyUrl(m_); !sky.empty()) root["extras"]["sky"] = sky;
    return file_.Glb(file_.AddNode(root));
  }

 private:
  int Body(const char* name) const { return mj_name2id(m_, mjOBJ_BODY, name); }

  Json Node(const std::string& name, const Part& part, int body = 0) {
    Json node = {{"name", name}};
    if (body > 0) {
      const mjtNum* q = data_->xquat + 4 * body;
      node["translation"] = Numbers(Eigen::Vector3d(data_->xpos + 3 * body));
      node["rotation"] = {q[1], q[2], q[3], q[0]};
    }
    Json primitives;
    for (const auto& [look, mesh] : part) primitives.push_back(Primitive(look, mesh));
    if (!part.empty()) node["mesh"] = file_.AddMesh(primitives);
    return node;
  }

  Json Primitive(const Look& look, const Mesh& mesh) {
    if (look.painted) {
      Mesh painted = mesh;
      const int palette = file_.AddTexture(Palette(PictureOf(m_, look.texture, kWhole), painted), true);
      return file_.Primitive(painted, file_.AddMaterial(look.rgba, palette, look.emission, look.both_sides));
    }
    int texture = -1;
    if (look.texture >= 0) {
      const auto [found, isnew] = textures_.try_emplace(look.texture, -1);
      if (isnew) found->second = file_.AddTexture(PictureOf(m_, look.texture, texels_), false);
      texture = found->second;
    }
    return file_.Primitive(mesh, file_.AddMaterial(look.rgba, texture, look.emission, look.both_sides));
  }

  // One texel for each triangle, in place of those in the picture.
  static cv::Mat Palette(const cv::Mat& picture, Mesh& mesh) {
    int side = 1;
    while (side * side < static_cast<int>(mesh.faces.size())) side *= 2;
    cv::Mat palette(side, side, CV_8UC3, cv::Scalar::all(0));
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const int row = static_cast<int>(f) / side, column = static_cast<int>(f) % side;
      const Eigen::Vector2f st = mesh.st[static_cast<std::size_t>(mesh.faces[f][0])];
      const auto texel = [](float s, int count) {
        return std::clamp(static_cast<int>((s - std::floor(s)) * static_cast<float>(count)), 0, count - 1);
      };
      palette.at<cv::Vec3b>(row, column) =
          picture.at<cv::Vec3b>(texel(st.y(), picture.rows), texel(st.x(), picture.cols));
      for (const int corner : mesh.faces[f])
        mesh.st[static_cast<std::size_t>(corner)] = {
            (static_cast<float>(column) + 0.5f) / static_cast<float>(side),
            (static_cast<float>(row) + 0.5f) / static_cast<float>(side)};
    }
    return palette;
  }

  static constexpr int kWhole = 1 << 20;

  const mjModel* m_;
  const mjData* data_;
  int texels_;
  GltfFile file_;
  std::map<int, int> textures_;
};

}  // namespace

std::string SceneGlb(const mjModel* m, const std::vector<SeenRotor>& rotors) {
  const DataPtr data = MakeData(m);
  mj_kinematics(m, data.get());
  mj_comPos(m, data.get());
  mj_camlight(m, data.get());
  Parts parts(m, data.get(), rotors);
  std::string glb;
  for (const int texels : kTexels) {
    glb = Writer(m, data.get(), texels).Write(parts, rotors);
    if (glb.size() <= kMostBytes) break;
  }
  return glb;
}

}  // namespace kestrel::sim
