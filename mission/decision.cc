// SPDX-License-Identifier: Apache-2.0
#include "mission/decision.h"

namespace kestrel::mission {

const char* NameOf(TargetState state) {
  switch (state) {
    case TargetState::kNone:
      return "none";
    case TargetState::kInSight:
      return "in sight";
    case TargetState::kUncertain:
      return "uncertain";
    case TargetState::kLost:
      return "lost";
    case TargetState::kBlind:
      return "blind";
  }
  return "";
}

}  // namespace kestrel::mission
