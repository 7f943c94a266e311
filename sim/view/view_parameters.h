// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/yaml/fields.h"

namespace kestrel::sim {

// A place in the world.
struct ViewPlace {
  double north_m = 0, east_m = 0, height_m = 1.7;
};

// A camera that watches the aircraft from outside:
// - chase: behind and above, with the aircraft's heading, which it follows softly;
// - tower: from a fixed place at eye height beside the pad; it zooms so that the aircraft stays large;
// - orbit: slowly round it;
// - top: from above, north up;
// - free: from a place of one's own.
struct ViewParameters {
  std::string kind = "chase";
  int width_px = 960, height_px = 540;
  double fov_deg = 50;
  double distance_m = 0;  // 0: by the size of the aircraft
  std::optional<ViewPlace> position, look_at;
};

inline const std::vector<std::string>& KindsOfView() {
  static const std::vector<std::string> kinds = {"chase", "tower", "orbit", "top", "free"};
  return kinds;
}

// What the lens and the memory of a video bear.
inline constexpr int kLeastViewSide_px = 16, kMostViewSide_px = 7680;

inline void Fields(FieldVisitor& v, ViewPlace& p) {
  v({"north_m", "to the north of the origin"}, p.north_m, -1e4, 1e4);
  v({"east_m", "to the east of the origin"}, p.east_m, -1e4, 1e4);
  v({"height_m", "above the ground"}, p.height_m, 0.05, 1e4);
}

inline void Fields(FieldVisitor& v, ViewParameters& p) {
  v({"kind",
     "chase: behind and above; tower: from a fixed place at eye height, zooming; orbit: slowly round the "
     "aircraft; top: from above; free: from position"},
    p.kind, KindsOfView());
  v({"width_px", "width of the picture"}, p.width_px, kLeastViewSide_px, kMostViewSide_px);
  v({"height_px", "height of the picture"}, p.height_px, kLeastViewSide_px, kMostViewSide_px);
  v({"fov_deg", "field over the width of the picture; of tower: the widest"}, p.fov_deg, 2.0, 120.0);
  v({"distance_m", "of chase, orbit and top from the aircraft; 0: by the aircraft's size"}, p.distance_m, 0.0,
    1000.0);
  v({"position",
     "place of the camera, of tower and free; null: of tower beside the pad, of free where tower is"},
    p.position);
  v({"look_at", "place that free looks at; null: the aircraft"}, p.look_at);
}

}  // namespace kestrel::sim
