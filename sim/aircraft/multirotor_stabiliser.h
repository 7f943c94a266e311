// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/aircraft/attitude_demand.h"
#include "sim/aircraft/multirotor.h"

namespace kestrel::sim {

// The inner loop of a multirotor: torque for the acceleration wanted, with feedback on attitude and rate.
class MultirotorStabiliser {
 public:
  explicit MultirotorStabiliser(const MultirotorParameters& aircraft) : aircraft_(aircraft) {}

  RotorSpeeds Step(double dt_s, const AttitudeDemand& demand, const SensedMotion& sensed);
  bool limited() const { return limited_; }  // a rotor is asked for its maximum speed
  void Stop() { limited_ = false; }
  static bool Ready(const SensedMotion&) { return true; }  // to lift: motors spin up at once

 private:
  MultirotorParameters aircraft_;
  bool limited_ = false;
};

}  // namespace kestrel::sim
