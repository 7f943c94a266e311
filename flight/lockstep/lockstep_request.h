// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>

#include "control/autopilot.h"

// The requests of the lockstep protocol (docs/guide/lockstep.md): a JSON object each, of strict keys.
namespace kestrel::flight {

inline constexpr int kLockstepVersion = 1;
// Of a request's JSON. Who says that more is to come does not speak this protocol.
inline constexpr std::uint32_t kLongestRequest = 64 * 1024;

// What is wrong with a request, or with when it comes: it has changed nothing.
struct LockstepError : std::runtime_error {
  LockstepError(const char* kind_, const std::string& what) : std::runtime_error(what), kind(kind_) {}
  const char* kind;                         // "message", "version", "token", "value", "state", ...
  std::optional<std::uint64_t> token = {};  // of the request, as far as it was read
};

struct HelloRequest {
  std::string client;          // its name, for the log; may be empty
  bool inline_images = false;  // behind the reply's JSON, in place of shared memory
};
struct ResetRequest {
  std::optional<std::uint64_t> seed;
  bool images = true, surfaces = false, records = true;
};
struct StepRequest {
  std::optional<control::Setpoint> setpoint;
  std::optional<control::AttitudeAid> aid;
};
struct AdvanceRequest {
  double duration_s = 0;
  std::optional<control::Setpoint> setpoint;
};
struct DecideRequest {};
struct TruthRequest {};
struct SummaryRequest {};
struct FinishRequest {
  std::string outcome;
};
struct ByeRequest {};

struct LockstepRequest {
  std::optional<std::uint64_t> token;  // all have one but hello
  std::variant<HelloRequest, ResetRequest, StepRequest, AdvanceRequest, DecideRequest, TruthRequest,
               SummaryRequest, FinishRequest, ByeRequest>
      body;
};

// Throws LockstepError.
LockstepRequest ParseLockstepRequest(std::string_view json);

}  // namespace kestrel::flight
