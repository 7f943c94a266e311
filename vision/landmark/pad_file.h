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
  Eigen::Vector2d size_m = {1.19, 0.91};  // along x and y of the pad
  std::string texture;                    // a PNG file beside the file that holds these
};

inline void Fields(FieldVisitor& v, PadParameters& p) {
  v("size_m", p.size_m, 0.05, 20.0);
  v("texture", p.texture);
}

struct PadFile {
  PadParameters parameters;
  std::filesystem::path texture;
  PadReference reference;
};

// The pad of a YAML file with PadParameters. With any mistake it is not to be used.
PadFile LoadPad(const std::filesystem::path& file, Mistakes& mistakes);

}  // namespace kestrel::vision
