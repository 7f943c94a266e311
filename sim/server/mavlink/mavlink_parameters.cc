// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink/mavlink_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/printable.h"

namespace kestrel::sim {
namespace {

using namespace control::wire::mavlink;

// MAV_PARAM_TYPE
constexpr std::uint8_t kInt8 = 2, kInt16 = 4, kInt32 = 6, kReal32 = 9;

std::string IdText(const std::array<char, 16>& id) {
  return Printable({id.begin(), std::find(id.begin(), id.end(), '\0')});
}

}  // namespace

MavlinkParameters::MavlinkParameters(const Dialect& dialect, int system, int component, int type)
    : px4_(&dialect == &kPx4) {
  constexpr int kHelicopter = 4;
  const auto whole = [&](const char* name, std::uint8_t kind, double value, double min = 0, double max = 0) {
    all_.push_back({name, false, value, min, max, kind});
  };
  const auto real = [&](const char* name, double value, double min, double max) {
    all_.push_back({name, true, value, min, max, kReal32});
  };
  if (px4_) {  // in the order of the alphabet, as PX4 has them
    real("COM_DISARM_PRFLT", 10, 1, 300);
    whole("COM_OBL_RC_ACT", kInt32, 5, 3, 5);
    real("COM_OF_LOSS_T", dialect.setpoint_timeout_s, 0.1, 60);
    whole("MAV_COMP_ID", kInt32, component);
    whole("MAV_SYS_ID", kInt32, system);
    whole("MAV_TYPE", kInt32, type);
    real("MIS_TAKEOFF_ALT", 2.5, 0.5, 80);
    real("MPC_LAND_SPEED", 0.5, 0.1, 2);
    real("RTL_RETURN_ALT", 60, 1, 150);
  } else {
    whole("DISARM_DELAY", kInt8, 10, 1, 127);
    whole("FRAME_CLASS", kInt8, type == kHelicopter ? 6 : 1);
    whole("GUID_OPTIONS", kInt32, 8);  // thrust is thrust
    real("GUID_TIMEOUT", dialect.setpoint_timeout_s, 0.1, 5);
    whole("LAND_SPEED", kInt16, 50, 30, 200);
    whole("RTL_ALT", kInt32, 1500, 100, 15000);
    whole("SYSID_THISMAV", kInt16, system);
  }
}

double MavlinkParameters::Value(const char* px4, const char* ardupilot) const {
  return all_[Find(px4_ ? px4 : ardupilot)].value;
}

double MavlinkParameters::setpoint_timeout_s() const { return Value("COM_OF_LOSS_T", "GUID_TIMEOUT"); }
double MavlinkParameters::no_take_off_s() const { return Value("COM_DISARM_PRFLT", "DISARM_DELAY"); }
double MavlinkParameters::landing_m_s() const {
  return (px4_ ? 1 : 0.01) * Value("MPC_LAND_SPEED", "LAND_SPEED");
}
double MavlinkParameters::return_height_m() const {
  return (px4_ ? 1 : 0.01) * Value("RTL_RETURN_ALT", "RTL_ALT");
}
double MavlinkParameters::take_off_height_m() const { return px4_ ? all_[Find("MIS_TAKEOFF_ALT")].value : 0; }
int MavlinkParameters::on_setpoint_loss() const {
  return px4_ ? static_cast<int>(all_[Find("COM_OBL_RC_ACT")].value) : 5;
}

std::size_t MavlinkParameters::Find(const std::string& name) const {
  return static_cast<std::size_t>(std::ranges::find(all_, name, &Parameter::name) - all_.begin());
}

ParamValue MavlinkParameters::ToValue(std::size_t index) const {
  const Parameter& p = all_[index];
  ParamValue message{.param_count = static_cast<std::uint16_t>(all_.size()),
                     .param_index = static_cast<std::uint16_t>(index),
                     .param_type = p.type};
  std::ranges::copy(p.name, message.param_id.begin());
  // PX4 sends the bytes of a whole number, ArduPilot the number.
  message.param_value = px4_ && !p.real ? std::bit_cast<float>(static_cast<std::int32_t>(p.value))
                                        : static_cast<float>(p.value);
  return message;
}

std::vector<ParamValue> MavlinkParameters::All() const {
  std::vector<ParamValue> all;
  for (std::size_t i = 0; i < all_.size(); ++i) all.push_back(ToValue(i));
  return all;
}

MavlinkParameters::Answer MavlinkParameters::Read(const ParamRequestRead& request) const {
  if (request.param_index >= 0) {
    const auto index = static_cast<std::size_t>(request.param_index);
    if (index < all_.size()) return {{ToValue(index)}, {}};
    return {{}, fmt::format("no parameter number {}", index)};
  }
  const std::string name = IdText(request.param_id);
  const std::size_t index = Find(name);
  if (index < all_.size()) return {{ToValue(index)}, {}};
  return {{}, "no parameter " + name};
}

MavlinkParameters::Answer MavlinkParameters::Set(const ParamSet& request) {
  const std::string name = IdText(request.param_id);
  const std::size_t index = Find(name);
  if (index == all_.size()) return {{}, "no parameter " + name};
  Parameter& p = all_[index];
  const bool bytes = px4_ && request.param_type != kReal32;
  const double value = bytes ? static_cast<double>(std::bit_cast<std::int32_t>(request.param_value))
                             : static_cast<double>(request.param_value);
  std::string text;
  if (px4_ && request.param_type != p.type) {
    text = name + ": another type than its own";
  } else if (p.max <= p.min) {
    if (value != p.value) text = name + " cannot be set";
  } else if (!(value >= p.min && value <= p.max)) {
    text = fmt::format("{}: {:g} to {:g}, not {:g}", name, p.min, p.max, value);
  } else {
    p.value = p.real ? value : std::round(value);
  }
  return {{ToValue(index)}, text};
}

}  // namespace kestrel::sim
