// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "records/log/log_tables.h"

namespace kestrel::records {

// What was wanted of something and what it was, each at its own times, s.
struct Asked {
  std::vector<double> wanted_s, wanted, flown_s, flown;
};

struct Estimate {
  double value = 0, sd = 0;
};

// What follows is gain times what is wanted, after a dead time and a lag of first order, and off by a constant.
struct Response {
  Estimate delay_s, lag_s, late_s, gain;  // late: delay and lag together, which is known better than each
  double explained = 0;                   // share of the variance
};

// By least squares. Deviations: by leaving out each sixth of the log in turn (jackknife).
// why: empty, or why there is none: too short, too little movement, or what was flown does not follow.
Response FitResponse(const Asked& asked, double least_movement, std::string& why);

// A parameter of an aircraft as its log tells it, or why it does not.
struct Identified {
  std::string name, unit;
  Estimate value;
  std::string missing;  // empty: it was found
};

std::vector<Identified> IdentifyUlog(const LogTables& tables);
std::vector<Identified> IdentifyDataFlash(const LogTables& tables);
std::vector<Identified> IdentifyTelemetry(const LogTable& table);

}  // namespace kestrel::records
