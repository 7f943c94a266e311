// SPDX-License-Identifier: Apache-2.0
#include "sim/world/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/imgproc.hpp>
#include <pugixml.hpp>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/gravity.h"
#include "base/user_file.h"
#include "geometry/tait_bryan.h"
#include "sim/world/decoded_texture.h"
#include "sim/world/frames.h"
#include "sim/world/mjcf.h"
#include "sim/world/texture.h"
#include "vision/image_file.h"
#include "vision/image_header.h"

namespace kestrel::sim {
namespace {

constexpr double kTimestep_s = 0.002;
constexpr double kPadThickness_m = 0.01;
constexpr double kDeckThickness_m = 0.2;
constexpr double kDeckMass_kg = 1e5;  // no aircraft moves it
constexpr double kOccluderClearance_m = 0.03;
constexpr double kOccluderThickness_m = 0.004;
constexpr double kOutOfSight_m = 100;  // below the ground
constexpr double kBlindHalf_m = 1.5;
constexpr double kEndless_m = 50e3;     // a plane without an end MuJoCo, and we, draw to some 350 m
constexpr double kVisibility_m = 20e3;  // over ground that reaches so far
constexpr std::size_t kMaxMjcfBytes = 1u << 24;

// Red, green and blue of a lamp of this hue, 0 to 1.
Eigen::Vector3d PureColour(double hue_deg) {
  const auto channel = [&](double at_deg) {
    return std::clamp(2 - std::abs(std::remainder(hue_deg - at_deg, 360.0)) / 60, 0.03, 1.0);
  };
  return {channel(0), channel(120), channel(240)};
}

std::string TargetName(std::size_t index) { return fmt::format("target {}", index); }

// The bytes of what MuJoCo is to read, pictures and meshes: it would read anything to its end.
std::string RequireModest(const std::filesystem::path& file, const std::string& owner) {
  if (!IsFile(file)) throw std::runtime_error(fmt::format("{} needs a file: {}.", owner, NoSuchFile(file)));
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty())
    throw std::runtime_error(fmt::format("{} needs {}, which {}.", owner, file.string(), content.error));
  const auto picture = vision::HeaderOf(content.bytes);
  if (picture && std::max(picture->size.width, picture->size.height) > vision::kMaxImageSide_px)
    throw std::runtime_error(fmt::format("{} needs {}, which has {} x {} pixels; valid: up to {} x {}.",
                                         owner, file.string(), picture->size.width, picture->size.height,
                                         vision::kMaxImageSide_px, vision::kMaxImageSide_px));
  return content.bytes;
}

// What a model names that lies in memory only.
struct Files {
  std::map<std::string, std::string> bytes;    // by its name
  std::map<std::string, std::string> decoded;  // of a texture by its name: the file that it was decoded of
};

// File names relative to the file they stand in, as absolute ones: the composed model stands nowhere. Textures are
// decoded into files.
void MakeFilesAbsolute(pugi::xml_node node, const std::filesystem::path& folder, const std::string& owner,
                       Files& files) {
  for (pugi::xml_attribute attribute : node.attributes()) {
    if (std::strncmp(attribute.name(), "file", 4) != 0)
      continue;  // file, and fileright to fileback of cube textures
    const std::filesystem::path file = folder / attribute.value();
    const std::string bytes = RequireModest(file, owner);
    attribute.set_value(file.c_str());
    if (std::strcmp(node.name(), "texture") != 0) continue;
    if (const auto decoded = DecodedTexture(bytes)) {
      const std::string name = fmt::format("/decoded/{}.texture", files.decoded.size());
      files.bytes[name] = *decoded;
      files.decoded[name] = file;
      attribute.set_value(name.c_str());
    }
  }
  for (const pugi::xml_node child : node.children()) MakeFilesAbsolute(child, folder, owner, files);
}

// Appends the sections of text to the model, as if it stood in a file there: MJCF, or a fragment of it.
void AppendText(pugi::xml_node model, const std::string& text, const std::filesystem::path& path,
                const std::string& owner, Files& files) {
  pugi::xml_document part;
  const pugi::xml_parse_result result = part.load_buffer(text.data(), text.size());
  if (!result)
    throw std::runtime_error(fmt::format("{} is not XML: {} in line {}.", owner, result.description(),
                                         1 + std::count(text.begin(), text.begin() + result.offset, '\n')));
  MakeFilesAbsolute(part, std::filesystem::absolute(path).parent_path(), owner, files);
  for (const pugi::xml_node section : part.document_element().children()) {
    const bool bare = std::strcmp(section.name(), "body") == 0;
    (bare ? model.append_child("worldbody") : model).append_copy(section);
  }
}

void Append(pugi::xml_node model, const std::filesystem::path& path, const char* what, Files& files) {
  const std::string owner = fmt::format("The {} {}", what, path.string());
  const auto [text, error] = ReadUserFile(path, kMaxMjcfBytes);
  if (!error.empty()) throw std::runtime_error(fmt::format("{} {}.", owner, error));
  AppendText(model, text, path, owner, files);
}

// Where there is none, a product with it changes no bit.
Eigen::Quaterniond Lean(const Eigen::Vector2d& deg) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(Radians(deg.x()), Eigen::Vector3d::UnitX()) *
                            Eigen::AngleAxisd(Radians(deg.y()), Eigen::Vector3d::UnitY()));
}

// Its face, so far before its back.
void PutPad(pugi::xml_node body, const SceneParameters& p, double thickness_m) {
  const Eigen::Quaterniond R_NT = HeadingRotation(Radians(p.pad_yaw_deg)) *
                                  Eigen::AngleAxisd(Radians(p.pad_tilt_deg), Eigen::Vector3d::UnitY()) *
                                  Lean(p.pad_lean_deg);
  const Eigen::Vector2d sines =
      p.pad_lean_deg.unaryExpr([](double deg) { return std::abs(std::sin(Radians(deg))); });
  const double raised_m = sines.x() * p.pad.size_m.y() / 2 + sines.y() * p.pad.size_m.x() / 2;
  const Eigen::Vector3d back_N(p.pad_position_m.x(), p.pad_position_m.y(), -p.pad_height_m - raised_m);
  mjtNum q[7];
  PoseToMujoco({R_NT, back_N - R_NT * Eigen::Vector3d(0, 0, thickness_m)}, q);
  body.append_attribute("pos") = fmt::format("{} {} {}", q[0], q[1], q[2]).c_str();
  body.append_attribute("quat") = fmt::format("{} {} {} {}", q[3], q[4], q[5], q[6]).c_str();
}

// Makes the pad a free body on a plate. Its friction stands for both sides of a contact.
void PutOnDeck(pugi::xml_node model, pugi::xml_node body, const DeckParameters& deck) {
  pugi::xml_document part;
  part.load_string(fmt::format(R"(<body>
  <freejoint name="pad"/>
  <inertial pos="0 0 0" mass="{0}" diaginertia="{0} {0} {0}"/>
  <geom name="deck" type="box" pos="0 0 {1}" size="{2} {2} {3}" rgba="0.33 0.36 0.38 1" priority="1"
        friction="{4} 0.01 0.001" condim="4" solref="0.02 1.2" solimp="0.9 0.95 0.005"/>
</body>)",
                               kDeckMass_kg, -kPadThickness_m - kDeckThickness_m / 2, deck.size_m / 2,
                               kDeckThickness_m / 2, deck.friction)
                       .c_str());
  for (const pugi::xml_node child : part.document_element().children()) body.append_copy(child);
  pugi::xml_node face = body.child("geom");
  if (std::strcmp(face.attribute("name").value(), "pad") == 0) {
    for (const char* const of_contact : {"priority", "friction", "condim", "solref", "solimp"})
      face.append_attribute(of_contact) = part.document_element().child("geom").attribute(of_contact).value();
  }
  pugi::xml_node exclude = model.append_child("contact").append_child("exclude");
  exclude.append_attribute("body1") = "pad";
  exclude.append_attribute("body2") = "world";
}

void AppendPlaceOfPad(pugi::xml_node model, const SceneParameters& p) {
  pugi::xml_node body = model.append_child("worldbody").append_child("body");
  body.append_attribute("name") = "pad";
  PutPad(body, p, 0);
  if (p.deck) PutOnDeck(model, body, *p.deck);
}

// picture: as it is painted later; none: MuJoCo reads the file.
void AppendPad(pugi::xml_node model, const SceneParameters& p, const cv::Mat& picture) {
  if (p.pad_texture.empty()) return AppendPlaceOfPad(model, p);
  if (!IsFile(p.pad_texture))
    throw std::runtime_error(fmt::format("The pad's picture {} is not there.", p.pad_texture.string()));
  // MuJoCo spreads a picture over a box with its right along x and its up along y of the geom.
  pugi::xml_document part;
  const std::string text = fmt::format(
      R"(<mujoco>
  <asset>
    <texture name="pad" type="2d"/>
    <material name="pad" texture="pad" specular="0"/>
  </asset>
  <worldbody>
    <body name="pad">
      <geom name="pad" type="box" pos="0 0 {}" quat="1 0 0 -1" size="{} {} {}" material="pad"/>
    </body>
  </worldbody>
</mujoco>)",
      -kPadThickness_m / 2, p.pad.size_m.y() / 2, p.pad.size_m.x() / 2, kPadThickness_m / 2);
  part.load_string(text.c_str());
  PutPad(part.document_element().child("worldbody").child("body"), p, kPadThickness_m);
  if (p.deck)
    PutOnDeck(part.document_element(), part.document_element().child("worldbody").child("body"), *p.deck);
  pugi::xml_node texture = part.document_element().child("asset").child("texture");
  if (picture.empty()) {
    texture.append_attribute("file") = std::filesystem::absolute(p.pad_texture).c_str();
  } else {
    texture.append_attribute("builtin") = "flat";
    texture.append_attribute("width") = picture.cols;
    texture.append_attribute("height") = picture.rows;
  }
  if (p.occluder) {
    pugi::xml_node body = part.document_element().child("worldbody").append_child("body");
    body.append_attribute("name") = "occluder";
    body.append_attribute("mocap") = "true";
    body.append_attribute("pos") = fmt::format("0 0 {}", -kOutOfSight_m).c_str();
    pugi::xml_node geom = body.append_child("geom");
    geom.append_attribute("name") = "occluder";
    geom.append_attribute("type") = "box";
    geom.append_attribute("size") =
        fmt::format("{} {} {}", p.pad.size_m.x() / 2, p.pad.size_m.y() / 2 + 0.1, kOccluderThickness_m / 2)
            .c_str();
    geom.append_attribute("rgba") = "0.12 0.12 0.13 1";
    geom.append_attribute("contype") = "0";
    geom.append_attribute("conaffinity") = "0";
  }
  for (const pugi::xml_node section : part.document_element().children()) model.append_copy(section);
}

void AppendLandscape(pugi::xml_node model, const LandscapeModel& landscape) {
  pugi::xml_document part;
  part.load_string(landscape.mjcf.c_str());
  for (const pugi::xml_node section : part.document_element().children()) model.append_copy(section);
}

// A sphere each, and the string of those that have one, which hangs from the sphere's lowest point.
void AppendTargets(pugi::xml_node model, const SceneParameters& p) {
  for (std::size_t i = 0; i < p.targets.size(); ++i) {
    const TargetParameters& target = p.targets[i];
    const std::string name = TargetName(i);
    const double radius = target.diameter_m / 2;
    pugi::xml_document part;
    part.load_string(fmt::format(R"(<mujoco>
  <asset>
    <material name="{0}" rgba="{1} {2} {3} 1" specular="0.3" shininess="0.4"/>
    <material name="{0} string" rgba="0.85 0.85 0.80 1" specular="0"/>
  </asset>
  <worldbody>
    <body name="{0}" mocap="true">
      <geom name="{0}" type="sphere" size="{4}" material="{0}" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
</mujoco>)",
                                 name, target.colour.x(), target.colour.y(), target.colour.z(), radius)
                         .c_str());
    if (target.string_m > 0) {
      pugi::xml_node geom = part.document_element().child("worldbody").child("body").append_child("geom");
      geom.append_attribute("name") = (name + " string").c_str();
      geom.append_attribute("type") = "capsule";
      geom.append_attribute("fromto") =
          fmt::format("0 0 {} 0 0 {}", -radius, -radius - target.string_m).c_str();
      geom.append_attribute("size") = "0.004";
      geom.append_attribute("material") = (name + " string").c_str();
      geom.append_attribute("contype") = "0";
      geom.append_attribute("conaffinity") = "0";
    }
    for (const pugi::xml_node section : part.document_element().children()) model.append_copy(section);
  }
}

// Globes that shine by themselves, on the body of the vehicle.
void AppendLights(pugi::xml_node model, const vision::AircraftLights& lights) {
  pugi::xml_node body = model.select_node("//body[@name='vehicle']").node();
  if (!body) return;  // said by MakeModel
  pugi::xml_node asset = model.append_child("asset");
  for (const int colour : {1, 2}) {
    const vision::ColourRange& range = colour == 1 ? lights.colour_1 : lights.colour_2;
    const Eigen::Vector3d rgb = PureColour(range.hue_deg);
    pugi::xml_node material = asset.append_child("material");
    material.append_attribute("name") = fmt::format("light {}", colour).c_str();
    material.append_attribute("rgba") = fmt::format("{} {} {} 1", rgb.x(), rgb.y(), rgb.z()).c_str();
    material.append_attribute("specular") = "0";
    material.append_attribute("emission") = "1";
  }
  for (const vision::AircraftLight& light : lights.lights) {
    pugi::xml_node geom = body.append_child("geom");
    geom.append_attribute("type") = "sphere";
    geom.append_attribute("size") = fmt::format("{}", lights.diameter_m / 2).c_str();
    geom.append_attribute("pos") =
        fmt::format("{} {} {}", light.position_m.x(), -light.position_m.y(), -light.position_m.z()).c_str();
    geom.append_attribute("material") = fmt::format("light {}", light.colour).c_str();
    geom.append_attribute("mass") = "0";
    geom.append_attribute("contype") = "0";
    geom.append_attribute("conaffinity") = "0";
    geom.append_attribute("group") = "1";
  }
}

void AppendBlind(pugi::xml_node model) {
  pugi::xml_node body = model.append_child("worldbody").append_child("body");
  body.append_attribute("name") = "blind";
  body.append_attribute("mocap") = "true";
  body.append_attribute("pos") = fmt::format("0 0 {}", -kOutOfSight_m).c_str();
  pugi::xml_node geom = body.append_child("geom");
  geom.append_attribute("name") = "blind";
  geom.append_attribute("type") = "box";
  geom.append_attribute("size") = fmt::format("{0} {0} {1}", kBlindHalf_m, kOccluderThickness_m / 2).c_str();
  geom.append_attribute("rgba") = "0.12 0.12 0.13 1";
  geom.append_attribute("contype") = "0";
  geom.append_attribute("conaffinity") = "0";
}

void AppendAdditions(pugi::xml_node model, const WorldAdditions& additions, const AdditionsModel& made) {
  pugi::xml_document part;
  part.load_string(made.mjcf.c_str());
  for (const pugi::xml_node section : part.document_element().children()) model.append_copy(section);
  pugi::xml_node ground = model.select_node("worldbody/geom[@name='ground']").node();
  if (!additions.endless || !ground) return;
  if (!ground.attribute("size")) ground.append_attribute("size");
  ground.attribute("size") = fmt::format("{0} {0} 1", kEndless_m).c_str();
  pugi::xml_node visibility = model.append_child("custom").append_child("numeric");
  visibility.append_attribute("name") = "visibility_m";
  visibility.append_attribute("data") = kVisibility_m;
}

struct Part {
  const char* what;
  std::filesystem::path path;
};

// pad: its picture, as of AppendPad.
CompiledModel Compose(const SceneParameters& p, const AdditionsModel& additions, const cv::Mat& pad,
                      int parts) {
  LandscapeModel landscape = p.landscape ? MakeLandscape(*p.landscape, p.seed) : LandscapeModel{};
  Files files{std::move(landscape.files), {}};
  pugi::xml_document document;
  pugi::xml_node model = document.append_child("mujoco");
  model.append_attribute("model") = "kestrel";
  if (p.landscape)
    AppendLandscape(model, landscape);
  else
    Append(model, p.world, "world", files);
  AppendAdditions(model, p.additions, additions);
  if (parts > 1 && !p.deck) AppendPad(model, p, pad);
  if (parts > 2) {
    if (p.vehicle_shape.empty())
      Append(model, p.vehicle, "vehicle", files);
    else
      AppendText(model, p.vehicle_shape, p.vehicle, "The vehicle", files);
  }
  if (parts > 1 && p.deck) AppendPad(model, p, pad);
  if (parts > 2) AppendTargets(model, p);
  if (parts > 2 && p.lights) AppendLights(model, *p.lights);
  if (p.blind) AppendBlind(model);
  files.bytes.insert(additions.files.begin(), additions.files.end());
  std::ostringstream text;
  document.save(text);
  CompiledModel compiled = CompileMjcf(text.str(), std::move(files.bytes));
  for (const auto& [name, file] : files.decoded)
    if (const std::size_t at = compiled.message.find(name); at != std::string::npos)
      compiled.message.replace(at, name.size(), file);
  return compiled;
}

int Find(const mjModel* model, mjtObj type, const char* name) { return mj_name2id(model, type, name); }

// Grey or blue, green, red.
void PaintPad(const cv::Mat& picture, mjModel* m) {
  const int id = Find(m, mjOBJ_TEXTURE, "pad");
  cv::Mat rgb(picture.size(), CV_8UC3, m->tex_rgb + m->tex_adr[id]);
  cv::cvtColor(picture, rgb, picture.channels() == 1 ? cv::COLOR_GRAY2RGB : cv::COLOR_BGR2RGB);
}

void CheckGround(const mjModel* model, const SceneParameters& p) {
  const int ground = Find(model, mjOBJ_GEOM, "ground");
  if (ground < 0 || model->geom_type[ground] != mjGEOM_PLANE)
    throw std::runtime_error(fmt::format("The world {} has no plane named \"ground\".", p.world.string()));
  const mjtNum* const pos = model->geom_pos + 3 * ground;
  const mjtNum* const quat = model->geom_quat + 4 * ground;
  const mjtNum* const half = model->geom_size + 3 * ground;
  const Eigen::Quaterniond R_MG(quat[0], quat[1], quat[2], quat[3]);
  if (pos[2] != 0 || (R_MG * Eigen::Vector3d::UnitZ()).z() < 1 - 1e-9)
    throw std::runtime_error(
        fmt::format("The plane \"ground\" of the world {} must be level and at height 0.", p.world.string()));
  for (const double along : {-0.5, 0.5}) {
    for (const double across : {-0.5, 0.5}) {
      const Eigen::Vector2d corner_N =
          p.pad_position_m + Eigen::Rotation2Dd(Radians(p.pad_yaw_deg)) *
                                 Eigen::Vector2d(along * p.pad.size_m.x(), across * p.pad.size_m.y());
      const Eigen::Vector3d corner_G =
          R_MG.conjugate() * Eigen::Vector3d(corner_N.x() - pos[0], -corner_N.y() - pos[1], 0);
      for (int axis = 0; axis < 2; ++axis)
        if (half[axis] > 0 && std::abs(corner_G[axis]) > half[axis])  // a half size of 0 is an endless plane
          throw std::runtime_error(fmt::format(
              "The pad of {} m x {} m at north {} m, east {} m reaches beyond the ground of the world {}, "
              "which is {} m x {} m.",
              p.pad.size_m.x(), p.pad.size_m.y(), p.pad_position_m.x(), p.pad_position_m.y(),
              p.world.string(), 2 * half[0], 2 * half[1]));
    }
  }
}

}  // namespace

ModelPtr MakeModel(const SceneParameters& parameters, bool paint) {
  constexpr int kParts = 3;
  const std::array<Part, kParts> parts{{{"world", parameters.world},
                                        {"pad's picture", parameters.pad_texture},
                                        {"vehicle", parameters.vehicle}}};
  const AdditionsModel additions = MakeAdditions(parameters.additions);
  const cv::Mat pad = parameters.pad_picture.empty() ? cv::Mat() : TexturePicture(parameters.pad_picture);
  CompiledModel whole = Compose(parameters, additions, pad, kParts);
  if (!whole.model) {
    // MuJoCo does not say which file: the first part without which it would have compiled.
    int at_fault = 1;
    while (at_fault < kParts && Compose(parameters, additions, pad, at_fault).model) ++at_fault;
    if (at_fault == 1 && !parameters.additions.meshes.empty() && Compose(parameters, {}, pad, at_fault).model)
      throw std::runtime_error(fmt::format("The meshes of the world do not load: {}.", whole.message));
    const Part& part = parts[static_cast<std::size_t>(at_fault - 1)];
    throw std::runtime_error(
        fmt::format("The {} {} does not load: {}.", part.what, part.path.string(), whole.message));
  }
  CheckGround(whole.model.get(), parameters);
  if (Find(whole.model.get(), mjOBJ_BODY, "vehicle") < 0)
    throw std::runtime_error(
        fmt::format("The vehicle {} has no body named \"vehicle\".", parameters.vehicle.string()));
  if (parameters.landscape && paint)
    PaintLandscape(*parameters.landscape, parameters.seed, whole.model.get());
  if (paint) PaintAdditions(additions, whole.model.get());
  if (paint && !pad.empty() && !parameters.pad_texture.empty()) PaintPad(pad, whole.model.get());
  whole.model->opt.timestep = kTimestep_s;
  whole.model->opt.gravity[0] = whole.model->opt.gravity[1] = 0;
  whole.model->opt.gravity[2] = -kGravity_m_s2;
  return std::move(whole.model);
}

DataPtr MakeData(const mjModel* model) {
  DataPtr data(mj_makeData(model));
  if (!data) throw std::runtime_error("There is no memory for the state of the simulation.");
  return data;
}

Pose PadPose(const mjModel* model, const mjData* data) {
  const int pad = Find(model, mjOBJ_BODY, "pad");
  const mjtNum* const q = data->xquat + 4 * pad;
  return {SwapNedNwu(Eigen::Quaterniond(q[0], q[1], q[2], q[3])), VectorFromMujoco(data->xpos + 3 * pad)};
}

void PlaceTarget(const mjModel* model, mjData* data, std::size_t index, const TargetPath& path) {
  const int mocap = model->body_mocapid[Find(model, mjOBJ_BODY, TargetName(index).c_str())];
  // The string is the lower half of the body's vertical.
  const Eigen::Vector3d down = path.anchor_N() - path.p_N();
  mjtNum qpos[7];
  PoseToMujoco({Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), down), path.p_N()}, qpos);
  std::copy(qpos, qpos + 3, data->mocap_pos + 3 * mocap);
  std::copy(qpos + 3, qpos + 7, data->mocap_quat + 4 * mocap);
}

void PlaceDeck(const mjModel* model, mjData* data, const DeckMotion& motion) {
  const int body = Find(model, mjOBJ_BODY, "pad"), joint = model->body_jntadr[body];
  mjtNum* const qvel = data->qvel + model->jnt_dofadr[joint];
  PoseToMujoco(motion.X_NT, data->qpos + model->jnt_qposadr[joint]);
  VectorToMujoco(motion.v_N, qvel);
  VectorToMujoco(motion.X_NT.R.conjugate() * motion.w_N, qvel + 3);
  mjtNum* const push = data->xfrc_applied + 6 * body;
  VectorToMujoco(kDeckMass_kg * (motion.a_N - Eigen::Vector3d(0, 0, kGravity_m_s2)), push);
  VectorToMujoco(kDeckMass_kg * motion.dw_N, push + 3);  // a ball's inertia has no gyroscopic torque
}

void PlaceBlind(const mjModel* model, mjData* data, const Pose& X_NQ) {
  const int mocap = model->body_mocapid[Find(model, mjOBJ_BODY, "blind")];
  mjtNum qpos[7];
  PoseToMujoco(X_NQ, qpos);
  std::copy(qpos, qpos + 3, data->mocap_pos + 3 * mocap);
  std::copy(qpos + 3, qpos + 7, data->mocap_quat + 4 * mocap);
}

void PlaceOccluder(const mjModel* model, mjData* data, const Pose& X_NT, double share) {
  const int body = Find(model, mjOBJ_BODY, "occluder");
  if (body < 0) throw std::runtime_error("The scene has no occluder to place.");
  if (!(share >= 0 && share <= 1))
    throw std::runtime_error(fmt::format("The occluder cannot cover a share of {}: 0 to 1.", share));
  const double length = 2 * model->geom_size[3 * Find(model, mjOBJ_GEOM, "occluder")];
  const double height = share > 0 ? kOccluderClearance_m + kOccluderThickness_m / 2 : -kOutOfSight_m;
  const Pose X_NO = X_NT * Pose{Eigen::Quaterniond::Identity(), {(1 - share) * length, 0, -height}};
  mjtNum qpos[7];
  PoseToMujoco(X_NO, qpos);
  const int mocap = model->body_mocapid[body];
  std::copy(qpos, qpos + 3, data->mocap_pos + 3 * mocap);
  std::copy(qpos + 3, qpos + 7, data->mocap_quat + 4 * mocap);
}

}  // namespace kestrel::sim
