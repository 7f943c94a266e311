// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {

// A motor where an autopilot's documentation has it, in m forward and to the right, and +1 where it turns counterclockwise.
struct PublishedMotor {
  double x = 0, y = 0;
  int yaw = 1;
};

// Motor 1 and on, as tables by bearing or by factors of roll and pitch have them: ArduPilot's "Connect ESCs and Motors"
// and AP_MotorsMatrix.cpp. arm_m: to each shaft; of a frame on rails half its length and width are 0.8 and 0.6 of it.
inline std::vector<PublishedMotor> PublishedLayout(const std::string& name, double arm_m) {
  struct ByBearing {
    double deg;
    int yaw;
  };
  static const std::map<std::string, std::vector<ByBearing>> by_bearing = {
      {"quad-plus", {{90, 1}, {-90, 1}, {0, -1}, {180, -1}}},
      {"quad-x", {{45, 1}, {-135, 1}, {-45, -1}, {135, -1}}},
      {"hexa-plus", {{0, -1}, {180, 1}, {-120, -1}, {60, 1}, {-60, 1}, {120, -1}}},
      {"hexa-x", {{90, -1}, {-90, 1}, {-30, -1}, {150, 1}, {30, 1}, {-150, -1}}},
      {"octo-plus", {{0, -1}, {180, -1}, {45, 1}, {135, 1}, {-45, 1}, {-135, 1}, {-90, -1}, {90, -1}}},
      {"octo-x",
       {{22.5, -1}, {-157.5, -1}, {67.5, 1}, {157.5, 1}, {-22.5, 1}, {-112.5, 1}, {-67.5, -1}, {112.5, -1}}}};
  // Factors of roll and pitch, which lift the left and the front.
  struct ByFactors {
    double roll, pitch;
    int yaw;
  };
  static const std::map<std::string, std::vector<ByFactors>> by_factors = {
      {"quad-h", {{-1, 1, -1}, {1, -1, -1}, {1, 1, 1}, {-1, -1, 1}}},
      {"hexa-h", {{-1, 0, -1}, {1, 0, 1}, {1, 1, -1}, {-1, -1, 1}, {-1, 1, 1}, {1, -1, -1}}},
      {"octo-h",
       {{-1, 1, -1},
        {1, -1, -1},
        {-1, 0.333, 1},
        {-1, -1, 1},
        {1, 1, 1},
        {1, -0.333, 1},
        {1, 0.333, -1},
        {-1, -0.333, -1}}}};
  std::vector<PublishedMotor> motors;
  if (by_bearing.contains(name))
    for (const ByBearing& m : by_bearing.at(name))
      motors.push_back({arm_m * std::cos(Radians(m.deg)), arm_m * std::sin(Radians(m.deg)), m.yaw});
  else
    for (const ByFactors& m : by_factors.at(name))
      motors.push_back({0.8 * arm_m * m.pitch, -0.6 * arm_m * m.roll, m.yaw});
  return motors;
}

inline std::vector<std::string> PublishedLayoutNames() {
  return {"quad-plus", "quad-x", "quad-h", "hexa-plus", "hexa-x", "hexa-h", "octo-plus", "octo-x", "octo-h"};
}

}  // namespace kestrel::sim
