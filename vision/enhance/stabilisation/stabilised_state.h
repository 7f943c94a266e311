// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel::vision {

enum class StabilisedState {
  kFirst,        // of the video
  kFollowed,     // its motion is measured
  kRecovered,    // it is measured by a search, after a jump
  kTextureless,  // too little to be seen: taken to stand still, until there is more
  kCut,          // nothing of the image before is in it: a new beginning
  kResized,      // its size is another one: a new beginning
  kReanchored,   // the reference had left the view: this is the new one
  kGyro,         // by attitudes alone, as asked for
  kGyroAlone,    // by attitudes, since vision found no motion
  kUnreadable,   // its file is damaged: left out
  kNoAttitude,  // attitudes are asked for, and of this time there are none: taken to stand still but for what is seen
};
const char* NameOf(StabilisedState state);

}  // namespace kestrel::vision
