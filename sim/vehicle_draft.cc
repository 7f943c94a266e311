// SPDX-License-Identifier: Apache-2.0
#include "sim/vehicle_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/aircraft/airframe.h"

namespace kestrel::sim {
namespace {

constexpr double kG_m_s2 = 9.80665;
// Of propellers of two blades that stand: usual values of the coefficients of thrust and power (T = C_T rho n^2 D^4,
// P = C_P rho n^3 D^5).
constexpr double kThrustCoefficient = 0.10, kPowerCoefficient = 0.045;
constexpr double kCell_v = 3.7, kLoaded = 0.75;  // speed under the propeller's load over kv times the voltage
constexpr double kFastestTip_m_s = 240;          // 0.7 of the speed of sound
constexpr double kShareAtRotors = 0.4;           // of the mass
constexpr double kPelicanArm_m = 0.21, kPelicanRotor_m = 0.128;

// Spins as the autopilots' own layouts have them (sim/server/physics/motor_layout.h).
std::vector<RotorPlace> PlacesOf(const VehicleDraft& d) {
  std::vector<RotorPlace> places;
  const auto add = [&](double x, double y, bool clockwise) {
    const auto rounded = [](double m) { return std::round(m * 1e4) / 1e4 + 0.0; };  // no -0
    places.push_back({rounded(x), rounded(y), clockwise ? "clockwise" : "counterclockwise"});
  };
  if (d.layout == "h") {
    // two rails, the shafts of each from front to back
    constexpr double kCorner = 35 * std::numbers::pi / 180;
    const int on_rail = d.rotors / 2;
    for (const int side : {1, -1})
      for (int i = 0; i < on_rail; ++i)
        add(d.arm_m * std::cos(kCorner) * (1 - 2.0 * i / (on_rail - 1)), side * d.arm_m * std::sin(kCorner),
            (i % 2 == 0) == ((side > 0) != (d.rotors == 6)));
    return places;
  }
  const double step = 2 * std::numbers::pi / d.rotors, first = d.layout == "x" ? step / 2 : 0;
  for (int i = 0; i < d.rotors; ++i)
    add(d.arm_m * std::cos(first + i * step), d.arm_m * std::sin(first + i * step),
        (i % 2 == 0) == (d.layout == "plus" || d.rotors == 8));
  return places;
}

double LeastGap(const std::vector<RotorPlace>& places) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      least = std::min(least, std::hypot(places[i].x_m - places[j].x_m, places[i].y_m - places[j].y_m));
  return least;
}

}  // namespace

std::string VehicleText(const VehicleDraft& d, Mistakes& mistakes) {
  MultirotorParameters p;
  p.mass_kg = d.mass_kg;
  p.rotors = PlacesOf(d);
  const double gap = LeastGap(p.rotors), diameter = d.propeller_m.value_or(gap / 1.1);
  if (diameter > gap)
    mistakes.Add("--propeller", "",
                 fmt::format("{:.3g} m across overlap: shafts are {:.3g} m apart", diameter, gap),
                 fmt::format("valid: less than {:.3g}, or longer arms", gap));
  const double weight = d.mass_kg * kG_m_s2, size = d.arm_m / kPelicanArm_m,
               rotor_size = diameter / 2 / kPelicanRotor_m;
  RotorParameters& r = p.rotor;
  r.radius_m = diameter / 2;
  r.thrust_coefficient_n_s2 =
      kThrustCoefficient * kAirDensity * std::pow(diameter, 4) / std::pow(2 * std::numbers::pi, 2);
  r.moment_coefficient_m = kPowerCoefficient * diameter / (2 * std::numbers::pi * kThrustCoefficient);
  r.drag_coefficient_kg *= std::pow(rotor_size, 3);
  r.rolling_coefficient_kg_m *= std::pow(rotor_size, 4);
  r.time_constant_up_s *= std::max(1.0, rotor_size);
  r.time_constant_down_s *= std::max(1.0, rotor_size);
  const double volts = d.cells * kCell_v, to_rad_s = 2 * std::numbers::pi / 60;
  r.max_speed_rad_s = d.kv_rpm_v
                          ? kLoaded * *d.kv_rpm_v * volts * to_rad_s
                          : std::sqrt(d.thrust_to_weight * weight / (d.rotors * r.thrust_coefficient_n_s2));
  const double thrust = d.rotors * LimitsOf(r).thrust_n;
  if (thrust < 1.2 * weight)
    mistakes.Add(
        d.kv_rpm_v ? "--kv" : "--thrust-to-weight", "",
        fmt::format("{} rotors of {:.3g} m give {:.3g} N at most, and {:g} kg weigh {:.3g} N", d.rotors,
                    diameter, thrust, d.mass_kg, weight),
        "valid: a fifth more than the weight, by more rotors, larger ones, more cells, faster motors, or "
        "less mass");
  else if (const auto why = CannotFly(LayoutOf(p), LimitsOf(r), weight))
    mistakes.Add("--layout", "", *why);
  if (const double tip = r.max_speed_rad_s * r.radius_m; tip > kFastestTip_m_s)
    mistakes.Add(d.kv_rpm_v ? "--kv" : "--arm", "",
                 fmt::format("the tips of the rotors would reach {:.0f} m/s", tip),
                 fmt::format("valid: up to {:g}, by slower motors, longer arms, more rotors or less mass",
                             kFastestTip_m_s));
  if (!mistakes.empty()) return "";

  // Rotors and motors are points where they are; the rest is a box of 0.7 arm squared and a fifth as high.
  const double each = kShareAtRotors * d.mass_kg / d.rotors, rest = (1 - kShareAtRotors) * d.mass_kg,
               side = 0.7 * d.arm_m, height = 0.2 * side;
  double about_x = rest * (side * side + height * height) / 12, about_y = about_x,
         about_z = rest * side * side / 6;
  for (const RotorPlace& place : p.rotors) {
    about_x += each * place.y_m * place.y_m;
    about_y += each * place.x_m * place.x_m;
    about_z += each * (place.x_m * place.x_m + place.y_m * place.y_m);
  }

  std::string text = fmt::format(
      "description: \"{}: {} rotors, {}, {:g} kg.\"\n"
      "# Nothing here is measured but what was given. \"Given\": as an option. \"Assumed\": estimated from "
      "what was "
      "given.\n\n"
      "mass_kg: {:g}  # given\n"
      "# assumed: {:.0f} % of the mass at the shafts, the rest a box of {:.3g} x {:.3g} x {:.3g} m\n"
      "inertia_kg_m2: [{:.4g}, {:.4g}, {:.4g}]\n"
      "rotor_height_m: {:.3g}  # assumed\n"
      "drag_area_m2: [{:.3g}, {:.3g}, {:.3g}]  # assumed: the AscTec Pelican's, by the square of the arms\n"
      "rotors:  # layout {}, arms of {:g} m: given\n",
      d.name, d.rotors, d.layout, d.mass_kg, d.mass_kg, 100 * kShareAtRotors, side, side, height, about_x,
      about_y, about_z, 0.05 * size, 0.01 * size * size, 0.01 * size * size, 0.02 * size * size, d.layout,
      d.arm_m);
  for (const RotorPlace& place : p.rotors)
    text += fmt::format("  - {{x_m: {:.4f}, y_m: {:.4f}, spin: {}}}\n", place.x_m, place.y_m, place.spin);
  text += fmt::format(
      "rotor:\n"
      "  thrust_coefficient_n_s2: {:.4e}  # assumed: C_T = {:g} of a standing propeller of {:.3g} m\n"
      "  moment_coefficient_m: {:.4g}  # assumed: C_P = {:g}\n"
      "  drag_coefficient_kg: {:.3e}  # assumed: the Pelican's, by the cube of the radius\n"
      "  rolling_coefficient_kg_m: {:.3e}  # assumed: the Pelican's, by its fourth power\n"
      "  radius_m: {:.4g}  # {}\n"
      "  time_constant_up_s: {:.3g}  # assumed: the Pelican's, by the radius where that is larger\n"
      "  time_constant_down_s: {:.3g}  # assumed, as that\n",
      r.thrust_coefficient_n_s2, kThrustCoefficient, diameter, r.moment_coefficient_m, kPowerCoefficient,
      r.drag_coefficient_kg, r.rolling_coefficient_kg_m, r.radius_m,
      d.propeller_m ? "given" : "assumed: a gap of a tenth between rotors", r.time_constant_up_s,
      r.time_constant_down_s);
  if (d.kv_rpm_v)
    text += fmt::format("  # {:g} rpm/V and {} cells: given; {:g} of the speed without load: assumed\n",
                        *d.kv_rpm_v, d.cells, kLoaded);
  else
    text += fmt::format(
        "  # for {:g} times the weight: given; on {} cells that takes motors of about {:.0f} rpm/V: "
        "assumed\n",
        d.thrust_to_weight, d.cells, r.max_speed_rad_s / to_rad_s / volts / kLoaded);
  text += fmt::format("  max_speed_rad_s: {:.5g}  # {:.3g} N in all, {:.3g} times the weight\n",
                      r.max_speed_rad_s, thrust, thrust / weight);
  return text +
         "\nautopilot:\n"
         "  # assumed: the AscTec Pelican's loops\n"
         "  roll: {natural_frequency_rad_s: 7.07, damping: 0.72, gain: 0.80}\n"
         "  pitch: {natural_frequency_rad_s: 7.07, damping: 0.76, gain: 0.84}\n"
         "  yaw: {natural_frequency_rad_s: 5.0, damping: 0.95, gain: 1.0}\n";
}

}  // namespace kestrel::sim
