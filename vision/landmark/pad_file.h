// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "vision/landmark/pad_reference.h"
#include "vision/tag/tag.h"

namespace kestrel::vision {

// A landing pad: a thin box with a picture on its top, any picture or one that is made of tags. The top of the
// picture is at +x of the pad.
struct PadParameters {
  Eigen::Vector2d size_m = {1.19, 0.91};
  std::string texture;
  std::vector<Tag> tags;
};

inline void Fields(FieldVisitor& v, PadParameters& p) {
  v({"size_m", "height and width of the pad's picture, which are along x and y of the pad"}, p.size_m, 0.05,
    20.0);
  v({"texture", "file of the picture beside this file: PNG, JPEG or another image, of any size"}, p.texture);
  v({"tags",
     "instead of a picture, tags on white: a single one, a board of many, or small ones in large ones"},
    p.tags);
}

struct PadFile {
  PadParameters parameters;
  std::filesystem::path texture;  // the file of its picture; of tags the pad's own
  cv::Mat picture;                // CV_8UC1 or CV_8UC3, for a renderer
  PadReference reference;
};

// The pad of a YAML file with PadParameters. With any mistake it is not to be used.
PadFile LoadPad(const std::filesystem::path& file, Mistakes& mistakes);

// A picture as a pad, or why it cannot be one: it is too small, or of one colour. where, key: of its mistakes.
PadReference ReferenceOfPicture(const cv::Mat& grey, const Eigen::Vector2d& size_m, const std::string& name,
                                const Place& where, const std::string& key, Mistakes& mistakes);

}  // namespace kestrel::vision
