// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "base/yaml/fields.h"
#include "sim/server/physics/hil_messages.h"
#include "sim/server/physics/physics_server.h"

namespace kestrel::sim {

struct Px4PhysicsParameters {
  std::string address = "127.0.0.1";
  int port = 4560;                 // 0: any that is free
  double thrust_curvature = 0;     // its THR_MDL_FAC
  double sensor_period_s = 0.004;  // of HIL_SENSOR, in simulated time
  double speed = 1;                // of the simulated time against the real one; 0: as fast as it answers
  GeodeticOrigin origin = {};
};

inline void Fields(FieldVisitor& v, Px4PhysicsParameters& p) {
  v({"address", "address on which the simulator waits for PX4"}, p.address);
  v({"port", "TCP port on which the simulator waits for PX4; 0: any that is free"}, p.port, 0, 65535);
  v({"thrust_curvature", "PX4's THR_MDL_FAC: how thrust goes with the motors' signal"}, p.thrust_curvature,
    0.0, 1.0);
  v({"sensor_period_s", "time between two HIL_SENSOR messages, in simulated time"}, p.sensor_period_s, 0.002,
    0.02);
  v({"speed", "simulated time over real time; 0: as fast as PX4 answers"}, p.speed, 0.0, 100.0);
  v({"origin", "where the origin of N is on the earth"}, p.origin);
}

// PX4's simulator protocol (docs.px4.io, simulation; src/modules/simulation/simulator_mavlink): PX4 connects
// by TCP and introduces itself; HIL_SENSOR goes out once in each sensor period, with HIL_GPS when the
// receiver speaks and HIL_STATE_QUATERNION as often as PX4 asks for it before it, and no time passes until
// HIL_ACTUATOR_CONTROLS with the lockstep flag has come for it. A message with the time stamp of the one
// before is a repetition and lets no time go on.
//
// PX4's clock is HIL_SENSOR's time stamp, so it cannot start up unless that goes on: until its first
// controls, and if they come without the flag, sensors go out by this computer's clock. A flight is one
// connection; one that ends, ends the flight. Motors of a PX4 that is not armed stand still.
//
// Followed from PX4's source and documentation; no PX4 has been seen to fly it.
class Px4Physics final : public PhysicsServer {
 public:
  // Listens at once. Throws std::runtime_error: not an address, a port that is taken, an aircraft that is no
  // Multirotor.
  Px4Physics(const Px4PhysicsParameters& parameters, const AirframeParameters& aircraft);
  ~Px4Physics() override;

  bool Begin() override;
  std::optional<double> step_s() const override { return std::nullopt; }
  std::optional<Actuation> Step(double dt_s, const SensorReadings& readings, const Truth& truth) override;
  void Stop() override;
  std::string Where() const override;
  std::string Motors() const override;
  PhysicsCounts counts() const override;
  bool lockstep() const;  // its controls say so

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kestrel::sim
