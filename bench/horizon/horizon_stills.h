// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/renderer.h"
#include "sim/camera/skyline/horizon.h"
#include "sim/landscape/landscape.h"
#include "sim/world/scene.h"

// Attitudes without flying: photographs of landscapes from every height and tilt, as the camera of the
// attitude flights would take them.
namespace kestrel::bench {

struct StillLandscape {
  std::string world;
  sim::LandscapeParameters parameters;
};

struct Still {
  int landscape = 0;
  TaitBryan attitude;        // of B
  Eigen::Vector2d place_m;   // north and east of the landscape's origin
  double height_m = 0;       // of B over the ground
  Eigen::Vector2d expected;  // error of the expected "down", towards its first and second side, rad
  double expected_height_m = 0;
};

// All samples of a sweep: drawn before anything is made or measured, so that they depend on the seed alone.
// Landscapes and stills are points of Halton sequences, shifted by the seed (Cranley, Patterson 1976): each
// landscape's stills are a run of the sequence, so that they cover heights and tilts evenly too.
//
// Roll and pitch are even within 45 degrees, heights even in their logarithm from 2 to 500 m, places even
// within 250 m, headings any. Of each world haze, light, sun and ridge vary: haze_m times 0.3 to 1.5, light
// times 0.5 to 1, the sun anywhere and 0.4 to 1.4 times as high, and before seven in ten skylines a ridge of
// up to 10 degrees, 40 to 150 degrees wide, at 2 to 15 km.
struct StillSweep {
  std::vector<StillLandscape> landscapes;
  std::vector<Still> stills;  // by their landscapes
};
// worlds: with a landscape each, as their files have them.
StillSweep DrawSweep(const std::vector<StillLandscape>& worlds, int landscapes_each, int stills_each,
                     std::uint64_t seed);

// What is expected of a still beforehand, as by gyros and a barometer: errors of "down" are normal, of 1.5
// degrees along either side, those of the height of 2 m.
inline constexpr double kExpectedDownSigma = Radians(1.5);  // along one side
inline constexpr double kExpectedHeightSigma_m = 2;

// "Down" in C as a still's own error has it.
Eigen::Vector3d ExpectedDown(const Eigen::Vector3d& down_C, const Still& still);

// One landscape, and the aircraft in it.
class StillRenderer {
 public:
  // scene: of the aircraft, in any landscape.
  StillRenderer(const StillLandscape& landscape, sim::SceneParameters scene,
                const vision::CameraModel& camera, const Pose& X_BC);

  // Where the still is taken from: its place, or where a tree or a house stands there, the next of its own
  // that is free.
  Pose PoseOf(const Still& still, std::uint64_t seed);
  // As the lens has it, before the sensor: CV_8UC3.
  cv::Mat Draw(const Pose& X_NB);

 private:
  bool Free(const Eigen::Vector2d& place_m, double height_m);
  void PutAircraft(const Pose& X_NB);

  sim::ModelPtr model_;
  sim::DataPtr data_;
  Pose X_BC_;
  sim::Renderer renderer_;
};

}  // namespace kestrel::bench
