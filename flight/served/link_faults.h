// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/safety/safety.h"
#include "flight/served/wire_flight.h"

// What befalls a wire in flight, and what is to follow, as control/safety/safety.h has it.
namespace kestrel::flight {

struct FaultRow {
  WireFault fault;
  std::string_view name;
  // The hazard that the safety layer is to see, and what it does first and later; kNone: the flight goes on,
  // and lands.
  control::Hazard hazard;
  control::Reaction first, later;
  double control::SafetyLimits::*limit;  // within which the first follows, of when the fault began
  bool by_datagrams;                     // of wires that have them
};

inline constexpr std::array kFaults{
    FaultRow{WireFault::kLinkCut, "link cut", control::Hazard::kStateLost, control::Reaction::kHold,
             control::Reaction::kSilence, &control::SafetyLimits::state_s, false},
    FaultRow{WireFault::kCameraCut, "camera cut", control::Hazard::kImageStale, control::Reaction::kHold,
             control::Reaction::kSink, &control::SafetyLimits::image_s, false},
    FaultRow{WireFault::kServerKilled, "simulator killed", control::Hazard::kStateLost,
             control::Reaction::kHold, control::Reaction::kSilence, &control::SafetyLimits::state_s, false},
    FaultRow{WireFault::kLost, "30 % lost", control::Hazard::kNone, control::Reaction::kFly,
             control::Reaction::kFly, nullptr, true},
    FaultRow{WireFault::kDoubled, "doubled", control::Hazard::kNone, control::Reaction::kFly,
             control::Reaction::kFly, nullptr, true},
    FaultRow{WireFault::kReordered, "reordered", control::Hazard::kNone, control::Reaction::kFly,
             control::Reaction::kFly, nullptr, true},
    FaultRow{WireFault::kDelayed, "delayed by 200 ms", control::Hazard::kNone, control::Reaction::kFly,
             control::Reaction::kFly, nullptr, true},
};

// Beyond the limit: the safety layer looks every 0.02 s, and an image or a state may have been under way.
inline constexpr double kReactionMargin_s = 0.1;
inline constexpr double kPatience_s = 2;  // of these flights, instead of SafetyLimits::patience_s

// The flight in which a fault is seen to the end, or the landing with it. seed: also of when it begins.
WireFlightOptions FlightWith(const FaultRow& row, Wire wire, std::uint64_t seed,
                             const std::filesystem::path& folder);

struct FaultJudgement {
  std::vector<std::string> wrong;    // empty: all was as written
  std::optional<double> reaction_s;  // from the fault until the first reaction
};

// Of a cut: by the program's events.log, the first and the later reaction in their time, and no other between
// them but silence; of the camera's also that the zero velocity was heard, and after the patience the
// sinking; of the link's that the aircraft, left alone, stands. Of datagrams: that it landed within
// most_error_m.
FaultJudgement JudgeFault(const FaultRow& row, const WireFlown& flown, const control::SafetyLimits& limits,
                          double most_error_m = 0.2);

}  // namespace kestrel::flight
