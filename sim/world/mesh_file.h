// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "sim/landscape/mesh.h"

namespace kestrel::sim {

// What of a file is drawn alike.
struct MeshPart {
  landscape::Mesh mesh;  // in M, the file's origin at its origin
  Eigen::Vector4f rgba = Eigen::Vector4f::Ones();
  int texture = -1;  // none: -1
};

// A mesh with its materials: what each looks like lit, which is its base colour and the picture that this is
// multiplied by. What else materials have (gloss, bumps, light of their own, pictures' transparency) is not
// drawn.
struct MeshFile {
  std::vector<MeshPart> parts;
  std::vector<cv::Mat> textures;  // CV_8UC3: red, green, blue; sides as those of TexturePicture
};
inline constexpr std::size_t kMaxMeshTriangles = 1'000'000;

// OBJ, glTF 1 and 2 (.obj, .gltf, .glb), in metres. up: "y", as glTF has it and OBJ mostly: y up, z north, x west; "z":
// z up, y north, x east. A triangle without normals is flat. OBJ is seen from both sides, and of glTF what
// says so. Throws std::runtime_error: the file is not there or damaged, it has no triangle or more than
// kMaxMeshTriangles, a picture is missing; it names the file and the remedy.
MeshFile ReadMeshFile(const std::filesystem::path& file, const std::string& up);

}  // namespace kestrel::sim
