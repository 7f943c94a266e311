// SPDX-License-Identifier: Apache-2.0
// MIL-F-8785C, 3.7: Dryden form, low altitude; with f = 0.177 + 0.000823 h, heights and lengths in ft,
//   L_w = h, L_u = L_v = h / f^1.2, sigma_w = 0.1 W20, sigma_u = sigma_v = sigma_w / f^0.4,
//   H_u(s) ~ 1 / (1 + T s), H_v(s), H_w(s) ~ (1 + sqrt(3) T s) / (1 + T s)^2, T = L / V.
#include "sim/world/wind.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr double kFoot = 0.3048;
constexpr double kSlowest = 0.5;  // m/s, of the aircraft through the frozen field

double NextArrival(RandomStream& stream, double rate_per_min) {
  if (rate_per_min <= 0) return std::numeric_limits<double>::infinity();
  return -std::log1p(-stream.Uniform(0, 1)) * 60 / rate_per_min;
}

}  // namespace

DrydenScales DrydenLowAltitude(double height_m, double wind_20ft_m_s) {
  const double h_ft = std::clamp(height_m / kFoot, 10.0, 1000.0);
  const double f = 0.177 + 0.000823 * h_ft;
  DrydenScales s;
  s.length_w_m = h_ft * kFoot;
  s.length_u_m = s.length_v_m = h_ft / std::pow(f, 1.2) * kFoot;
  s.sigma_w = 0.1 * wind_20ft_m_s;
  s.sigma_u = s.sigma_v = s.sigma_w / std::pow(f, 0.4);
  return s;
}

Wind::Wind(const WindParameters& parameters, std::uint64_t seed)
    : parameters_(parameters),
      turn_deg_(parameters.from_scatter_deg * RandomStream(seed, "wind direction").Uniform(-1, 1)),
      turbulence_stream_(seed, "wind turbulence"),
      gust_stream_(seed, "wind gusts"),
      next_gust_s_(NextArrival(gust_stream_, parameters.gusts.rate_per_min)) {
  Turn();
  // the stationary covariance of the two lags is [1/2 1/4; 1/4 1/4]
  const auto stationary = [this]() -> Transverse {
    const double first = std::sqrt(0.5) * turbulence_stream_.Normal();
    return {first, 0.5 * first + std::sqrt(0.125) * turbulence_stream_.Normal()};
  };
  u_ = turbulence_stream_.Normal();
  v_ = stationary();
  w_ = stationary();
}

void Wind::Change(const WindParameters& parameters) {
  const double rate_before = parameters_.gusts.rate_per_min;
  parameters_ = parameters;
  Turn();
  if (!parameters.turbulence) turbulence_N_.setZero();
  if (parameters.gusts.rate_per_min != rate_before)
    next_gust_s_ = t_s_ + NextArrival(gust_stream_, parameters.gusts.rate_per_min);
}

void Wind::Turn() {
  const double from = Radians(parameters_.from_deg + turn_deg_);
  along_N_ = {-std::cos(from), -std::sin(from), 0};
  across_N_ = {std::sin(from), -std::cos(from), 0};
  mean_N_ = parameters_.mean_m_s * along_N_;
}

void Wind::Step(double dt_s, double height_m, const Eigen::Vector3d& v_N_vehicle) {
  if (parameters_.turbulence) StepTurbulence(dt_s, height_m, v_N_vehicle);
  StepGusts(dt_s);
}

void Wind::StepTurbulence(double dt_s, double height_m, const Eigen::Vector3d& v_N_vehicle) {
  const DrydenScales scales = DrydenLowAltitude(height_m, parameters_.mean_m_s);
  const double V = std::max({(v_N_vehicle - mean_N_).norm(), parameters_.mean_m_s, kSlowest});

  const double decay = dt_s * V / scales.length_u_m;
  u_ = std::exp(-decay) * u_ + std::sqrt(-std::expm1(-2 * decay)) * turbulence_stream_.Normal();

  // With time in units of T: x1' = -x1 + n, x2' = -x2 + x1. Noise over a step of s: the integral over r from
  // 0 to s of exp(-2 r) [1 r; r r^2].
  const auto step = [&](Transverse& x, double length_m) {
    const double s = dt_s * V / length_m;
    const double e = std::exp(-s);
    const double gone = -std::expm1(-2 * s);  // 1 - exp(-2 s)
    const double q11 = gone / 2;
    const double q12 = gone / 4 - e * e * s / 2;
    const double q22 = gone / 4 - e * e * s * (1 + s) / 2;
    const double l11 = std::sqrt(q11);
    const double l21 = l11 > 0 ? q12 / l11 : 0;
    const double l22 =
        std::sqrt(std::max(0.0, q22 - l21 * l21));  // of the order of rounding for the shortest steps
    const double n1 = turbulence_stream_.Normal(), n2 = turbulence_stream_.Normal();
    x = {e * x.first + l11 * n1, e * (s * x.first + x.second) + l21 * n1 + l22 * n2};
  };
  step(v_, scales.length_v_m);
  step(w_, scales.length_w_m);

  // (1 + sqrt(3) T s) / (1 + T s)^2 in partial fractions
  const auto output = [](const Transverse& x) {
    return std::numbers::sqrt3 * x.first + (1 - std::numbers::sqrt3) * x.second;
  };
  turbulence_N_ = scales.sigma_u * u_ * along_N_ + scales.sigma_v * output(v_) * across_N_ +
                  scales.sigma_w * output(w_) * Eigen::Vector3d::UnitZ();
}

void Wind::StepGusts(double dt_s) {
  const GustParameters& p = parameters_.gusts;
  t_s_ += dt_s;
  while (next_gust_s_ <= t_s_) {
    const double angle = gust_stream_.Uniform(-1, 1) * std::numbers::pi / 4;
    const double amplitude = gust_stream_.Uniform(0.5, 1) * p.amplitude_m_s;
    gusts_.push_back(
        {next_gust_s_, p.length_s, amplitude * (std::cos(angle) * along_N_ + std::sin(angle) * across_N_)});
    next_gust_s_ += NextArrival(gust_stream_, p.rate_per_min);
  }
  std::erase_if(gusts_, [&](const Gust& g) { return t_s_ >= g.start_s + g.length_s; });

  gust_N_.setZero();
  for (const Gust& g : gusts_) {
    gust_N_ += (1 - std::cos(2 * std::numbers::pi * (t_s_ - g.start_s) / g.length_s)) / 2 * g.amplitude_N;
  }
}

}  // namespace kestrel::sim
