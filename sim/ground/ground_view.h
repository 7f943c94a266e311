// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "base/yaml/fields.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/pan_tilt.h"
#include "vision/aircraft/ground_camera.h"

namespace kestrel::sim {

// A time in which something stands close before the lens.
struct BlockedTime {
  double from_s = 0, until_s = 0;
};

// How far the camera on the ground is from its place: normal, drawn once a run.
struct GroundPlaceError {
  double position_m = 0.03, angle_deg = 0.1;
};

// Of its image sensor by default: in colour, as fast as the lights move, with the delay of a network.
inline ImageParameters GroundImage() {
  ImageParameters image;
  image.colour = true;
  image.rate_hz = 30;
  image.latency_s = 0.08;
  return image;
}

// What a camera on the ground is like beyond what flight code knows of it (vision/aircraft/ground_camera.h).
struct GroundViewParameters {
  ImageParameters image = GroundImage();
  std::optional<vision::GroundPlace> place;
  std::optional<PanTiltParameters> head;
  double encoder_deg = 0.02;
  GroundPlaceError error;
  double clock_offset_s = 0;
  std::vector<BlockedTime> blocked;
};

inline void Fields(FieldVisitor& v, BlockedTime& p) {
  v({"from_s", "when it comes, in the time of the flight"}, p.from_s, 0.0, 1e9);
  v({"until_s", "when it goes"}, p.until_s, 0.0, 1e9);
}

inline void Fields(FieldVisitor& v, GroundPlaceError& p) {
  v({"position_m", "standard deviation of each coordinate"}, p.position_m, 0.0, 5.0);
  v({"angle_deg", "standard deviation of each angle"}, p.angle_deg, 0.0, 20.0);
}

inline void Fields(FieldVisitor& v, GroundViewParameters& p) {
  v({"image", "image sensor and lens of the camera on the ground"}, p.image);
  v({"place", "where it truly stands; null: where the flight believes it, in ground_camera"}, p.place);
  v({"head", "pan-tilt head on the mast, which the flight turns; null: the camera is fixed"}, p.head);
  v({"encoder_deg", "resolution of the encoders of the head"}, p.encoder_deg, 0.0, 5.0);
  v({"error", "how far the camera is from that place, drawn by the seed"}, p.error);
  v({"clock_offset_s", "how far its clock, by which its frames are stamped, is ahead of the autopilot's"},
    p.clock_offset_s, -10.0, 10.0);
  v({"blocked", "times in which something stands close before its lens"}, p.blocked);
}

}  // namespace kestrel::sim
