// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "control/link/autopilot_link.h"
#include "flight/flight_plan.h"
#include "vision/capture/live_camera.h"

namespace kestrel::flight {

struct CheckItem {
  std::string name;   // "camera rate"
  std::string found;  // "19.8 images/s of 20"
  bool ok = false;
};

// An autopilot's estimator takes some 40 s from its start until it tells a position.
inline constexpr double kWait_s = 60;

struct PreFlightOptions {
  double watch_s = 2;  // for how long a camera is watched once it is there
  double wait_s =
      kWait_s;  // for how long, at most, each is waited for: a camera's first image, and then the state
  double min_rate = 0.8;      // share of the images that the plan asks for
  double max_rate = 1.6;      // the same: a camera of 30 images/s flies a plan of 20
  double sane_tilt_deg = 40;  // beyond it an attitude is not believed
  double sane_speed_m_s = 10;
  bool pilot_untold = false;  // that the autopilot does not tell of a pilot's switch is no reason not to fly
  const std::atomic<bool>* interrupted = nullptr;  // ends the watching
  vision::LiveCamera* ground = nullptr;            // a second camera, on the ground; null: there is none
  // While one of them is waited for, often: which, with what keeps it away, and for how long until now.
  std::function<void(const std::string& what, double waited_s)> waits = {};
};

// The check list before a flight, each item with what was found: camera rate, image against calibration,
// link, state, pilot's switch. Where there is no image the state is not waited for: the link has had as long by then.
// Nothing is sent as a setpoint. Of a check that was interrupted no item is of worth.
std::vector<CheckItem> PreFlight(const LoadedPlan& plan, vision::LiveCamera& camera,
                                 const control::AutopilotLink& link, const PreFlightOptions& options);

bool AllOk(const std::vector<CheckItem>& items);

}  // namespace kestrel::flight
