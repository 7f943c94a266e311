// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "control/wire/mavlink_dialects.h"

namespace kestrel::sim {

// The parameters of an emulated autopilot, by their names in PX4 or ArduPilot (Copter): those that the emulation
// goes by and can be set, and those that say what it is. Units are the autopilot's own, in its list.
class MavlinkParameters {
 public:
  MavlinkParameters(const control::wire::mavlink::Dialect& dialect, int system, int component, int type);

  // What it goes by, in SI units.
  double setpoint_timeout_s() const;
  double no_take_off_s() const;      // armed for so long without one, it disarms
  double landing_m_s() const;        // sinking to land
  double return_height_m() const;    // above home
  double take_off_height_m() const;  // PX4's least, and where none is told
  // What PX4 does when setpoints stop: 3 returns, 4 lands, 5 holds; of ArduPilot 5.
  int on_setpoint_loss() const;

  std::vector<control::wire::mavlink::ParamValue> All() const;
  // With what is to be said in words, if anything, as to a name that it has not; then no value.
  struct Answer {
    std::vector<control::wire::mavlink::ParamValue> values;  // one, or none
    std::string text;
  };
  Answer Read(const control::wire::mavlink::ParamRequestRead& request) const;
  // What cannot be set keeps its value, which is the answer.
  Answer Set(const control::wire::mavlink::ParamSet& request);

 private:
  struct Parameter {
    std::string name;
    bool real = false;  // else a whole number
    double value = 0;
    double min = 0, max = 0;  // both 0: it cannot be set
    std::uint8_t type = 0;    // MAV_PARAM_TYPE
  };
  double Value(const char* px4, const char* ardupilot) const;
  control::wire::mavlink::ParamValue ToValue(std::size_t index) const;
  std::size_t Find(const std::string& name) const;  // size(): there is none

  bool px4_;
  std::vector<Parameter> all_;
};

}  // namespace kestrel::sim
