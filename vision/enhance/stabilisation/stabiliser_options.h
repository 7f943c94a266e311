// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/yaml/fields.h"
#include "vision/enhance/motion/image_motion.h"

namespace kestrel::vision {

struct StabiliserOptions {
  std::string mode = "smooth";
  std::string by = "vision";
  double lag_s = 2, cutoff_hz = 0.2;
  double crop = 0.85;
  bool scale = true, bound = true, level = false;
  std::string border = "black";
  ImageMotionOptions motion;
};

inline void Fields(FieldVisitor& v, StabiliserOptions& o) {
  v({"mode",
     "reference: the view stands still as it was in the first image; smooth: it goes along a smooth path, "
     "lag_s late; "
     "offline: the same with all the images that count"},
    o.mode, {"reference", "smooth", "offline"});
  v({"by",
     "vision: a plane's motion in the images; sphere: the camera's rotation, by vision; gyro: its rotation "
     "by attitudes "
     "alone; both: its rotation by attitudes, and the rest by vision. All but vision need a camera"},
    o.by, {"vision", "sphere", "gyro", "both"});
  v({"lag_s", "how late a smooth view comes, s"}, o.lag_s, 0.0, 10.0);
  v({"cutoff_hz",
     "motions of a smooth path, which goes along with slower ones; what is faster than 2.5 times it is taken "
     "out"},
    o.cutoff_hz, 0.05, 5.0);
  v({"crop", "share of the image's width and height that is shown"}, o.crop, 0.2, 1.0);
  v({"scale", "enlarge what is shown to the image's size"}, o.scale);
  v({"bound", "a smooth path keeps what is shown within the image, at the cost of its smoothness"}, o.bound);
  v({"level", "turn the view until the horizon is level, where it is given"}, o.level);
  v({"border",
     "of what no image shows: black; blurred: the image's rim, blurred; filled: earlier images where they "
     "saw it"},
    o.border, {"black", "blurred", "filled"});
  Fields(v, o.motion);
}

}  // namespace kestrel::vision
