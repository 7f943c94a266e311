// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/motor_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr int kFront = 0, kRight = 1, kBack = 2, kLeft = 3;
constexpr Spin kCw = Spin::kClockwise, kCcw = Spin::kCounterclockwise;

constexpr std::array<MotorLayout, 2> kLayouts = {
    {{"quad-plus", {{{90, kCcw, kRight}, {-90, kCcw, kLeft}, {0, kCw, kFront}, {180, kCw, kBack}}}, 0},
     {"quad-x", {{{45, kCcw, kRight}, {-135, kCcw, kLeft}, {-45, kCw, kFront}, {135, kCw, kBack}}}, 45}}};

}  // namespace

std::span<const MotorLayout> MotorLayouts() { return kLayouts; }

double ThrustShare(double command, double curvature) {
  const double u = std::isfinite(command) ? std::clamp(command, 0.0, 1.0) : 0;
  return (1 - curvature) * u + curvature * u * u;
}

MotorMapping::MotorMapping(const std::string& layout, const AirframeParameters& aircraft) {
  const auto* found = std::ranges::find_if(kLayouts, [&](const MotorLayout& l) { return layout == l.name; });
  if (found == kLayouts.end()) throw std::runtime_error(fmt::format("{}: no layout of motors", layout));
  const auto* multirotor = std::get_if<MultirotorParameters>(&aircraft);
  if (multirotor == nullptr)
    throw std::runtime_error("an autopilot's motors turn the rotors of a multirotor; this aircraft is none");
  if (!multirotor->rotors.empty())
    throw std::runtime_error(
        "an autopilot's motors are known for four rotors in plus, without a list of rotors; this aircraft "
        "lists its rotors");
  layout_ = *found;
  max_speed_rad_s_ = multirotor->rotor.max_speed_rad_s;
  R_BA_ = HeadingRotation(Radians(layout_.yaw_deg));
}

Actuation MotorMapping::Speeds(const std::array<double, 4>& commands, double curvature) const {
  RotorSpeeds speeds{};
  for (std::size_t i = 0; i < commands.size(); ++i) {
    speeds[static_cast<std::size_t>(layout_.motors[i].rotor)] =
        max_speed_rad_s_ * std::sqrt(ThrustShare(commands[i], curvature));
  }
  return speeds;
}

}  // namespace kestrel::sim
