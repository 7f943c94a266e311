// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace kestrel::sim {

// What came over a server's wire, each message counted once, however long it is followed.
struct WireCounts {
  struct Kind {
    std::uint64_t count = 0;
    std::string first;  // the first of them, in words
  };

  std::uint64_t setpoints = 0;  // of the session, and understood
  std::uint64_t followed = 0;   // of these: the others came in another mode, or against the pilot's switch
  std::uint64_t refused = 0;    // setpoints of the session that are not flown, or that no aircraft could fly
  std::map<std::string, std::uint64_t>
      sightings;  // what a camera saw, by the name of the message; not flown by
  // All that came and was ignored, by kind, in words: "damaged datagrams". Setpoints are among them.
  std::map<std::string, Kind> ignored;

  void CountIgnored(const std::string& kind, const std::string& it, std::uint64_t times = 1) {
    if (times == 0) return;
    Kind& all = ignored[kind];
    if (all.count == 0) all.first = it;
    all.count += times;
  }
};

namespace ignored {
inline constexpr char kImpossible[] = "setpoints that cannot be followed";
inline constexpr char kPilot[] = "setpoints while the pilot's switch was off";
inline constexpr char kOtherMode[] = "setpoints outside the mode in which they are followed";
inline constexpr char kToAnother[] = "setpoints to another system";
inline constexpr char kDamaged[] = "damaged messages";
inline constexpr char kAgain[] = "messages that came twice or late";
inline constexpr char kSecondClient[] = "clients refused, as another has the session";
inline constexpr char kNoSession[] = "messages from an address without the session";
}  // namespace ignored

}  // namespace kestrel::sim
