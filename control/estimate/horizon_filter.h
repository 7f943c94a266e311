// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>

#include "base/yaml/fields.h"

// Attitude from rate gyros, held by what the camera says of the vertical and of the heading (thesis 6.3: the
// skyline gives raw measurements, which a filter makes soft).
namespace kestrel::control {

struct HorizonFilterOptions {
  double gyro_noise_deg_per_root_s = 0.05;    // angle random walk
  double bias_walk_deg_per_s_root_s = 0.002;  // per root second
  double initial_bias_deg_per_s = 1.0;        // deviation
  double initial_heading_deg = 180;           // deviation
  double correlation_s = 0.5;                 // over which errors of the camera's attitude stay alike
  double gate = 4;                            // standard deviations beyond which a measurement is refused
  int refusals = 10;    // in a row after which the filter believes the camera and starts anew
  double memory_s = 1;  // how late a measurement may come
};

inline void Fields(FieldVisitor& v, HorizonFilterOptions& o) {
  v("gyro_noise_deg_per_root_s", o.gyro_noise_deg_per_root_s, 1e-4, 10.0);
  v("bias_walk_deg_per_s_root_s", o.bias_walk_deg_per_s_root_s, 0.0, 1.0);
  v("initial_bias_deg_per_s", o.initial_bias_deg_per_s, 1e-3, 30.0);
  v("initial_heading_deg", o.initial_heading_deg, 0.1, 180.0);
  v("correlation_s", o.correlation_s, 0.0, 10.0);
  v("gate", o.gate, 2.0, 20.0);
  v("refusals", o.refusals, 1, 1000);
  v("memory_s", o.memory_s, 0.05, 5.0);
}

// An error-state Kalman filter of R_NB and the gyro's bias. The error turns B: R_NB = R_estimate Exp(error).
class HorizonFilter {
 public:
  struct Gyro {
    double t_s = 0;
    Eigen::Vector3d rate_B = Eigen::Vector3d::Zero();  // rad/s, with its bias
  };
  // Of one image, at the middle of its exposure.
  struct Attitude {
    double t_s = 0;
    Eigen::Vector3d down_B = Eigen::Vector3d::UnitZ();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of down_B, rad^2, of rank 2
    std::optional<double> heading;                         // yaw, rad, clockwise from N's north
    double heading_variance = 0;                           // rad^2
  };
  struct Estimate {
    double t_s = 0;
    Eigen::Quaterniond R_NB = Eigen::Quaterniond::Identity();
    Eigen::Vector3d bias_B = Eigen::Vector3d::Zero();                     // rad/s
    Eigen::Matrix<double, 6, 6> P = Eigen::Matrix<double, 6, 6>::Zero();  // of (error in B, rad; bias)
    double coasting_s = 0;  // since the last attitude that was believed
  };

  explicit HorizonFilter(const HorizonFilterOptions& options) : options_(options) {}

  // Times must not go back.
  void Add(const Gyro& gyro);
  // Takes effect at its own time; what followed is done again. False: refused, or too late, or there was no
  // gyro yet at its time.
  bool Correct(const Attitude& attitude);
  // None until the first attitude has been accepted.
  std::optional<Estimate> Now() const;

 private:
  struct Node {  // the estimate once the gyro has been followed up to its time
    Gyro gyro;
    Estimate estimate;
  };
  Estimate Predicted(const Estimate& from, const Gyro& last, const Gyro& next) const;
  bool Plausible(const Estimate& estimate, const Attitude& attitude) const;
  Estimate Corrected(Estimate estimate, const Attitude& attitude) const;
  Estimate Started(const Attitude& attitude) const;

  HorizonFilterOptions options_;
  std::deque<Node> nodes_;
  bool started_ = false;
  int refused_ = 0;
  double last_attitude_s_ = -1e9;
};

}  // namespace kestrel::control
