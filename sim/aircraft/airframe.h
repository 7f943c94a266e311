// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <variant>

#include "sim/aircraft/helicopter.h"
#include "sim/aircraft/helicopter_stabiliser.h"
#include "sim/aircraft/multirotor.h"
#include "sim/aircraft/multirotor_stabiliser.h"

namespace kestrel::sim {

// The kinds of aircraft that there are: what they are made of, what flies, what their autopilot asks of them,
// and its inner loop.
using AirframeParameters = std::variant<MultirotorParameters, HelicopterParameters>;
using Airframe = std::variant<Multirotor, Helicopter>;
using Actuation = std::variant<RotorSpeeds, HelicopterControls>;
using Stabiliser = std::variant<MultirotorStabiliser, HelicopterStabiliser>;

// turning: the rotors of a helicopter turn already.
Airframe MakeAirframe(const AirframeParameters& parameters, mjModel* model, bool turning);
Stabiliser MakeStabiliser(const AirframeParameters& parameters);

double Mass_kg(const AirframeParameters& parameters);
double MaxThrust_n(const AirframeParameters& parameters);
Actuation Stopped(const AirframeParameters& parameters);  // motors off

void Command(Airframe& airframe, const Actuation& actuation);                  // of its own kind
void SetConditions(Airframe& airframe, const ActuatorConditions& conditions);  // from the next step on
void Apply(Airframe& airframe, mjData* data, double dt_s, const Eigen::Vector3d& wind_N, double surface_m);
void Disturb(const Airframe& airframe, SensorReadings& readings);

}  // namespace kestrel::sim
