// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "control/estimate/velocity_lag.h"
#include "mission/caption/caption.h"
#include "mission/decision.h"
#include "vision/camera.h"

namespace kestrel::mission {

class Flight;
struct PilotParameters;

// Whether a flight needs to see its target to stay in the air: what the safety layer of a real aircraft is to
// hold it to (control/safety/safety.h).
enum class TargetNeed {
  kUndeclared,  // nobody has said: such a mission is not flown on a real aircraft
  kNone,        // what it commands is safe whatever the camera shows, or the mission itself stops when blind
  kInSight,     // it flies by what it sees; lost for too long, the safety layer holds, then sinks
};

// A flight's own code: vision pipeline and control law with their state. It sees frames and the autopilot's
// estimate, never the simulator, its truth or a clock. For a real aircraft it must declare Target(), and
// where that is kInSight tell the target's state with each decision.
class Mission {
 public:
  virtual ~Mission() = default;
  virtual Decision Step(const vision::Frame& frame, const control::VehicleState& state) = 0;
  // From the next frame on it flies by these parameters. They differ from those that it was made from, or that it
  // was given before, in no key but those that its type says may change in flight (MissionType::changeable).
  virtual void Change(const Flight& flight, const PilotParameters& pilot) { (void)flight, (void)pilot; }
  // Whether the flight, were it to end now, has done what it is for.
  virtual bool Accomplished() const { return true; }
  virtual TargetNeed Target() const { return TargetNeed::kUndeclared; }
  // How late an autopilot may follow the velocities that it is given; endless: they close no loop by sight,
  // or nothing is known of it.
  virtual control::VelocityLag MaxLag() const { return {}; }
  // Draws what the vision code saw in the last frame on a colour copy of it, without a word where a word would
  // cover it: what is to be said is Captions(), which a video has below the image.
  virtual void Draw(cv::Mat& bgr) const = 0;
  // The phase first. What fits into two rows below the image stays legible.
  virtual std::vector<Caption> Captions() const { return {}; }
  // The next image of the video that its type names (MissionType::product_video), CV_8UC3 of one size in all of
  // a flight; empty: it has none for this frame.
  virtual cv::Mat ProductImage() const { return {}; }
  // Once, after the flight: writes the files that its type names (MissionType::products), as far as there is
  // anything to write. Throws std::runtime_error with the file and the reason.
  virtual void WriteProducts(const std::filesystem::path& folder) const { (void)folder; }
};

}  // namespace kestrel::mission
