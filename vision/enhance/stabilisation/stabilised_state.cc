// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/stabilised_state.h"

namespace kestrel::vision {

const char* NameOf(StabilisedState state) {
  switch (state) {
    case StabilisedState::kFirst:
      return "first";
    case StabilisedState::kFollowed:
      return "followed";
    case StabilisedState::kRecovered:
      return "recovered";
    case StabilisedState::kTextureless:
      return "textureless";
    case StabilisedState::kCut:
      return "cut";
    case StabilisedState::kResized:
      return "resized";
    case StabilisedState::kReanchored:
      return "reanchored";
    case StabilisedState::kGyro:
      return "gyro";
    case StabilisedState::kGyroAlone:
      return "gyro_alone";
    case StabilisedState::kUnreadable:
      return "unreadable";
    case StabilisedState::kNoAttitude:
      return "no_attitude";
  }
  return "";
}

}  // namespace kestrel::vision
