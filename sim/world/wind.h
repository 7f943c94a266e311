// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "base/random.h"
#include "base/yaml/fields.h"

namespace kestrel::sim {

// Discrete gusts: how often they come, how strong, how long each lasts.
struct GustParameters {
  double rate_per_min = 0;   // mean rate of a Poisson process
  double amplitude_m_s = 0;  // of the strongest
  double length_s = 3;       // from calm to calm
};

inline void Fields(FieldVisitor& v, GustParameters& p) {
  v({"rate_per_min", "mean number of gusts in a minute (Poisson process)"}, p.rate_per_min, 0.0, 60.0);
  v({"amplitude_m_s", "speed of the strongest gust"}, p.amplitude_m_s, 0.0, 20.0);
  v({"length_s", "duration of a gust, from calm to calm"}, p.length_s, 0.1, 60.0);
}

struct WindParameters {
  double mean_m_s = 0;          // the same at every height; also the wind at 20 ft that scales the turbulence
  double from_deg = 0;          // where the mean wind blows from, clockwise from north
  double from_scatter_deg = 0;  // from anywhere within this of from_deg, by the seed
  bool turbulence = false;      // without mean wind there is none
  GustParameters gusts{};
};

inline void Fields(FieldVisitor& v, WindParameters& p) {
  v({"mean_m_s", "mean speed of the wind, the same at every height; it scales the turbulence"}, p.mean_m_s,
    0.0, 20.0);
  v({"from_deg", "where the mean wind blows from, clockwise from north"}, p.from_deg, 0.0, 360.0);
  v({"from_scatter_deg",
     "half width of the interval around from_deg in which the direction is drawn, by the seed"},
    p.from_scatter_deg, 0.0, 180.0);
  v({"turbulence", "Dryden turbulence (MIL-F-8785C, low altitude); there is none without mean wind"},
    p.turbulence);
  v({"gusts", "discrete gusts of the form 1 - cos"}, p.gusts);
}

// Dryden turbulence at low altitude: standard deviations, m/s, and lengths, m, of the longitudinal (u),
// lateral (v) and vertical (w) components.
struct DrydenScales {
  double sigma_u = 0, sigma_v = 0, sigma_w = 0;
  double length_u_m = 0, length_v_m = 0, length_w_m = 0;
};

// MIL-F-8785C, heights of 10 to 1000 ft; a height outside is brought to the nearer end. wind_20ft: m/s, at 20
// ft.
DrydenScales DrydenLowAltitude(double height_m, double wind_20ft_m_s);

// The air where the aircraft is: mean wind, Dryden turbulence and gusts.
//
// Turbulence: the spectra of MIL-F-8785C as a field frozen in the mean wind, through which the aircraft moves
// at V, the largest of its speed relative to the mean wind, the mean wind, and 0.5 m/s: a hovering aircraft
// is carried past by the mean wind. u lies along the mean wind. The filters are discretised exactly and start
// in their stationary state, so the variance is that of the definition whatever the time step, the speed and
// the height do.
//
// Gusts: amplitude / 2 (1 - cos(2 pi t / length)), arriving as a Poisson process; those that overlap add up.
// Each blows within 45 degrees of the mean wind, horizontally, with 0.5 to 1 of the full amplitude, both
// uniform.
class Wind {
 public:
  Wind(const WindParameters& parameters, std::uint64_t seed);

  // From now on it blows by these, and its random streams go on.
  void Change(const WindParameters& parameters);

  // To the next instant. height_m: of the aircraft above the ground. v_N_vehicle: m/s over the ground.
  void Step(double dt_s, double height_m, const Eigen::Vector3d& v_N_vehicle);

  // Velocity of the air in N, m/s. Before the first step: the mean wind.
  Eigen::Vector3d Velocity() const { return mean_N_ + turbulence_N_ + gust_N_; }

 private:
  struct Gust {
    double start_s, length_s;
    Eigen::Vector3d amplitude_N;
  };
  // A transverse component of variance 1: two first-order lags in series, the output a sum of both.
  struct Transverse {
    double first, second;
  };

  void Turn();
  void StepTurbulence(double dt_s, double height_m, const Eigen::Vector3d& v_N_vehicle);
  void StepGusts(double dt_s);

  WindParameters parameters_;
  double turn_deg_;  // off from_deg, as drawn
  RandomStream turbulence_stream_, gust_stream_;
  Eigen::Vector3d along_N_, across_N_;  // unit vectors: where the mean wind blows to, and to the right of it
  Eigen::Vector3d mean_N_;
  Eigen::Vector3d turbulence_N_ = Eigen::Vector3d::Zero(), gust_N_ = Eigen::Vector3d::Zero();
  double u_;  // the longitudinal component, variance 1
  Transverse v_, w_;
  double t_s_ = 0, next_gust_s_;
  std::vector<Gust> gusts_;  // those that blow now
};

}  // namespace kestrel::sim
