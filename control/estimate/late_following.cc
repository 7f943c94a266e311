// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/late_following.h"

#include <algorithm>

namespace kestrel::control {
namespace {

constexpr double kPeriod_s = 1;     // between two measurements
constexpr double kMaxLate_s = 2.5;  // more is not reckoned with

// It counts as late from where a measurement is sure that it is, and until one says that it is not.
double Reckoned_s(const std::optional<VelocityLagEstimator::Late>& measured, double prompt_s,
                  double before_s) {
  if (!measured) return before_s;
  if (before_s > 0 ? measured->s <= prompt_s : measured->min_s <= prompt_s) return 0;
  return std::min(measured->s, kMaxLate_s);
}

}  // namespace

void LateFollowing::Hear(const VehicleState& state) {
  if (state_) {
    std::optional<Eigen::Vector3d> asked_N;
    if (given_) asked_N = given_->first;
    estimator_.Add(state_->t_s, asked_N, state_->t_s, state_->v_N);
    if (given_)
      past_.push_back({state_->t_s, given_->second});
    else
      past_.clear();
  }
  state_ = state;
  given_.reset();
  while (!past_.empty() && past_.front().t_s < state.t_s - 2 * kMaxLate_s) past_.pop_front();
  if (state.t_s - measured_s_ < kPeriod_s) return;
  measured_s_ = state.t_s;
  level_s_ = Reckoned_s(estimator_.Horizontal(), kPromptLevel_s, level_s_);
  climb_s_ = Reckoned_s(estimator_.Vertical(), kPromptClimb_s, climb_s_);
}

void LateFollowing::Give(const Eigen::Vector3d& asked_N, const Eigen::Vector3d& flown_N) {
  if (state_) given_ = {asked_N, flown_N};
}

double LateFollowing::Way(int axis, double late_s) const {
  double way = 0, until_s = state_ ? state_->t_s : 0;
  const double from_s = until_s - late_s;
  for (auto each = past_.rbegin(); each != past_.rend() && until_s > from_s; ++each) {
    const double since_s = std::max(each->t_s, from_s);
    way += (until_s - since_s) * each->flown_N[axis];
    until_s = since_s;
  }
  return way;
}

Eigen::Vector3d LateFollowing::ToCome_N() const {
  return {level_s_ > 0 ? Way(0, level_s_) : 0, level_s_ > 0 ? Way(1, level_s_) : 0,
          climb_s_ > 0 ? Way(2, climb_s_) : 0};
}

}  // namespace kestrel::control
