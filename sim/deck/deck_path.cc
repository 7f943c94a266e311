// SPDX-License-Identifier: Apache-2.0
#include "sim/deck/deck_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr double kGently_s = 1;                    // with which a random path takes on what it drew
constexpr double kBegins = -std::numbers::pi / 2;  // in the middle

// The lemniscate of half width 1, and its heading, from x to y.
Eigen::Vector2d Lemniscate(double t) {
  const double s = std::sin(t), c = std::cos(t);
  return Eigen::Vector2d(c, s * c) / (1 + s * s);
}
Eigen::Vector2d LemniscateTangent(double t) {
  const double s = std::sin(t), c = std::cos(t), d = 1 + s * s;
  return Eigen::Vector2d(-s * (d + 2 * c * c), (c * c - s * s) * d - 2 * s * s * c * c) / (d * d);
}

}  // namespace

DeckPath::DeckPath(const DeckPathParameters& parameters, const Eigen::Vector2d& begin_N, double heading,
                   std::uint64_t seed)
    : parameters_(parameters),
      begin_N_(begin_N),
      p_N_(begin_N),
      begin_heading_(heading),
      heading_(heading),
      along_(kBegins),
      random_(seed, "deck") {}

void DeckPath::Step(double t_s, double dt_s) {
  if (parameters_.motion == "still" || t_s <= parameters_.starts_s) return;
  speed_m_s_ = std::min(parameters_.speed_m_s, speed_m_s_ + dt_s * parameters_.acceleration_m_s2);
  if (parameters_.motion == "figure_8") return Eight(speed_m_s_ * dt_s);
  if (parameters_.motion == "random") Wander(t_s, dt_s);
  if (parameters_.motion == "circle") curvature_ = 1 / parameters_.radius_m;
  const double way_m = share_ * speed_m_s_ * dt_s, turn = curvature_ * way_m;
  const double mean = heading_ + turn / 2;
  p_N_ += way_m * Eigen::Vector2d(std::cos(mean), std::sin(mean));
  heading_ = WrapAngle(heading_ + turn);
}

// Its radius of curvature is a^2 / (3 r), where r, the distance from its middle, is a at most.
void DeckPath::Eight(double way_m) {
  const double a = 3 * parameters_.radius_m;
  const auto step = [&](double t) { return way_m / (a * LemniscateTangent(t).norm()); };
  along_ += step(along_ + step(along_) / 2);
  const Eigen::Vector2d begins = LemniscateTangent(kBegins), now = LemniscateTangent(along_);
  const double turn = begin_heading_ - std::atan2(begins.y(), begins.x());
  p_N_ = begin_N_ + Eigen::Rotation2Dd(turn) * (a * Lemniscate(along_));
  heading_ = WrapAngle(std::atan2(now.y(), now.x()) + turn);
}

void DeckPath::Wander(double t_s, double dt_s) {
  if (t_s >= draws_s_) {
    curvature_wanted_ = random_.Uniform(-1, 1) / parameters_.radius_m;
    share_wanted_ = random_.Uniform(0.5, 1);
    draws_s_ = t_s + random_.Uniform(2, 5);
    const Eigen::Vector2d home = begin_N_ - p_N_;
    if (home.norm() > parameters_.within_m) {
      const double off = WrapAngle(std::atan2(home.y(), home.x()) - heading_);
      curvature_wanted_ = std::clamp(2 * off / std::numbers::pi, -1.0, 1.0) / parameters_.radius_m;
    }
  }
  const double share = dt_s / kGently_s;
  curvature_ += share * (curvature_wanted_ - curvature_);
  share_ += share * (share_wanted_ - share_);
}

}  // namespace kestrel::sim
