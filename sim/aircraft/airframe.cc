// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/airframe.h"

#include <cmath>

namespace kestrel::sim {

Airframe MakeAirframe(const AirframeParameters& parameters, mjModel* model, bool turning) {
  if (const auto* helicopter = std::get_if<HelicopterParameters>(&parameters))
    return Helicopter(*helicopter, model, turning);
  return Multirotor(std::get<MultirotorParameters>(parameters), model);
}

Stabiliser MakeStabiliser(const AirframeParameters& parameters) {
  if (const auto* helicopter = std::get_if<HelicopterParameters>(&parameters))
    return HelicopterStabiliser(*helicopter);
  return MultirotorStabiliser(std::get<MultirotorParameters>(parameters));
}

double Mass_kg(const AirframeParameters& parameters) {
  return std::visit([](const auto& p) { return p.mass_kg; }, parameters);
}

double MaxThrust_n(const AirframeParameters& parameters) {
  if (const auto* helicopter = std::get_if<HelicopterParameters>(&parameters))
    return MaxThrust(helicopter->rotor, helicopter->drive.speed_rad_s);
  const auto& multirotor = std::get<MultirotorParameters>(parameters);
  const RotorParameters& rotor = multirotor.rotor;
  return static_cast<double>(LayoutOf(multirotor).count) * rotor.thrust_coefficient_n_s2 *
         std::pow(rotor.max_speed_rad_s, 2);
}

Actuation Stopped(const AirframeParameters& parameters) {
  if (std::holds_alternative<HelicopterParameters>(parameters)) return HelicopterControls{};
  return RotorSpeeds{};
}

void Command(Airframe& airframe, const Actuation& actuation) {
  if (auto* helicopter = std::get_if<Helicopter>(&airframe))
    helicopter->Command(std::get<HelicopterControls>(actuation));
  else
    std::get<Multirotor>(airframe).Command(std::get<RotorSpeeds>(actuation));
}

void SetConditions(Airframe& airframe, const ActuatorConditions& conditions) {
  std::visit([&](auto& a) { a.SetConditions(conditions); }, airframe);
}

void Apply(Airframe& airframe, mjData* data, double dt_s, const Eigen::Vector3d& wind_N, double surface_m) {
  std::visit([&](auto& a) { a.Apply(data, dt_s, wind_N, surface_m); }, airframe);
}

void Disturb(const Airframe& airframe, SensorReadings& readings) {
  if (const auto* helicopter = std::get_if<Helicopter>(&airframe)) helicopter->Disturb(readings);
}

}  // namespace kestrel::sim
