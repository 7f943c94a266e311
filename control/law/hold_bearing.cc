// SPDX-License-Identifier: Apache-2.0
#include "control/law/hold_bearing.h"

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::control {

HoldBearingStep HoldBearing(const HoldBearingState& state, std::optional<double> azimuth,
                            const HoldBearingGains& gains) {
  HoldBearingStep step;
  step.state = state;
  if (!azimuth || !std::isfinite(*azimuth)) return step;
  if (!step.state.side) step.state.side = *azimuth > 0 ? PassingSide::kLeft : PassingSide::kRight;
  const double wanted =
      Radians(step.state.side == PassingSide::kLeft ? gains.bearing_deg : -gains.bearing_deg);
  const double limit = Radians(gains.yaw_rate_limit_deg_s);
  step.status = HoldBearingStatus::kHolding;
  step.error = WrapAngle(*azimuth - wanted);
  step.yaw_rate = std::clamp(gains.lambda_per_s * step.error, -limit, limit);  // eq. (6.29)
  return step;
}

}  // namespace kestrel::control
