// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/motor_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr Spin kCw = Spin::kClockwise, kCcw = Spin::kCounterclockwise;
constexpr int kQuad = 1, kHexa = 2, kOcta = 3;  // FRAME_CLASS
constexpr int kPlus = 0, kX = 1, kH = 3;        // FRAME_TYPE
constexpr double kOffPlace =
    std::numbers::pi / 3;           // over the number of motors: a sixth of the angle between two
constexpr double kOffRails = 0.15;  // of half the frame's length and width

// Bearings clockwise from forward.
std::vector<Motor> OnCircle(std::initializer_list<std::pair<double, Spin>> bearings_deg) {
  std::vector<Motor> motors;
  for (const auto& [bearing_deg, spin] : bearings_deg)
    motors.push_back({std::cos(Radians(bearing_deg)), std::sin(Radians(bearing_deg)), spin});
  return motors;
}

Eigen::Vector2d PlaceOf(const RotorLayout& rotors, std::size_t i) { return rotors.hubs_B[i].head<2>(); }

// How a layout's places are had in metres: its units forward and to the right.
Eigen::Array2d SizeOf(const MotorLayout& layout, const RotorLayout& rotors) {
  if (!layout.rails) {
    double sum = 0;
    for (std::size_t i = 0; i < rotors.count; ++i) sum += PlaceOf(rotors, i).norm();
    return Eigen::Array2d::Constant(sum / static_cast<double>(rotors.count));
  }
  Eigen::Array2d size = Eigen::Array2d::Zero();
  for (std::size_t i = 0; i < rotors.count; ++i) size = size.max(PlaceOf(rotors, i).array().abs());
  return size;
}

// A rotor for each motor, the nearest that is left, and how far off the worst one is, in the layout's units.
struct Match {
  const MotorLayout* layout = nullptr;
  Eigen::Array2d size_m;
  std::vector<std::size_t> rotor;
  double worst = 0;
  bool spins = true;

  double Off(std::size_t motor, const RotorLayout& rotors) const {
    const Motor& m = layout->motors[motor];
    return (PlaceOf(rotors, rotor[motor]).array() / size_m - Eigen::Array2d(m.forward, m.right))
        .matrix()
        .norm();
  }
  bool SpinFits(std::size_t motor, const RotorLayout& rotors) const {
    return rotors.spins[rotor[motor]] == layout->motors[motor].spin;
  }
  double limit() const { return layout->rails ? kOffRails : kOffPlace / static_cast<double>(rotor.size()); }
};

std::optional<Match> MatchOf(const MotorLayout& layout, const RotorLayout& rotors) {
  Match match{&layout, SizeOf(layout, rotors), {}};
  if (layout.motors.size() != rotors.count || match.size_m.minCoeff() <= 0) return std::nullopt;
  for (std::size_t motor = 0; motor < rotors.count; ++motor) {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    match.rotor.push_back(0);
    for (std::size_t i = 0; i < rotors.count; ++i) {
      if (std::find(match.rotor.begin(), match.rotor.end() - 1, i) != match.rotor.end() - 1) continue;
      match.rotor.back() = i;
      if (const double off = match.Off(motor, rotors); off < least) least = off, nearest = i;
    }
    match.rotor.back() = nearest;
    match.worst = std::max(match.worst, least);
    match.spins = match.spins && match.SpinFits(motor, rotors);
  }
  return match;
}

struct Matches {
  std::optional<Match> fits, nearest;
};
Matches MatchesOf(const RotorLayout& rotors) {
  Matches matches;
  for (const MotorLayout& layout : MotorLayouts()) {
    const std::optional<Match> match = MatchOf(layout, rotors);
    if (!match) continue;
    if (!matches.nearest || match->worst < matches.nearest->worst) matches.nearest = match;
    if (match->spins && match->worst <= match->limit() &&
        (!matches.fits || match->worst < matches.fits->worst))
      matches.fits = match;
  }
  return matches;
}

std::string Turning(Spin spin) { return spin == kCw ? "clockwise" : "counterclockwise"; }

std::string WhyNot(const Match& nearest, const RotorLayout& rotors) {
  std::string text;
  for (std::size_t motor = 0; motor < nearest.rotor.size(); ++motor) {
    const bool placed = nearest.Off(motor, rotors) <= nearest.limit();
    if (placed && nearest.SpinFits(motor, rotors)) continue;
    const std::size_t i = nearest.rotor[motor];
    const Motor& m = nearest.layout->motors[motor];
    text += fmt::format("{}rotors.{} is at x_m {:.3f}, y_m {:.3f}, {}, and motor {} at {:.3f}, {:.3f}, {}",
                        text.empty() ? "" : "; ", i, PlaceOf(rotors, i).x(), PlaceOf(rotors, i).y(),
                        Turning(rotors.spins[i]), motor + 1, m.forward * nearest.size_m.x(),
                        m.right * nearest.size_m.y(), Turning(m.spin));
  }
  return text;
}

}  // namespace

const std::vector<MotorLayout>& MotorLayouts() {
  static const std::vector<MotorLayout> layouts = {
      {"quad-plus", kQuad, kPlus, false, OnCircle({{90, kCcw}, {-90, kCcw}, {0, kCw}, {180, kCw}})},
      {"quad-x", kQuad, kX, false, OnCircle({{45, kCcw}, {-135, kCcw}, {-45, kCw}, {135, kCw}})},
      {"quad-h", kQuad, kH, true, {{1, 1, kCw}, {-1, -1, kCw}, {1, -1, kCcw}, {-1, 1, kCcw}}},
      {"hexa-plus", kHexa, kPlus, false,
       OnCircle({{0, kCw}, {180, kCcw}, {-120, kCw}, {60, kCcw}, {-60, kCcw}, {120, kCw}})},
      {"hexa-x", kHexa, kX, false,
       OnCircle({{90, kCw}, {-90, kCcw}, {-30, kCw}, {150, kCcw}, {30, kCcw}, {-150, kCw}})},
      {"hexa-h",
       kHexa,
       kH,
       true,
       {{0, 1, kCw}, {0, -1, kCcw}, {1, -1, kCw}, {-1, 1, kCcw}, {1, 1, kCcw}, {-1, -1, kCw}}},
      {"octo-plus", kOcta, kPlus, false,
       OnCircle({{0, kCw},
                 {180, kCw},
                 {45, kCcw},
                 {135, kCcw},
                 {-45, kCcw},
                 {-135, kCcw},
                 {-90, kCw},
                 {90, kCw}})},
      {"octo-x", kOcta, kX, false,
       OnCircle({{22.5, kCw},
                 {-157.5, kCw},
                 {67.5, kCcw},
                 {157.5, kCcw},
                 {-22.5, kCcw},
                 {-112.5, kCcw},
                 {-67.5, kCw},
                 {112.5, kCw}})},
      {"octo-h",
       kOcta,
       kH,
       true,
       {{1, 1, kCw},
        {-1, -1, kCw},
        {1.0 / 3, 1, kCcw},
        {-1, 1, kCcw},
        {1, -1, kCcw},
        {-1.0 / 3, -1, kCcw},
        {1.0 / 3, -1, kCw},
        {-1.0 / 3, 1, kCw}}}};
  return layouts;
}

double ThrustShare(double command, double curvature) {
  const double u = std::isfinite(command) ? std::clamp(command, 0.0, 1.0) : 0;
  return (1 - curvature) * u + curvature * u * u;
}

double CommandFor(double thrust_share, double curvature) {
  const double c = curvature;
  if (c == 0) return thrust_share;
  return (c - 1 + std::sqrt((1 - c) * (1 - c) + 4 * c * thrust_share)) / (2 * c);
}

std::string MotorOrder::Name() const {
  return layout != nullptr ? layout->name : fmt::format("{} rotors as listed", rotor.size());
}

MotorOrder KnownMotorOrder(const MultirotorParameters& aircraft) {
  const RotorLayout rotors = LayoutOf(aircraft);
  const Matches matches = MatchesOf(rotors);
  if (matches.fits) return {matches.fits->layout, matches.fits->rotor};
  if (!matches.nearest)
    throw std::runtime_error(fmt::format(
        "the autopilot has layouts of 4, 6 and 8 motors (plus, X, H), and this aircraft has {} rotors",
        rotors.count));
  throw std::runtime_error(
      fmt::format("the rotors are in no layout of the autopilot's motors; of the nearest, {}, {}",
                  matches.nearest->layout->name, WhyNot(*matches.nearest, rotors)));
}

MotorOrder Px4MotorOrder(const MultirotorParameters& aircraft) {
  const RotorLayout rotors = LayoutOf(aircraft);
  const Matches matches = MatchesOf(rotors);
  if (matches.fits) return {matches.fits->layout, matches.fits->rotor};
  MotorOrder listed;
  for (std::size_t i = 0; i < rotors.count; ++i) listed.rotor.push_back(i);
  return listed;
}

MotorMapping::MotorMapping(MotorOrder order, const MultirotorParameters& aircraft)
    : order_(std::move(order)), max_speed_rad_s_(aircraft.rotor.max_speed_rad_s) {}

Actuation MotorMapping::Speeds(const MotorCommands& commands, double curvature) const {
  RotorSpeeds speeds{};
  for (std::size_t i = 0; i < order_.rotor.size(); ++i)
    speeds[order_.rotor[i]] = max_speed_rad_s_ * std::sqrt(ThrustShare(commands[i], curvature));
  return speeds;
}

const MultirotorParameters& MultirotorOf(const AirframeParameters& aircraft) {
  const auto* multirotor = std::get_if<MultirotorParameters>(&aircraft);
  if (multirotor == nullptr)
    throw std::runtime_error("an autopilot's motors turn the rotors of a multirotor; this aircraft is none");
  return *multirotor;
}

}  // namespace kestrel::sim
