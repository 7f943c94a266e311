// SPDX-License-Identifier: Apache-2.0
// A dead time that the emulated autopilot is given is found in the flight's log again.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "geometry/tait_bryan.h"
#include "records/log/identification.h"
#include "tests/acceptance/flown.h"

namespace kestrel {
namespace {

records::Estimate LateBy(const std::string& delay) {
  records::LogTable log;
  for (const records::LogRow& row :
       Flown("follow", 151, {"autopilot.level_delay_s=" + delay, "duration_s=40"}).rows) {
    const auto* asked =
        row.decision.setpoint ? std::get_if<control::VelocitySetpoint>(&*row.decision.setpoint) : nullptr;
    const TaitBryan attitude = TaitBryanFromRotation(row.estimate.R_NB.toRotationMatrix());
    log["t_s"].push_back(row.now.t_s);
    log["setpoint_vx_m_s"].push_back(asked ? asked->v_H.x() : std::numeric_limits<double>::quiet_NaN());
    log["estimate_yaw_deg"].push_back(Degrees(attitude.yaw));
    log["estimate_vx_m_s"].push_back(row.estimate.v_N.x());
    log["estimate_vy_m_s"].push_back(row.estimate.v_N.y());
  }
  for (const records::Identified& each : records::IdentifyTelemetry(log)) {
    if (each.name != "velocity forward, late by") continue;
    EXPECT_EQ(each.missing, "");
    return each.value;
  }
  ADD_FAILURE() << "nothing is told of the velocity";
  return {};
}

TEST(IdentificationFlights, ADeadTimeOfTheAutopilotIsFoundAgain) {
  const records::Estimate as_it_is = LateBy("0"), later = LateBy("0.4");
  const double sd = std::hypot(as_it_is.sd, later.sd);
  EXPECT_LT(sd, 0.05);
  EXPECT_NEAR(later.value - as_it_is.value, 0.4, 3 * sd);
}

}  // namespace
}  // namespace kestrel
