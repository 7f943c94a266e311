// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "base/yaml/fields.h"

// See and avoid: flying on at constant speed and height while the yaw rate holds the other aircraft at a
// bearing off the bow, thesis 6.4, eq. (6.29), which needs neither its range nor its path.
// Deviations: with the derivative of (6.24) the azimuth falls by the yaw rate, so the law has no minus (in
// the print the matrix and the law have each turned the sign). And a bearing short of 90 degrees that is held
// does not keep the distance to a thing that stands still: the range falls by v cos(bearing), a spiral
// inward. The thesis has no end of the manoeuvre; whoever calls this must have one.
namespace kestrel::control {

struct HoldBearingGains {
  double lambda_per_s = 1;
  double bearing_deg = 50;  // thesis 6.4.3
  double yaw_rate_limit_deg_s = 40;
};

inline void Fields(FieldVisitor& v, HoldBearingGains& g) {
  v({"lambda_per_s", "proportional gain from bearing error to yaw rate"}, g.lambda_per_s, 0.1, 5.0);
  v({"bearing_deg", "minimum bearing off the bow, on either side, at which another aircraft is held"},
    g.bearing_deg, 10.0, 180.0);
  v({"yaw_rate_limit_deg_s", "maximum yaw rate that is commanded, and with which manoeuvres are planned"},
    g.yaw_rate_limit_deg_s, 1.0, 180.0);
}

enum class PassingSide { kLeft, kRight };  // of the other, as we see it: left keeps it to our right

// Begins empty with each encounter. The side is chosen at the first bearing and kept: a second choice in the
// middle of the manoeuvre would turn across the bow.
struct HoldBearingState {
  std::optional<PassingSide> side;
};

enum class HoldBearingStatus {
  kHolding,
  kNoBearing,  // not seen, or right above or below: straight on
};

struct HoldBearingStep {
  HoldBearingStatus status = HoldBearingStatus::kNoBearing;
  HoldBearingState state;
  double yaw_rate = 0;  // rad/s, clockwise from above
  double error = 0;     // azimuth less that to hold, rad, (-pi, pi]
};

// azimuth: of the other in the heading frame H, rad, to the right positive (control/law/bearing_servo.h).
// Thesis 6.4.3: seen to the right it is passed to its left, and the other way round; dead ahead we give way
// to the right, as the rules of the air have it.
HoldBearingStep HoldBearing(const HoldBearingState& state, std::optional<double> azimuth,
                            const HoldBearingGains& gains);

}  // namespace kestrel::control
