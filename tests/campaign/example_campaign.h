// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include "base/random.h"
#include "campaign/statistics/comparison.h"

namespace kestrel::campaign {

// 300 landings in wind, of which those in more than 5.7 m/s fail, and some that never touch down.
inline CampaignResults ExampleCampaign() {
  CampaignResults campaign;
  campaign.identity.name = "dispersion";
  campaign.identity.version = "1.0 abc";
  campaign.identity.scenario =
      "mission: landing\npilot: {lambda: 0.6}\ncriteria:\n  touchdown_error_m: {max: 0.15}\n  fix_share: "
      "{min: 0.5}\n"
      "  height_m: {min: 1, max: 2}\n";
  campaign.identity.plan = "scenario: landing\nruns: 300\nmetrics: [touchdown_error_m, fix_share]\n";
  campaign.identity.table.keys = {"seed", "wind.mean_m_s", "camera"};
  RandomStream random(1, "example");
  for (int row = 0; row < 300; ++row) {
    const double wind = random.Uniform(0, 6);
    campaign.identity.table.rows.push_back(
        {fmt::format("{}", row), fmt::format("{}", wind), row % 2 ? "pinhole" : "fisheye"});
    RunResult run;
    run.row = row;
    run.status = wind > 5.7 ? row % 3 ? RunStatus::kFailed : RunStatus::kTimedOut : RunStatus::kPassed;
    run.outcome = run.status == RunStatus::kPassed   ? "landed"
                  : run.status == RunStatus::kFailed ? "target lost"
                                                     : "took longer than 600 s";
    run.metrics["max_tilt_deg"] = 3 * wind + random.Normal();
    if (run.status != RunStatus::kTimedOut) {
      run.metrics["touchdown_error_m"] = 0.02 * wind + 0.01 * std::abs(random.Normal());
      run.metrics["fix_share"] = random.Uniform(0.9, 1);
    }
    campaign.results.push_back(run);
  }
  return campaign;
}

}  // namespace kestrel::campaign
