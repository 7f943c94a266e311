// SPDX-License-Identifier: Apache-2.0
#include "sim/world/target.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/gravity.h"

namespace kestrel::sim {
namespace {

constexpr double kAir_kg_m3 = 1.225;
constexpr double kDragCoefficient = 0.47;
constexpr double kMassOfDisplaced = 0.4;  // of balloon and helium, of the mass of the air they displace
constexpr double kAddedMass = 0.5;        // of the air that a sphere moves, likewise

constexpr double kAcceleration_m_s2 = 1.5;  // the largest of a random path
constexpr double kQuinticPeak = 1.875;      // the maximum slope of the quintic from 0 to 1
constexpr double kLowest_m = 1.5, kUpAndDown_m = 1.5;

Eigen::Vector3d FromPlace(const Eigen::Vector3d& north_east_up) {
  return {north_east_up.x(), north_east_up.y(), -north_east_up.z()};
}

}  // namespace

TargetPath::TargetPath(const TargetParameters& parameters, std::uint64_t seed, std::size_t index)
    : parameters_(parameters),
      random_(seed, fmt::format("target {}", index)),
      begin_N_(FromPlace(parameters.position_m)),
      anchor_N_(begin_N_ + (parameters.diameter_m / 2 + parameters.string_m) * Eigen::Vector3d::UnitZ()),
      p_N_(begin_N_) {}

void TargetPath::Step(double t_s, double dt_s, const Eigen::Vector3d& wind_N) {
  if (parameters_.string_m > 0) {
    Sway(dt_s, wind_N);
  } else if (t_s > 0) {
    if (parameters_.roam_m_s > 0) return Roam(t_s, dt_s);
    v_N_ = FromPlace(parameters_.velocity_m_s);
    p_N_ = begin_N_ + t_s * v_N_;
  }
}

void TargetPath::Change(const TargetParameters& parameters, double t_s) {
  if (parameters == parameters_) return;
  const bool roamed = parameters_.roam_m_s > 0;
  parameters_ = parameters;
  if (parameters.roam_m_s <= 0)
    begin_N_ = p_N_ - t_s * FromPlace(parameters.velocity_m_s);
  else if (!roamed)
    begin_N_ = p_N_, holds_until_s_ = t_s;
}

void TargetPath::Sway(double dt_s, const Eigen::Vector3d& wind_N) {
  const double radius = parameters_.diameter_m / 2;
  const double displaced_kg = kAir_kg_m3 * 4 / 3 * std::numbers::pi * std::pow(radius, 3);
  const Eigen::Vector3d air = wind_N - v_N_;
  const Eigen::Vector3d force =
      0.5 * kAir_kg_m3 * kDragCoefficient * std::numbers::pi * radius * radius * air.norm() * air -
      (1 - kMassOfDisplaced) * displaced_kg * kGravity_m_s2 * Eigen::Vector3d::UnitZ();
  v_N_ += dt_s / ((kMassOfDisplaced + kAddedMass) * displaced_kg) * force;
  // The string takes what would lengthen it.
  const Eigen::Vector3d along = (p_N_ + dt_s * v_N_ - anchor_N_).normalized();
  const Eigen::Vector3d next = anchor_N_ + (radius + parameters_.string_m) * along;
  v_N_ = (next - p_N_) / dt_s;
  p_N_ = next;
}

void TargetPath::Roam(double t_s, double dt_s) {
  if (t_s > holds_until_s_) NextVelocity(t_s);
  const double x =
      arrives_s_ > leaves_s_ ? std::clamp((t_s - leaves_s_) / (arrives_s_ - leaves_s_), 0.0, 1.0) : 1;
  v_N_ = from_N_ + x * x * x * (10 - 15 * x + 6 * x * x) * (to_N_ - from_N_);
  p_N_ += dt_s * v_N_;
}

void TargetPath::NextVelocity(double t_s) {
  const Eigen::Vector3d away = p_N_ - begin_N_;
  const double kind = random_.Uniform(0, 1), speed = random_.Uniform(0.3, 1) * parameters_.roam_m_s;
  const double turn = random_.Uniform(-1, 1), climb = random_.Uniform(-0.3, 0.3);
  const double hold_s = random_.Uniform(1, 4);
  from_N_ = v_N_;
  const bool leaves = away.head<2>().norm() > parameters_.roam_within_m;
  if (kind < 0.2 && !leaves) {
    to_N_.setZero();
  } else if (kind < 0.4 && !leaves) {
    to_N_ = -from_N_;
  } else {
    const double heading =
        leaves ? std::atan2(-away.y(), -away.x()) + turn * std::numbers::pi / 4 : turn * std::numbers::pi;
    const double level = std::sqrt(1 - climb * climb);
    to_N_ = speed * Eigen::Vector3d(level * std::cos(heading), level * std::sin(heading), -climb);
  }
  const bool low = -p_N_.z() < kLowest_m || away.z() > kUpAndDown_m, high = away.z() < -kUpAndDown_m;
  if (low) to_N_.z() = -std::abs(to_N_.z());
  if (high) to_N_.z() = std::abs(to_N_.z());
  leaves_s_ = t_s;
  arrives_s_ = t_s + kQuinticPeak * (to_N_ - from_N_).norm() / kAcceleration_m_s2;
  holds_until_s_ = arrives_s_ + hold_s;
}

}  // namespace kestrel::sim
