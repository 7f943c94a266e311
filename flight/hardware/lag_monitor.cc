// SPDX-License-Identifier: Apache-2.0
#include "flight/hardware/lag_monitor.h"

#include <fmt/format.h>

#include "geometry/tait_bryan.h"

namespace kestrel::flight {

std::string LagMonitor::Judge(const char* name,
                              const std::optional<control::VelocityLagEstimator::Late>& late, double max_s,
                              Direction& direction) {
  direction.late = late && late->min_s > max_s ? direction.late + 1 : 0;
  if (direction.told || direction.late < kInARow) return "";
  direction.told = true;
  const std::string text =
      fmt::format("follows {} velocities {:.1f} s late, the gains allow {:.2f} s", name, late->s, max_s);
  told_ += (told_.empty() ? "the autopilot " : ", and ") + text;
  return text;
}

std::string LagMonitor::Note(double now_s, const std::optional<control::Setpoint>& sent,
                             const control::VehicleState& state) {
  std::optional<Eigen::Vector3d> commanded_N;
  if (const auto* velocity = sent ? std::get_if<control::VelocitySetpoint>(&*sent) : nullptr)
    if (!state.landed) commanded_N = HeadingRotation(YawOf(state.R_NB)) * velocity->v_H;
  estimator_.Add(now_s, commanded_N, state.t_s, state.v_N);
  if (!judged_s_) judged_s_ = now_s;
  if (now_s - *judged_s_ < kPeriod_s) return "";
  judged_s_ = now_s;
  std::string text = Judge("horizontal", estimator_.Horizontal(), max_.horizontal_s, horizontal_);
  const std::string vertical = Judge("vertical", estimator_.Vertical(), max_.vertical_s, vertical_);
  return text + (text.empty() || vertical.empty() ? "" : "; ") + vertical;
}

}  // namespace kestrel::flight
