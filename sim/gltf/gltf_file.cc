// SPDX-License-Identifier: Apache-2.0
#include "sim/gltf/gltf_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <utility>
#include <vector>

namespace kestrel::sim::gltf {
namespace {

using Json = nlohmann::json;

// Of the specification: component types, targets, filters.
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kVertices = 34962, kIndices = 34963, kNoTarget = 0;
constexpr int kNearest = 9728, kClampToEdge = 33071;
constexpr int kJpegQuality = 75;

float Linear(float shown) {
  return shown <= 0.04045f ? shown / 12.92f : std::pow((shown + 0.055f) / 1.055f, 2.4f);
}

int Append(Json& list, Json item) {
  list.push_back(std::move(item));
  return static_cast<int>(list.size()) - 1;
}

void Pad(std::string& bytes, char with) { bytes.resize((bytes.size() + 3) / 4 * 4, with); }

void PutWord(std::string& bytes, std::size_t word) {
  for (int k = 0; k < 4; ++k) bytes += static_cast<char>(word >> (8 * k) & 0xff);
}

}  // namespace

GltfFile::GltfFile() { json_ = {{"asset", {{"version", "2.0"}, {"generator", "Kestrel"}}}}; }

int GltfFile::AddView(const void* bytes, std::size_t size, int target) {
  Pad(bytes_, '\0');
  Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
  if (target != kNoTarget) view["target"] = target;
  bytes_.append(static_cast<const char*>(bytes), size);
  return Append(json_["bufferViews"], std::move(view));
}

int GltfFile::AddAccessor(int view, int component, std::size_t count, const char* type) {
  return Append(json_["accessors"],
                {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
}

int GltfFile::AddTexture(const cv::Mat& picture, bool exact) {
  std::vector<unsigned char> file;
  if (exact)
    cv::imencode(".png", picture, file);
  else
    cv::imencode(".jpg", picture, file, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  const int view = AddView(file.data(), file.size(), kNoTarget);
  const int image =
      Append(json_["images"], {{"bufferView", view}, {"mimeType", exact ? "image/png" : "image/jpeg"}});
  Json texture = {{"source", image}};  // it repeats, unless it is said otherwise
  if (exact)
    texture["sampler"] = Append(
        json_["samplers"],
        {{"magFilter", kNearest}, {"minFilter", kNearest}, {"wrapS", kClampToEdge}, {"wrapT", kClampToEdge}});
  return Append(json_["textures"], std::move(texture));
}

int GltfFile::AddMaterial(const Eigen::Vector4f& rgba, int texture, float emission, bool both_sides) {
  const Json rgb = {Linear(rgba[0]), Linear(rgba[1]), Linear(rgba[2])};
  Json surface = {{"metallicFactor", 0}, {"roughnessFactor", 1}};
  surface["baseColorFactor"] = rgb;
  surface["baseColorFactor"].push_back(std::clamp(rgba[3], 0.0f, 1.0f));
  if (texture >= 0) surface["baseColorTexture"] = {{"index", texture}};
  Json material = {{"pbrMetallicRoughness", std::move(surface)}};
  if (rgba[3] < 1) material["alphaMode"] = "BLEND";
  if (both_sides) material["doubleSided"] = true;
  if (emission >= 1) {
    material["extensions"]["KHR_materials_unlit"] = Json::object();
    json_["extensionsUsed"] = {"KHR_materials_unlit"};
  } else if (emission > 0) {
    for (const Json& of_one : rgb) material["emissiveFactor"].push_back(emission * of_one.get<float>());
    if (texture >= 0) material["emissiveTexture"] = {{"index", texture}};
  }
  return Append(json_["materials"], std::move(material));
}

Json GltfFile::Primitive(const Mesh& mesh, int material) {
  Json primitive = {{"material", material}};
  const auto add = [&](const char* name, const auto& values, const char* type) {
    const int view = AddView(values.data(), values.size() * sizeof(values[0]), kVertices);
    return primitive["attributes"][name] = AddAccessor(view, kFloat, values.size(), type);
  };
  Json& positions = json_["accessors"][add("POSITION", mesh.positions, "VEC3").get<std::size_t>()];
  Eigen::Vector3f low = mesh.positions.front(), high = low;
  for (const Eigen::Vector3f& p : mesh.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  positions["min"] = {low.x(), low.y(), low.z()};
  positions["max"] = {high.x(), high.y(), high.z()};
  const bool unlit = json_["materials"][static_cast<std::size_t>(material)].contains("extensions");
  if (!unlit) add("NORMAL", mesh.normals, "VEC3");
  if (!mesh.st.empty()) add("TEXCOORD_0", mesh.st, "VEC2");
  std::vector<std::uint16_t> few;
  const bool small = mesh.positions.size() < 65535;
  if (small)
    for (const Eigen::Vector3i& face : mesh.faces)
      for (const int corner : face) few.push_back(static_cast<std::uint16_t>(corner));
  const int view = small ? AddView(few.data(), few.size() * sizeof(few[0]), kIndices)
                         : AddView(mesh.faces.data(), mesh.faces.size() * sizeof(mesh.faces[0]), kIndices);
  primitive["indices"] =
      AddAccessor(view, small ? kUnsignedShort : kUnsignedInt, 3 * mesh.faces.size(), "SCALAR");
  return primitive;
}

int GltfFile::AddMesh(Json primitives) {
  return Append(json_["meshes"], {{"primitives", std::move(primitives)}});
}

int GltfFile::AddNode(Json node) { return Append(json_["nodes"], std::move(node)); }

std::string GltfFile::Glb(int root) const {
  Json json = json_;
  json["scene"] = 0;
  json["scenes"] = {{{"nodes", {root}}}};
  std::string binary = bytes_;
  Pad(binary, '\0');
  json["buffers"] = {{{"byteLength", binary.size()}}};
  std::string text = json.dump();
  Pad(text, ' ');
  std::string glb = "glTF";
  for (const std::size_t word : {std::size_t{2}, 12 + 8 + text.size() + 8 + binary.size(), text.size()})
    PutWord(glb, word);
  glb += "JSON" + text;
  PutWord(glb, binary.size());
  glb += std::string("BIN\0", 4) + binary;
  return glb;
}

}  // namespace kestrel::sim::gltf
