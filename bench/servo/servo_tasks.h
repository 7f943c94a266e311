// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/pinhole.h"

// The canonical tasks on which Gans, Corke and Hutchinson (ICRA 2002) compare servo laws: a free-flying
// camera without dynamics, exact measurements, a target of four points in a plane.
namespace kestrel::bench {

struct ServoTask {
  std::string name;
  Pose X_TC_start, X_TC_goal;  // T: the target's plane is z = 0, seen from z < 0
};
// Turns about the optical axis of 30 to 180 degrees; along it, away and near; turns of the target's plane
// about a line in it; all together.
std::vector<ServoTask> ServoTasks();

enum class ServoLaw {
  kPointsCurrent,    // eq. (5.6)
  kPointsDesired,    // with the depths of the goal
  kPointsMean,       // the mean of both matrices
  kBearingsCurrent,  // points of the unit sphere
  kPoseTarget,       // eq. (5.11)
  kPose,             // eq. (5.13)
};
std::vector<ServoLaw> ServoLaws();
const char* NameOf(ServoLaw law);

enum class ServoEnd {
  kConverged,  // every point within 1 px of its goal, to the end of the run
  kRetreated,  // the camera is a hundred times as far away as its start and goal
  kCrossed,    // a point has gone behind the camera
  kStalled,    // it stands still away from the goal
  kTimeOut,
};
const char* NameOf(ServoEnd end);

struct ServoTrialOptions {
  vision::Pinhole camera;
  double lambda_per_s = 1;
  double period_s = 0.02;
  double limit_s = 30;
  double half_side_m = 0.25;  // of the square of points
};

struct ServoTrial {
  ServoEnd end = ServoEnd::kTimeOut;
  double converged_s = 0;   // from then on within 1 px; only where it converged
  double final_px = 0;      // RMS of the points at the end of the run
  double excursion_px = 0;  // largest distance of a point from the middle of the image
  bool in_view = true;      // all points, all the time
  double retreat_m = 0;     // largest, along the axis of the goal's camera, behind both start and goal
};

// Flies a task: at each period the law is given the exact features, depths or pose, and the camera moves with
// the twist it answers.
ServoTrial FlyServoTask(const ServoTask& task, ServoLaw law, const ServoTrialOptions& options);

}  // namespace kestrel::bench
