// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "sim/deck/deck.h"
#include "sim/landscape/landscape.h"
#include "sim/world/additions.h"
#include "sim/world/target.h"
#include "vision/aircraft/aircraft_lights.h"
#include "vision/landmark/pad_file.h"

namespace kestrel::sim {

struct ModelDeleter {
  void operator()(mjModel* m) const { mj_deleteModel(m); }
};
struct DataDeleter {
  void operator()(mjData* d) const { mj_deleteData(d); }
};
using ModelPtr = std::unique_ptr<mjModel, ModelDeleter>;
using DataPtr = std::unique_ptr<mjData, DataDeleter>;

struct SceneParameters {
  std::filesystem::path world;  // MJCF, or the file that describes a landscape, with a plane "ground": level,
                                // at height 0, x north, y west
  std::filesystem::path vehicle;  // MJCF or a fragment of it (<mujocoinclude>) with one body "vehicle"
  std::optional<LandscapeParameters> landscape;  // instead of the MJCF of the world
  std::uint64_t seed = 1;                        // of the landscape that has none of its own
  std::filesystem::path pad_texture;             // none: there is no pad to be seen, only its place
  cv::Mat pad_picture;        // of any size, CV_8UC1 or CV_8UC3; none: the texture is read as it is
  vision::PadParameters pad;  // its texture is not used: pad_texture is the file found
  Eigen::Vector2d pad_position_m = Eigen::Vector2d::Zero();  // north, east; of the middle of its back
  double pad_yaw_deg = 0;                                    // clockwise from north
  double pad_height_m = 0;                                   // of the middle of its back
  double pad_tilt_deg = 0;  // raises the top of its picture; 90: it hangs on a wall
  // Beside that, as it lies on uneven ground: about the up and the right of its picture. Its middle is so much
  // higher that no corner is in the ground.
  Eigen::Vector2d pad_lean_deg = Eigen::Vector2d::Zero();
  std::optional<DeckParameters> deck;                 // the pad lies on a deck that moves
  bool occluder = false;                              // with a dark sheet that can be put over the pad
  std::vector<TargetParameters> targets = {};         // what they look like
  std::optional<vision::AircraftLights> lights = {};  // on the vehicle, without mass; none: it has none
  bool blind = false;                                 // with a sheet that can be put before a lens
  WorldAdditions additions = {};                      // to the world
  std::string vehicle_shape = {};  // a fragment as the vehicle's file would hold, in its place
};

// The MuJoCo model of a flight: world, vehicle and pad, stepped at 2 ms under 9.80665 m/s2. Names of files
// within the world and the vehicle are relative to the file they stand in. The pad is a body and a geom
// "pad", its face 1 cm before its back, which lies on the ground unless it is raised or tilted; without a
// picture the body has no geom and is where the back would be. On a deck the pad is a free body with a plate below
// it that nothing but the vehicle touches; its joint comes after the vehicle's. Throws
// std::runtime_error with one sentence that names the file at fault. May be called on any thread. paint: a
// landscape's pictures too, which take longer than all the rest.
ModelPtr MakeModel(const SceneParameters& parameters, bool paint = true);
DataPtr MakeData(const mjModel* model);

// X_NT: origin in the middle of the pad's face, x along the up of its picture, y to the right of it, z into
// it: down where it lies. Valid once the positions of data are computed (mj_kinematics, mj_forward or
// mj_step).
Pose PadPose(const mjModel* model, const mjData* data);

// Puts a target there, with its string to its anchor. It shows once the positions of data are computed again.
void PlaceTarget(const mjModel* model, mjData* data, std::size_t index, const TargetPath& path);

// Moves the pad that is a deck: its state, and the force that gives it its acceleration in the next step.
void PlaceDeck(const mjModel* model, mjData* data, const DeckMotion& motion);

// Puts the middle of the blind there, a dark sheet across z of X_NQ; far below the ground it is out of sight. It
// shows once the positions of data are computed again. Only of a model that has one.
void PlaceBlind(const mjModel* model, mjData* data, const Pose& X_NQ);

// Puts the occluder 3 cm above the pad, which is at X_NT, over the given share of it (0 to 1) from its +x end; at 0 it is out
// of sight. It shows once the positions of data are computed again. Throws std::runtime_error if the model
// has none.
void PlaceOccluder(const mjModel* model, mjData* data, const Pose& X_NT, double share);

}  // namespace kestrel::sim
