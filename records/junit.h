// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "records/telemetry/flight_log.h"

namespace kestrel::records {

// A check and how it came out.
struct JunitCase {
  std::string suite, classname, name;
  double wall_s = 0;
  std::string failure, error;  // why it did not pass, if it did not
};

// JUnit XML, as CI servers read it: a suite for each name of one, in the order of their first cases.
std::string JunitXml(const std::vector<JunitCase>& cases);

// The same of one or several runs: a suite for each scenario, a case for each criterion of each run with its
// value and limit where it failed, and a case "flight" for a run that broke off (an error), that has no
// criteria, or that did not pass for another reason than a criterion.
std::string ToJunit(const std::vector<Summary>& runs);

}  // namespace kestrel::records
