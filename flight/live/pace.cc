// SPDX-License-Identifier: Apache-2.0
#include "flight/live/pace.h"

#include <algorithm>
#include <limits>

namespace kestrel::flight {
namespace {

constexpr double kWindow_s = 0.5;

}  // namespace

bool Pace::Valid(double speed) { return speed == kAsFast || (speed >= kLeast && speed <= kMost); }

void Pace::Pause() {
  paused_ = true;
  steps_ = 0;
}

void Pace::Resume() {
  paused_ = false;
  steps_ = 0;
  zero_.reset();
  since_.reset();
}

void Pace::Step() {
  paused_ = true;
  ++steps_;
}

void Pace::SetSpeed(double speed) {
  speed_ = speed;
  zero_.reset();
  since_.reset();
}

void Pace::Flown(double wall_s, double t_s) {
  if (paused_) {
    if (steps_ > 0) --steps_;
    return;
  }
  if (!since_) since_ = At{wall_s, t_s};
  if (wall_s - since_->wall_s < kWindow_s) return;
  factor_ = (t_s - since_->t_s) / (wall_s - since_->wall_s);
  since_ = At{wall_s, t_s};
}

double Pace::Wait_s(double wall_s, double t_s) {
  if (paused_) return steps_ > 0 ? 0 : std::numeric_limits<double>::infinity();
  if (speed_ == kAsFast) return 0;
  if (!zero_) zero_ = At{wall_s, t_s};
  const double wait_s = zero_->wall_s + (t_s - zero_->t_s) / speed_ - wall_s;
  if (wait_s < -kCatchUp_s) zero_->wall_s -= wait_s + kCatchUp_s;
  return std::max(wait_s, 0.0);
}

}  // namespace kestrel::flight
