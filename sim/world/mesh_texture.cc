// SPDX-License-Identifier: Apache-2.0
#include "sim/world/mesh_texture.h"

#include <assimp/texture.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>

#include "base/user_file.h"
#include "sim/world/texture.h"
#include "vision/image_file.h"

namespace kestrel::sim {
namespace {

namespace fs = std::filesystem;

cv::Mat Rgb(const cv::Mat& bgr) {
  cv::Mat rgb;
  cv::cvtColor(TexturePicture(bgr), rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

// A file of a name in whatever case: many were written where case does not count.
std::optional<fs::path> InAnyCase(const fs::path& wanted) {
  if (IsFile(wanted)) return wanted;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(wanted.parent_path(), error))
    if (Lower(entry.path().filename()) == Lower(wanted.filename()) && IsFile(entry.path()))
      return entry.path();
  return std::nullopt;
}

// "%20" and the like of an address.
std::string Unescaped(const std::string& name) {
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (name[i] == '%' && i + 2 < name.size() && std::isxdigit(static_cast<unsigned char>(name[i + 1])) &&
        std::isxdigit(static_cast<unsigned char>(name[i + 2]))) {
      out += static_cast<char>(std::stoi(name.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      out += name[i];
    }
  }
  return out;
}

}  // namespace

cv::Mat EmbeddedTexture(const aiTexture& texture) {
  if (texture.mHeight > 0) {  // pixels as they are
    const cv::Mat bgra(static_cast<int>(texture.mHeight), static_cast<int>(texture.mWidth), CV_8UC4,
                       texture.pcData);
    cv::Mat bgr;
    cv::cvtColor(bgra, bgr, cv::COLOR_BGRA2BGR);
    return Rgb(bgr);
  }
  const vision::ImageFile image =
      vision::DecodeImage(std::string(reinterpret_cast<const char*>(texture.pcData), texture.mWidth),
                          vision::ImageColours::kColour);
  if (image.pixels.empty())
    throw std::runtime_error(
        fmt::format("holds the picture '{}', which {}", texture.mFilename.C_Str(), image.error));
  return Rgb(image.pixels);
}

cv::Mat TextureBeside(const fs::path& mesh, const std::string& name) {
  std::string plain = name;
  std::replace(plain.begin(), plain.end(), '\\', '/');
  for (const std::string& each : {plain, Unescaped(plain), fs::path(plain).filename().string()}) {
    const auto file = InAnyCase(mesh.parent_path() / each);
    if (!file) continue;
    const vision::ImageFile image = vision::ReadImageFile(*file, vision::ImageColours::kColour);
    if (image.pixels.empty())
      throw std::runtime_error(fmt::format("needs the picture {}, which {}", file->string(), image.error));
    return Rgb(image.pixels);
  }
  throw std::runtime_error(fmt::format("needs the picture '{}', which is not there; valid: beside it, in {}",
                                       name, fs::absolute(mesh).parent_path().string()));
}

}  // namespace kestrel::sim
