// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/run_result.h"

#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <utility>

namespace kestrel::campaign {
namespace {

constexpr std::array<std::pair<RunStatus, std::string_view>, 6> kNames = {
    {{RunStatus::kPassed, "passed"},
     {RunStatus::kFailed, "failed"},
     {RunStatus::kBrokeOff, "broke off"},
     {RunStatus::kRefused, "refused"},
     {RunStatus::kCrashed, "crashed"},
     {RunStatus::kTimedOut, "timed out"}}};

}  // namespace

std::string_view NameOf(RunStatus status) {
  for (const auto& [each, name] : kNames)
    if (each == status) return name;
  return "";
}

RunStatus RunStatusOf(std::string_view name) {
  for (const auto& [status, each] : kNames)
    if (each == name) return status;
  throw std::runtime_error(fmt::format("'{}' is no status of a run", name));
}

}  // namespace kestrel::campaign
