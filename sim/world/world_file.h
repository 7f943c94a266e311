// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/yaml/fields.h"
#include "sim/landscape/landscape.h"
#include "sim/world/additions.h"

namespace kestrel::sim {

// A world in YAML: a landscape, or an MJCF file; and what is put into it.
struct WorldFile {
  std::string model;  // beside it; empty: the landscape
  bool endless = false;
  LandscapeParameters landscape;
  std::vector<MeshParameters> meshes;  // files beside it
  std::optional<GroundPhotoParameters> ground_photo;
};

inline void Fields(FieldVisitor& v, WorldFile& w) {
  v({"model", "MJCF file that the world is made from; empty: the landscape that the other keys make"},
    w.model);
  v({"endless", "whether the plane \"ground\" of the model reaches to the horizon"}, w.endless);
  Fields(v, w.landscape);
  v({"meshes", "things from files that stand in the world"}, w.meshes);
  v({"ground_photo", "photo or orthophoto that lies on the ground; null: none"}, w.ground_photo);
}

}  // namespace kestrel::sim
