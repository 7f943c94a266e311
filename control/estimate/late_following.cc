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

LateFollowing::Kind LateFollowing::OfTurns() {
  return {
      .prompt_climb_s = 0.5,
      .search = {.step_s = 0.05, .max_delay_s = 0.6, .max_lag_s = 0.8, .least_s = 1.5, .moved_climb = 0.05}};
}

void LateFollowing::Hear(double t_s, const Eigen::Vector3d& flown_N) {
  if (heard_) {
    std::optional<Eigen::Vector3d> asked_N;
    if (given_) asked_N = given_->first;
    estimator_.Add(heard_->t_s, asked_N, heard_->t_s, heard_->flown_N);
    if (given_)
      past_.push_back({heard_->t_s, given_->second});
    else
      past_.clear();
  }
  heard_ = Heard{t_s, flown_N};
  given_.reset();
  while (!past_.empty() && past_.front().t_s < t_s - 2 * kMaxLate_s) past_.pop_front();
  if (t_s - measured_s_ < kPeriod_s) return;
  measured_s_ = t_s;
  level_s_ = Reckoned_s(estimator_.Horizontal(), kind_.prompt_level_s, level_s_);
  climb_s_ = Reckoned_s(estimator_.Vertical(), kind_.prompt_climb_s, climb_s_);
}

void LateFollowing::Give(const Eigen::Vector3d& asked_N, const Eigen::Vector3d& flown_N) {
  if (heard_) given_ = {asked_N, flown_N};
}

double LateFollowing::Way(int axis, double late_s) const {
  double way = 0, until_s = heard_ ? heard_->t_s : 0;
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
