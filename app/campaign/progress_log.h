// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "campaign/execution/run_campaign.h"

namespace kestrel::app {

// "120 runs/min, 3 min 20 s left"; empty where nothing flew yet.
std::string TimeLeft(const campaign::Progress& progress);

// How far a campaign is, for a log that nobody watches: a line for every tenth of its runs, and after half a
// minute without one.
class ProgressLog {
 public:
  explicit ProgressLog(std::string name) : name_(std::move(name)) {}
  // The line that is due, with its end; empty: none is.
  std::string Line(const campaign::Progress& progress);

 private:
  std::string name_;
  std::int64_t tenths_ = -1;  // that were told; -1: nothing was asked yet
  double told_s_ = 0;
};

}  // namespace kestrel::app
