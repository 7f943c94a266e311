// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "base/yaml/fields.h"
#include "sim/server/physics/physics_server.h"

namespace kestrel::sim {

// The physics' step where more than 500 states a second are asked for.
inline constexpr double kArduPilotFineStep_s = 0.001;

struct ArduPilotPhysicsParameters {
  std::string address = "127.0.0.1";
  int port = 9002;                 // 0: any that is free
  double thrust_curvature = 0.65;  // its MOT_THST_EXPO
  int pwm_min_us = 1000, pwm_max_us = 2000;
  double gone_s = 2;  // silent for longer, on this computer's clock, a peer gives way to another
};

inline void Fields(FieldVisitor& v, ArduPilotPhysicsParameters& p) {
  v({"address", "address on which the simulator waits for ArduPilot"}, p.address);
  v({"port", "UDP port on which the simulator waits for ArduPilot; 0: any that is free"}, p.port, 0, 65535);
  v({"thrust_curvature", "ArduPilot's MOT_THST_EXPO: how thrust goes with the motors' signal"},
    p.thrust_curvature, 0.0, 1.0);
  v({"pwm_min_us", "pulse width at which a motor stands still"}, p.pwm_min_us, 500, 1500);
  v({"pwm_max_us", "pulse width of full throttle"}, p.pwm_max_us, 1501, 3000);
  v({"gone_s", "silence, in real time, after which another peer may take over"}, p.gone_s, 0.0, 3600.0);
}

// ArduPilot's JSON interface (sim/server/physics/ardupilot_json.h): each packet of servo outputs is answered
// with the state, after as many steps of the physics as come nearest to the frame rate that it asks for, one
// at least. A packet that comes again is answered again, and no time passes. ArduPilot keeps the pace of real
// time itself.
//
// The inertial sensors are the aircraft's, with their errors; position, velocity, attitude and wind are the
// truth, from which ArduPilot makes its other sensors. A frame count that begins anew ends the flight, and
// the next one begins with it. Packets from another address are refused, unless the peer has been silent for
// gone_s: then they begin a flight too. Time stands still while nobody sends.
//
// The step of the physics is 1 ms where it asks for more than 500 states a second: by its default loop of 400 Hz it arms
// only if its gyroscopes have 720.
//
// ArduCopter 4.7-dev, as software in the loop, has hovered and landed by it, with physics of 500 Hz and SCHED_LOOP_RATE 250.
class ArduPilotPhysics final : public PhysicsServer {
 public:
  // Listens at once. Throws std::runtime_error: not an address, a port that is taken, an aircraft that is no
  // Multirotor or whose rotors are in no layout that ArduPilot has (sim/server/physics/motor_layout.h).
  ArduPilotPhysics(const ArduPilotPhysicsParameters& parameters, const AirframeParameters& aircraft);
  ~ArduPilotPhysics() override;

  bool Begin() override;
  std::optional<double> step_s() const override;
  std::optional<Actuation> Step(double dt_s, const SensorReadings& readings, const Truth& truth) override;
  void Stop() override;
  std::string Where() const override;
  std::string Motors() const override;
  PhysicsCounts counts() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kestrel::sim
