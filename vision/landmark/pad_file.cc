// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <mutex>
#include <opencv2/imgproc.hpp>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "base/user_file.h"
#include "base/yaml/yaml_fields.h"
#include "vision/image_file.h"

namespace kestrel::vision {
namespace {

// The last pad: its corners take longer to find than all else of a scenario to read, and most flights of a
// process are over the same pad as the one before.
struct Kept {
  std::string bytes;  // of the picture's file, or of the pad's own that names the tags
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();
  cv::Mat picture;
  PadReference reference;
};
std::mutex mutex;
Kept kept;

// Of a picture: smaller shows nothing, and finer is no camera's image of a pad.
constexpr int kMinSide_px = 32, kMaxReferenceSide_px = 4096;
// Of its grey: less is one colour, in the noise of a camera.
constexpr double kMinSigma_grey = 4;

// Whether a renderer takes the grey picture of this PNG file as it is: the file has no colours, and the sides are
// powers of two.
bool IsGreyTexture(const std::string& bytes, const cv::Mat& pixels) {
  constexpr std::size_t kColourType = 25;  // its place in the file
  return bytes.starts_with("\x89PNG") && bytes.size() > kColourType && bytes[kColourType] == 0 &&
         std::has_single_bit(static_cast<unsigned>(pixels.cols)) &&
         std::has_single_bit(static_cast<unsigned>(pixels.rows)) &&
         std::max(pixels.cols, pixels.rows) <= kMaxReferenceSide_px;
}

}  // namespace

PadReference ReferenceOfPicture(const cv::Mat& grey, const Eigen::Vector2d& size_m, const std::string& name,
                                const Place& where, const std::string& key, Mistakes& mistakes) {
  cv::Scalar mean, sigma;
  cv::meanStdDev(grey, mean, sigma);
  if (std::min(grey.cols, grey.rows) < kMinSide_px) {
    mistakes.Add(where, key,
                 fmt::format("'{}' has {} x {} pixels, too few to tell it by", name, grey.cols, grey.rows),
                 fmt::format("valid: sides of at least {}", kMinSide_px));
    return {};
  }
  if (sigma[0] < kMinSigma_grey) {
    mistakes.Add(where, key,
                 fmt::format("'{}' is of one colour: nothing in it can be found or followed", name),
                 "valid: a picture with corners of light and dark");
    return {};
  }
  const double shrink = double{kMaxReferenceSide_px} / std::max(grey.cols, grey.rows);
  cv::Mat smaller = grey;
  if (shrink < 1)
    cv::resize(grey, smaller,
               {static_cast<int>(std::lround(shrink * grey.cols)),
                static_cast<int>(std::lround(shrink * grey.rows))},
               0, 0, cv::INTER_AREA);
  return MakePadReference(smaller, size_m.x(), size_m.y());
}

PadFile LoadPad(const std::filesystem::path& file, Mistakes& mistakes) {
  PadFile pad;
  const std::size_t before = mistakes.all().size();
  const Config config = LoadConfig(file, {}, mistakes);
  PadParameters& parameters = pad.parameters;
  Read(config, parameters, mistakes);
  const bool of_tags = !parameters.tags.empty();
  const Place where = file.string();
  pad.texture = of_tags ? file : file.parent_path() / parameters.texture;
  const auto wrong = [&](const std::string& what, const std::string& remedy = {}) {
    mistakes.Add(where, "texture", fmt::format("'{}' {}", pad.texture.string(), what), remedy);
  };
  if (of_tags && !parameters.texture.empty())
    mistakes.Add(where, "texture", fmt::format("'{}', but the pad is made of tags", parameters.texture),
                 "valid: one of texture and tags");
  if (of_tags)
    CheckTags(parameters.tags, parameters.size_m, WhereOf(config, "tags", where), "tags", mistakes);
  if (of_tags && mistakes.all().size() != before) return pad;
  if (!of_tags && parameters.texture.empty())
    return mistakes.Add(where, "texture", "'' names no picture, and there are no tags", "valid: one of them"),
           pad;
  const FileContent content = ReadUserFile(pad.texture, kMaxDataBytes);
  if (!content.error.empty()) return wrong(content.error), pad;
  {
    const std::lock_guard lock(mutex);
    if (kept.bytes == content.bytes && kept.size_m == parameters.size_m) {
      pad.reference = kept.reference;
      pad.picture = kept.picture;
      return pad;
    }
  }
  cv::Mat grey;
  if (of_tags) {
    pad.picture = grey = DrawTags(parameters.tags, parameters.size_m);
  } else {
    const ImageFile picture = DecodeImage(content.bytes, ImageColours::kGrey);
    if (picture.pixels.empty()) return wrong(picture.error), pad;
    if (picture.pixels.depth() != CV_8U) return wrong("has pixels of 16 bits", "valid: 8"), pad;
    grey = picture.pixels;
    pad.picture =
        IsGreyTexture(content.bytes, grey) ? grey : DecodeImage(content.bytes, ImageColours::kColour).pixels;
  }
  pad.reference = ReferenceOfPicture(grey, parameters.size_m, pad.texture.string(), where,
                                     of_tags ? "tags" : "texture", mistakes);
  pad.reference.tags = parameters.tags;
  if (mistakes.all().size() != before) return pad;
  const std::lock_guard lock(mutex);
  kept = {content.bytes, parameters.size_m, pad.picture, pad.reference};
  return pad;
}

}  // namespace kestrel::vision
