// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "base/random.h"

namespace kestrel::sim {

struct DeckPathParameters {
  std::string motion = "still";
  double speed_m_s = 0;
  double starts_s = 0;
  double acceleration_m_s2 = 1;
  double radius_m = 40;
  double within_m = 100;
};

// Where a deck drives, step by step: it stands until it starts, gathers speed evenly, and goes on
//   straight   along its heading
//   circle     of the radius, to the right
//   figure_8   a lemniscate of Bernoulli through its beginning, whose sharpest bends have the radius
//   random     by a curvature of up to one over the radius and half to all of its speed, each drawn anew every 2 to 5
//              s and taken on gently; away from its beginning by within_m it turns back
// Its heading is where it drives to.
class DeckPath {
 public:
  DeckPath(const DeckPathParameters& parameters, const Eigen::Vector2d& begin_N, double heading,
           std::uint64_t seed);

  // To the next instant, t_s, which may lie before the start.
  void Step(double t_s, double dt_s);

  const Eigen::Vector2d& p_N() const { return p_N_; }  // m, north and east
  double heading() const { return heading_; }          // rad, clockwise from north

 private:
  void Eight(double way_m);
  void Wander(double t_s, double dt_s);

  DeckPathParameters parameters_;
  Eigen::Vector2d begin_N_, p_N_;
  double begin_heading_, heading_;
  double speed_m_s_ = 0;
  double along_;  // the lemniscate's parameter, rad
  RandomStream random_;
  double draws_s_ = 0, share_ = 1, share_wanted_ = 1, curvature_ = 0, curvature_wanted_ = 0;
};

}  // namespace kestrel::sim
