// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

struct aiTexture;  // of Assimp

namespace kestrel::sim {

// Pictures of meshes, as MeshFile has them. Both throw std::runtime_error with what follows the name of the mesh: what
// is wrong, and the remedy.
cv::Mat EmbeddedTexture(const aiTexture& texture);
// mesh: the file that names it, beside which it lies; upper and lower case may differ.
cv::Mat TextureBeside(const std::filesystem::path& mesh, const std::string& name);

}  // namespace kestrel::sim
