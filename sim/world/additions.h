// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/yaml/fields.h"

namespace kestrel::sim {

// A thing from a file that stands in the world; what is read of the file, ReadMeshFile says.
struct MeshParameters {
  std::string file;
  std::string up = "y";
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  // north, east; of the file's origin
  double height_m = 0;                                   // of the same above the ground
  double yaw_deg = 0;                                    // clockwise from above
  double scale = 1;
  std::string collides = "hull";
};

inline void Fields(FieldVisitor& v, MeshParameters& p) {
  v(Required("file", "mesh with its materials and pictures, OBJ or glTF: .obj, .gltf or .glb"), p.file);
  v({"up",
     "axis of the file that is up: y, with z to the north and x to the west, as glTF has it; or z, with y to "
     "the "
     "north and x to the east"},
    p.up, {"y", "z"});
  v({"position_m", "position of the file's origin: north, east"}, p.position_m, -1e4, 1e4);
  v({"height_m", "height of the file's origin above the ground"}, p.height_m, -1e3, 1e3);
  v({"yaw_deg", "by how much it is turned, clockwise as seen from above"}, p.yaw_deg, -360.0, 360.0);
  v({"scale", "factor of its size: 0.001 for a file in millimetres"}, p.scale, 1e-6, 1e6);
  v({"collides",
     "what of it stands in the way: its convex hull, its box (both of the whole file), or nothing"},
    p.collides, {"hull", "box", "none"});
}

// A photo from straight above, or an orthophoto, that lies on the ground.
struct GroundPhotoParameters {
  std::string file;
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();      // from bottom to top, from left to right
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  // north, east; of its middle
  double yaw_deg = 0;                                    // of its top, clockwise from north
};

inline void Fields(FieldVisitor& v, GroundPhotoParameters& p) {
  v(Required("file", "image that is laid on the ground"), p.file);
  v(Required("size_m", "size on the ground: from bottom to top (north), from left to right (east)"), p.size_m,
    0.01, 2e4);
  v({"position_m", "position of its middle: north, east"}, p.position_m, -1e4, 1e4);
  v({"yaw_deg", "direction of its top, clockwise from north"}, p.yaw_deg, -360.0, 360.0);
}

// What is put into a world beside what its own file has.
struct WorldAdditions {
  std::vector<MeshParameters> meshes;  // their files as found
  std::optional<GroundPhotoParameters> ground_photo;
  bool endless = false;  // the plane "ground" reaches 50 km to each side: to the horizon
};

// For the compiler of MuJoCo: an element <mujoco>, and the files that it names. The pictures are still to be
// painted.
struct AdditionsModel {
  std::string mjcf;
  std::map<std::string, std::string> files;
  std::vector<std::pair<std::string, cv::Mat>> textures;  // by name: CV_8UC3, red, green, blue
};

// Throws std::runtime_error with one sentence that names the file at fault and the remedy.
AdditionsModel MakeAdditions(const WorldAdditions& additions);
void PaintAdditions(const AdditionsModel& additions, mjModel* model);

}  // namespace kestrel::sim
