// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <variant>
#include <vector>

#include "base/yaml/yaml_fields.h"
#include "scenarios/attitude/attitude.h"
#include "scenarios/avoid/avoid.h"
#include "scenarios/follow/follow.h"
#include "scenarios/gyro_failure/gyro_failure.h"
#include "scenarios/hover/hover.h"
#include "scenarios/landing/landing.h"
#include "scenarios/pose/pose.h"
#include "vision/camera/camera_mount.h"
#include "vision/landmark/pad_reference.h"

namespace kestrel {

// The flights that there are, by the name of their mission: a new one is a folder and its name here.
using Flight = std::variant<PoseFlight, HoverFlight, LandingFlight, AttitudeFlight, GyroFailureFlight,
                            FollowFlight, AvoidFlight>;

std::vector<std::string> MissionNames();
void SelectFlight(const std::string& mission,
                  Flight& flight);  // with its defaults, unless it is that one already

// Whether a flight looks for the pad: all do that do not say otherwise, by a constant kPadless.
bool LooksForPad(const Flight& flight);

// What flight code is made from, in the simulator as on a real aircraft.
struct FlightParts {
  Flight flight;
  PilotParameters pilot;  // of a flight that looks for the pad
  CameraModel camera;
  Pose X_BC;
  PadReference pad;        // the same
  cv::Mat own_parts;       // of the others: where the camera sees the aircraft itself, CV_8U, 255 there
  std::uint64_t seed = 1;  // of a pilot who is made up
};

std::unique_ptr<Mission> MakeMission(const FlightParts& parts);

// What each number of a flight allows and their sum does not, or not with this camera. where: the file, for
// what it does not say itself. All of it is a mistake before anything starts.
void CheckFlight(const Flight& flight, bool colour, const Config& config, const std::string& where,
                 Mistakes& mistakes);
void CheckView(const Flight& flight, const std::string& camera_name, const CameraModel& camera,
               const CameraMount& mount, const Config& config, const std::string& where, Mistakes& mistakes);
void CheckHasPad(const Flight& flight, const Config& config, const std::string& where, Mistakes& mistakes);

}  // namespace kestrel
