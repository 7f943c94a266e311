// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "base/yaml/fields.h"
#include "control/estimate/hover_observer.h"
#include "control/law/direct/direct_hover.h"
#include "mission/mission_type.h"

namespace kestrel::scenarios {

struct PhotometricParameters {
  double within_m = 0.15;
  double blur_px = 2;
  double max_residual_grey = 25;
};

inline void Fields(FieldVisitor& v, PhotometricParameters& p) {
  v({"within_m", "offset from the goal within which the grey levels take over from the points"}, p.within_m,
    0.01, 2.0);
  v({"blur_px", "blur of both images, which widens the reach of the grey levels"}, p.blur_px, 0.0, 20.0);
  v({"max_residual_grey", "RMS difference of the images above which the points take over again"},
    p.max_residual_grey, 1.0, 255.0);
}

// Direct visual servoing, thesis 5.2.2: hovers over the pad by rates and thrust that follow from what the
// camera sees, without the autopilot's loops of position, velocity and attitude.
struct HoverDirectFlight {
  std::string law = "points";
  double height_m = 2, yaw_deg = 0;
  std::string attitude = "autopilot";
  bool predict = true;
  control::DirectGains gains;
  control::HoverObserverOptions observer;
  PhotometricParameters photometric;
  double lost_s = 0.25;
};

inline void Fields(FieldVisitor& v, HoverDirectFlight& p) {
  v({"law",
     "what tells the offset from the goal: the corners of the pad in the image, or all its grey levels, once "
     "the points have come near"},
    p.law, {"points", "photometric"});
  v({"height_m", "height above the pad at which the aircraft hovers"}, p.height_m, 0.5, 20.0);
  v({"yaw_deg", "heading to hold, clockwise from the top of the pad's picture"}, p.yaw_deg, -180.0, 180.0);
  v({"attitude",
     "what tells roll and pitch: the autopilot's inertial estimate, or the camera's pose of the pad, and "
     "rate "
     "gyros alone"},
    p.attitude, {"autopilot", "camera"});
  v({"predict", "carry what was seen on to now by what was done since; false: fly by it as if it were now"},
    p.predict);
  v({"gains", "gains and limits from offset to rates and thrust"}, p.gains);
  v({"observer", "observer of velocity and disturbance by the offset alone"}, p.observer);
  v({"photometric", "servoing by grey levels"}, p.photometric);
  v({"lost_s", "time without an offset after which the autopilot's own loops hold and look for the pad"},
    p.lost_s, 0.02, 5.0);
}

mission::MissionType TypeOf(const HoverDirectFlight& flight);
void CheckFlight(const HoverDirectFlight& flight, const Place& where, Mistakes& mistakes);
void CheckFlightView(const HoverDirectFlight& flight, const vision::CameraModel& camera,
                     const vision::CameraMount& mount, const Place& where, const Place& mount_where,
                     Mistakes& mistakes);
std::unique_ptr<mission::Mission> MakeMission(const HoverDirectFlight& flight,
                                              const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
