// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "base/yaml/fields.h"
#include "control/law/avoidance.h"
#include "control/law/looming.h"

namespace kestrel::scenarios {

struct GrowthOptions {
  double miss_share = 0.17;
  double turn_deg = 50;
  double open_deg = 20;
};

inline void Fields(FieldVisitor& v, GrowthOptions& o) {
  v({"miss_share",
     "closest distance to come, as a share of the distance now, below which another aircraft is a threat"},
    o.miss_share, 0.01, 1.0);
  v({"turn_deg", "turn off another aircraft that is not near the bow already, at least"}, o.turn_deg, 10.0,
    120.0);
  v({"open_deg", "how much farther off the bow one is held that is a threat still"}, o.open_deg, 0.0, 90.0);
}

// Another aircraft as images show it, in a frame whose axes do not turn: where it is relative to us and how
// that changes, in any unit of length.
struct Sighted {
  Eigen::Vector2d p = Eigen::Vector2d::Zero(), v = Eigen::Vector2d::Zero();
  bool known = true;  // seen just now, and long enough for its motion
};

// See and avoid without any range (thesis 6.4 has no more): begins, chooses the side and ends by the growth of
// an angle and the rate of the bearing alone.
class GrowthJudge {
 public:
  GrowthJudge(const GrowthOptions& growth, const control::AvoidanceOptions& avoidance, double confirm_s)
      : growth_(growth), avoidance_(avoidance), confirm_s_(confirm_s) {}

  void Change(const GrowthOptions& growth, const control::AvoidanceOptions& avoidance, double confirm_s) {
    growth_ = growth, avoidance_ = avoidance, confirm_s_ = confirm_s;
  }

  // Who of them matters most, and the bearing at which it is held while a manoeuvre lasts, rad, right positive.
  struct Judgement {
    std::optional<std::size_t> other;  // none: out of sight, and not yet passed
    control::LoomingApproach approach;
    std::optional<double> hold;
  };
  // back: where the way on would lead, rad from north. None: there are no others, and nobody is still to be
  // passed.
  std::optional<Judgement> Judge(double t_s, std::span<const Sighted> others, double yaw, double back);

 private:
  bool Lasts(bool is, double t_s);
  bool LeftBehind(const Sighted& other, double back) const;

  GrowthOptions growth_;
  control::AvoidanceOptions avoidance_;
  double confirm_s_;
  std::optional<control::PassingSide> side_;  // of the manoeuvre that is flown
  double bearing_ = 0;                        // rad, off the bow to that side
  std::optional<double> since_s_;             // what would change that has been so
  double passed_s_ = 0;                       // when those whose motion was known last are passed
};

}  // namespace kestrel::scenarios
