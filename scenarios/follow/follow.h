// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "mission/balloon_observer.h"
#include "mission/mission_type.h"
#include "vision/camera/camera_model.h"

namespace kestrel::scenarios {

// Where in the image the balloon is wanted, from a time on: thesis 5.4.2, u* and phi*. In the image of a
// level pinhole that looks straight ahead from where the camera is, with the camera's own focal length.
struct FollowReference {
  double from_s = 0;
  double u_px = 0, v_px = 0;
  double diameter_px = 60;
};

inline void Fields(FieldVisitor& v, FollowReference& r) {
  v({"from_s", "time from which this image of the balloon is wanted"}, r.from_s, 0.0, 1e6);
  v({"u_px", "wanted position of the balloon's centre, to the right of the image's middle"}, r.u_px, -2000.0,
    2000.0);
  v({"v_px", "wanted position of the balloon's centre, down from the image's middle"}, r.v_px, -2000.0,
    2000.0);
  v({"diameter_px", "wanted diameter of the balloon in the image"}, r.diameter_px, 4.0, 2000.0);
}

struct FollowGains {
  Eigen::Vector3d lambda_per_s{4.0, 2.5, 1.0};
  bool feed_forward = true;  // the thesis has none
  // How long the aircraft takes to obey: it is steered by the image to be had after that, if it goes on as it
  // does. An answer of first order then is as if there were no delay; the thesis has none of this.
  double velocity_response_s = 0.4, yaw_response_s = 0.45;
  double speed_limit_m_s = 3, climb_limit_m_s = 1.5, yaw_rate_limit_deg_s = 80;
  double min_height_m = 1;
};

inline void Fields(FieldVisitor& v, FollowGains& g) {
  v({"lambda_per_s", "proportional gains of the errors in u, v and diameter of the balloon's image"},
    g.lambda_per_s, 0.05, 5.0);
  v({"feed_forward", "compensate the estimated motion of the balloon by the command"}, g.feed_forward);
  v({"velocity_response_s",
     "time in which the aircraft follows a velocity, by which the law looks ahead; 0: it does not"},
    g.velocity_response_s, 0.0, 3.0);
  v({"yaw_response_s",
     "time in which the aircraft follows a yaw rate, by which the law looks ahead; 0: it does not"},
    g.yaw_response_s, 0.0, 3.0);
  v({"speed_limit_m_s", "maximum speed forward or backward that is commanded"}, g.speed_limit_m_s, 0.1, 10.0);
  v({"climb_limit_m_s", "maximum vertical speed that is commanded, up or down"}, g.climb_limit_m_s, 0.1, 5.0);
  v({"yaw_rate_limit_deg_s", "maximum yaw rate that is commanded"}, g.yaw_rate_limit_deg_s, 5.0, 180.0);
  v(Renamed("min_height_m", "least_height_m",
            "height above the autopilot's local origin below which no descent is commanded"),
    g.min_height_m, 0.0, 100.0);
}

// What the law knows of the balloon. Without any of these it flies as the thesis does: by the last image as it
// is, which the tilt of the aircraft moves and latency makes late.
struct FollowFeatures {
  bool level = true;
  bool outline = true;
  bool filter = true;
};

inline void Fields(FieldVisitor& v, FollowFeatures& f) {
  v({"level", "image of a level camera, by the attitude at the exposure; false: the camera's own, tilted"},
    f.level);
  v({"outline", "measure the balloon by its outline; false: by CamShift's own centre and diameter"},
    f.outline);
  v({"filter",
     "filter the balloon's position and predict it to now; false: the last image, with the depth from the "
     "diameter"},
    f.filter);
}

struct LookAround {
  double stop_s = 1;
  double turn_deg_s = 30;
  double give_up_s = 60;
};

inline void Fields(FieldVisitor& v, LookAround& l) {
  v({"stop_s", "time without the balloon for which the aircraft stands still before it turns"}, l.stop_s, 0.0,
    30.0);
  v({"turn_deg_s", "yaw rate with which the aircraft looks around for the balloon"}, l.turn_deg_s, 1.0, 90.0);
  v({"give_up_s", "time without the balloon after which the mission gives up"}, l.give_up_s, 1.0, 3600.0);
}

// Thesis 5.4: the aircraft follows a balloon by the centre and the diameter of its image; downwards, ahead
// and by yaw alone. A balloon that is lost makes it stop and look around; it never flies after an old place.
struct FollowFlight {
  mission::BalloonObserverParameters balloon;
  std::string law = "coupled";  // eq. (5.20), or decoupled, eq. (5.25)
  std::vector<FollowReference> reference{FollowReference{}};
  FollowFeatures features;
  FollowGains gains;
  LookAround look_around;
};

inline void Fields(FieldVisitor& v, FollowFlight& p) {
  v({"balloon", "balloon that is followed, its tracking and estimation"}, p.balloon);
  v({"law", "control u, v and diameter together or each by its own input; whole: former name of coupled"},
    p.law, {"coupled", "decoupled", "whole"});
  v({"reference", "wanted image of the balloon, in the order of time"}, p.reference);
  v({"features", "what the law knows of the balloon's image"}, p.features);
  v({"gains", "gains and limits of the control law"}, p.gains);
  v({"look_around", "what to do without the balloon: stop, then turn on the spot to where it was last"},
    p.look_around);
}

mission::MissionType TypeOf(const FollowFlight& flight);
void CheckFlight(const FollowFlight& flight, const Place& where, Mistakes& mistakes);
void CheckFlightLimits(const FollowFlight& flight, const mission::AircraftLimits& limits, const Place& where,
                       Mistakes& mistakes);
void CheckFlightView(const FollowFlight& flight, const vision::CameraModel& camera,
                     const vision::CameraMount& mount, const Place& where, const Place& mount_where,
                     Mistakes& mistakes);
bool FlightCanHave(const FollowFlight& flight, const std::string& metric, const mission::Varies& varies);
std::unique_ptr<mission::Mission> MakeMission(const FollowFlight& flight, const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
