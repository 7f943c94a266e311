// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "base/random.h"
#include "sim/sensor/sensors.h"

namespace kestrel::sim {

inline Eigen::Vector3d Normal3(RandomStream& random) {
  const double x = random.Normal(), y = random.Normal(), z = random.Normal();
  return {x, y, z};
}

// Of three gyros or accelerometers: white noise and a bias that walks. Sampled as Kalibr's model says: at a
// rate r, a density s makes white noise of s sqrt(r), and a walk k makes steps of k / sqrt(r).
class InertialNoise {
 public:
  InertialNoise(double density, double walk, double turn_on, double rate_hz, RandomStream& random)
      : white_(density * std::sqrt(rate_hz)),
        step_(walk / std::sqrt(rate_hz)),
        bias_(turn_on * Normal3(random)) {}

  // For the next reading; bias() is what of it is bias, until the next call.
  Eigen::Vector3d Next(RandomStream& random) {
    if (begun_) bias_ += step_ * Normal3(random);
    begun_ = true;
    return bias_ + white_ * Normal3(random);
  }
  const Eigen::Vector3d& bias() const { return bias_; }

 private:
  double white_, step_;
  bool begun_ = false;
  Eigen::Vector3d bias_;
};

// A SensorError on three axes alike; the slow part begins at zero.
class WanderNoise {
 public:
  WanderNoise(const SensorError& error, double rate_hz)
      : error_(error), keep_(std::exp(-1 / (rate_hz * error.wander_time_s))) {}

  Eigen::Vector3d Next(RandomStream& random) {
    slow_ = keep_ * slow_ + error_.wander * std::sqrt(1 - keep_ * keep_) * Normal3(random);
    return slow_ + error_.white * Normal3(random);
  }

 private:
  SensorError error_;
  double keep_;  // of the slow part, from one reading to the next: exact for any rate
  Eigen::Vector3d slow_ = Eigen::Vector3d::Zero();
};

}  // namespace kestrel::sim
