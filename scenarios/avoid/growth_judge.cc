// SPDX-License-Identifier: Apache-2.0
#include "scenarios/avoid/growth_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/tait_bryan.h"

namespace kestrel::scenarios {
namespace {

constexpr double kDrifts = 0.1;  // miss_share from which the bearing's own drift says on which side it passes
const double kThere = Radians(10);  // off the bearing that is held: the turn is done
constexpr double kLate = 5;  // multiples of the horizon: who comes so late does not keep a manoeuvre going

}  // namespace

// Whether something has been so for confirm_s; asked of one thing after the other.
bool GrowthJudge::Lasts(bool is, double t_s) {
  if (!is)
    since_s_.reset();
  else if (!since_s_)
    since_s_ = t_s;
  if (!since_s_ || t_s - *since_s_ < confirm_s_) return false;
  since_s_.reset();
  return true;
}

// Whether a turn to `back` leaves another on the side on which it is held, as far off the bow as turns do, or
// astern. That they part is not enough: whom we outran the turn back would meet.
bool GrowthJudge::LeftBehind(const Sighted& other, double back) const {
  const double azimuth = WrapAngle(std::atan2(other.p.y(), other.p.x()) - back);
  const double off_bow = side_ == control::PassingSide::kLeft ? azimuth : -azimuth;
  return off_bow > Radians(avoidance_.hold.bearing_deg) || std::abs(azimuth) > Radians(90);
}

std::optional<GrowthJudge::Judgement> GrowthJudge::Judge(double t_s, std::span<const Sighted> others,
                                                         double yaw, double back) {
  if (others.empty()) {
    if (side_ && t_s < passed_s_) return Judgement{};
    side_.reset(), since_s_.reset();
    return std::nullopt;
  }
  Judgement is;
  bool threatened = false, parting = true;
  double soonest = std::numeric_limits<double>::infinity();
  control::Looming held;
  for (std::size_t i = 0; i < others.size(); ++i) {
    const control::Looming looming = control::LoomingOf(others[i].p, others[i].v);
    const control::LoomingApproach approach = control::ApproachOf(looming);
    const bool threat = approach.after_s > 0 && approach.after_s < avoidance_.horizon_s &&
                        approach.miss_share < growth_.miss_share;
    const bool nears = approach.after_s > 0 && approach.after_s < kLate * avoidance_.horizon_s;
    // Whose motion is not known is not turned back to before it is passed, as far as was known.
    if (others[i].known && nears) passed_s_ = t_s + std::min(approach.after_s, 2 * avoidance_.horizon_s);
    parting = parting && !nears && (others[i].known || t_s > passed_s_) && LeftBehind(others[i], back);
    const double rank = threat ? approach.after_s : nears ? 1e3 + approach.after_s : 1e6;
    threatened = threatened || threat;
    if (rank < soonest) soonest = rank, is.other = i, is.approach = approach, held = looming;
  }
  const Eigen::Vector2d& p = others[*is.other].p;
  const double azimuth = WrapAngle(std::atan2(p.y(), p.x()) - yaw);
  const double most = Radians(avoidance_.max_bearing_deg);
  const auto off_bow = [&](control::PassingSide side) {
    return side == control::PassingSide::kLeft ? azimuth : -azimuth;
  };
  if (!side_) {
    if (Lasts(threatened, t_s)) {
      // Whoever drifts is let drift on. Who stays off the bow does not stand still: it comes across from that
      // side, and is passed behind. Else by the sign of the bearing, thesis 6.4.3.
      const bool crosses = std::abs(std::sin(azimuth)) > growth_.miss_share;
      const bool right = is.approach.miss_share > kDrifts ? held.bearing_rate > 0 : (azimuth > 0) != crosses;
      side_ = right ? control::PassingSide::kLeft : control::PassingSide::kRight;
      bearing_ =
          std::clamp(off_bow(*side_) + Radians(growth_.turn_deg), Radians(avoidance_.hold.bearing_deg), most);
    }
  } else if (parting) {
    if (Lasts(true, t_s)) side_.reset();
  } else if (Lasts(threatened && off_bow(*side_) > bearing_ - kThere, t_s)) {
    bearing_ = std::min(most, bearing_ + Radians(growth_.open_deg));
  }
  if (side_) is.hold = *side_ == control::PassingSide::kLeft ? bearing_ : -bearing_;
  return is;
}

}  // namespace kestrel::scenarios
