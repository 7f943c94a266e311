// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "vision/landmark/pad_reference.h"

namespace kestrel::vision {

// A landing pad: a thin box with a picture on its top. The top of the picture is at +x of the pad.
struct PadParameters {
  Eigen::Vector2d size_m = {1.19, 0.91};
  std::string texture;
};

inline void Fields(FieldVisitor& v, PadParameters& p) {
  v({"size_m", "height and width of the pad's picture, which are along x and y of the pad"}, p.size_m, 0.05,
    20.0);
  v({"texture", "PNG file of the picture beside this file; its sides are powers of two pixels"}, p.texture);
}

struct PadFile {
  PadParameters parameters;
  std::filesystem::path texture;
  PadReference reference;
};

// The pad of a YAML file with PadParameters. With any mistake it is not to be used.
PadFile LoadPad(const std::filesystem::path& file, Mistakes& mistakes);

}  // namespace kestrel::vision
