// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>

#include "control/law/fuzzy/fuzzy_controller.h"

// What fuzzylite 6 answers to the same controller, whose rules it reads as they stand; for the tests alone.
namespace kestrel::fuzzylite {

class Engine {
 public:
  // samples: of each output's range, by which it computes its centroid.
  Engine(const control::FuzzyController& controller, int samples);
  ~Engine();
  // Inputs within their ranges. An output of which no rule says anything is NaN.
  std::map<std::string, double> Outputs(const std::map<std::string, double>& inputs);

 private:
  struct Of;
  std::unique_ptr<Of> of_;
};

}  // namespace kestrel::fuzzylite
