// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "sim/gltf/mesh.h"

namespace kestrel::sim::gltf {

// A glTF 2.0 file in the making. What each Add gives back is the index by which the rest of the file names it. Colours
// are as they show; the file has them linear, as glTF wants them.
class GltfFile {
 public:
  GltfFile();

  // picture: CV_8UC3, blue first, its first row at t = 0. As JPEG, or where `exact` as PNG whose texels do not mix.
  int AddTexture(const cv::Mat& picture, bool exact);

  // texture: -1: none. emission: of the same colour, beside what it reflects; 1: it takes no light.
  int AddMaterial(const Eigen::Vector4f& rgba, int texture, float emission, bool both_sides);

  // Without normals where its material takes no light. Returns a primitive, for AddMesh.
  nlohmann::json Primitive(const Mesh& mesh, int material);
  int AddMesh(nlohmann::json primitives);
  int AddNode(nlohmann::json node);

  // With this node as the root of its one scene.
  std::string Glb(int root) const;

 private:
  int AddView(const void* bytes, std::size_t size, int target);
  int AddAccessor(int view, int component, std::size_t count, const char* type);

  nlohmann::json json_;
  std::string bytes_;
};

}  // namespace kestrel::sim::gltf
