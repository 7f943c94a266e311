// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "control/law/avoidance.h"
#include "geometry/pose.h"
#include "mission/balloon_watch.h"
#include "mission/mission.h"
#include "scenarios/avoid/contrast_watch.h"
#include "vision/camera/camera_model.h"

namespace kestrel {

// Thesis 6.4: on the way along a straight course the aircraft sees others by the coloured marks that they
// carry or by their contrast with the sky, passes them at a bearing that it holds them at (6.29), and returns
// to its course: what the thesis left open.
struct AvoidFlight {
  static constexpr const char* kName = "avoid";
  static constexpr bool kPadless = true, kLooksForColour = true;
  double speed_m_s = 0.5;
  double course_m = 20;     // straight ahead from where the flight begins
  bool avoids = true;       // false: it flies on whatever it sees
  double memory_s = 8;      // who has not been seen for longer is forgotten
  double confirm_s = 0.25;  // a threat must last for so long before anything is done
  // Of the distance that the least bearing allows from where a manoeuvre begins: kept on the way past and
  // back. 0: safe_m alone counts.
  double keep_share = 0;
  double cross_track_gain_per_s = 0.5;
  std::vector<BalloonWatchParameters> marks{BalloonWatchParameters{}};
  std::optional<ContrastWatchParameters> contrast;  // none: marks alone are looked for
  AvoidanceOptions avoidance;
};

template <class Visitor>
void Fields(Visitor& v, AvoidFlight& p) {
  v("speed_m_s", p.speed_m_s, 0.1, 15.0);
  v("course_m", p.course_m, 1.0, 5000.0);
  v("avoids", p.avoids);
  v("memory_s", p.memory_s, 0.3, 60.0);
  v("confirm_s", p.confirm_s, 0.0, 5.0);
  v("keep_share", p.keep_share, 0.0, 1.0);
  v("cross_track_gain_per_s", p.cross_track_gain_per_s, 0.05, 2.0);
  v("marks", p.marks);
  v("contrast", p.contrast);
  v("avoidance", p.avoidance);
}

std::unique_ptr<Mission> MakeMission(const AvoidFlight& flight, const CameraModel& camera, const Pose& X_BC,
                                     const cv::Mat& forbidden, std::uint64_t seed);

}  // namespace kestrel
