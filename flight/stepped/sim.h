// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "control/autopilot.h"
#include "flight/simulated/scenario.h"
#include "mission/mission.h"
#include "records/telemetry/flight_log.h"
#include "sim/camera/carried/carried_camera.h"
#include "sim/camera/event/event_camera.h"
#include "sim/instrument/readings.h"
#include "sim/simulator.h"
#include "vision/camera.h"

// A simulated flight step by step, for flight code of one's own, whoever's loop it is in.
namespace kestrel::flight {

struct SimOptions {
  std::optional<std::uint64_t> seed;   // in place of the scenario's
  std::vector<std::string> overrides;  // of the scenario, "key.path=value"
  bool images = true;                  // false: nothing is drawn, and frames have no image
  bool surfaces = false;               // with each frame its depth, what each pixel shows, and the flow
  bool imu = false;                    // where the scenario has none, one by the defaults of instruments.imu
  bool events = false;                 // of the scenario's event camera, behind the same lens
  bool draw_beside = true;  // images are drawn on a thread of their own; false: all is on the caller's
};

// A Sim was used in a way that it cannot be: a step after the end, a setpoint that is no number.
struct SimError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// What the flight code gets: the camera's next frame, and the autopilot's own estimate when it came.
struct Observation {
  std::optional<vision::Frame> frame;  // none: the flight is over, or none has come (Advance)
  control::VehicleState state;
  // With surfaces, of that frame:
  sim::Surfaces surfaces;  // depth in m along the ray, the geom of each pixel
  cv::Mat
      flow;  // CV_32FC2, px by which what is in the frame before has moved until this one; empty: the first
};

// A scenario's aircraft, world and camera, in lockstep: the world stands still but in Step() and Advance(). The same
// scenario, seed and setpoints give the same flight as `kestrel run`, bit for bit. Not for several threads at
// a time; several Sims may be used beside each other.
class Sim {
 public:
  // scenario: a name in scenarios/, or a YAML file. Throws InputError with every mistake that it holds, and
  // std::runtime_error where it cannot begin, without a renderer for one.
  explicit Sim(const std::string& scenario, const SimOptions& options = {});
  ~Sim();
  Sim(Sim&&) noexcept;
  Sim& operator=(Sim&&) noexcept;

  // Begins the flight, also one that is under way: to the first frame. seed: from now on, in place of the
  // one before.
  Observation Reset(std::optional<std::uint64_t> seed = std::nullopt);

  // Sends the setpoint, if any, and lets time go on until the next frame has come. Without one the last setpoint stands until it
  // is stale (control/autopilot.h). At the end of the flight there is no frame, and done() is true. Throws
  // SimError before Reset(), after the end, and of a setpoint that is not finite or a thrust beyond 0 to 1; sim::RunError where the
  // physics give up.
  Observation Step(const std::optional<control::Setpoint>& setpoint = std::nullopt,
                   const std::optional<control::AttitudeAid>& aid = std::nullopt);

  // The same, but time goes on by so much (s) whatever the camera gives, to the nearest step of the physics
  // (dt_s()); what is left over counts for the next Advance(). Beyond the flight's duration it goes to its end.
  // The frame is the last that has come meanwhile; earlier ones are passed over. go_on is asked now and then,
  // and time stops where it says false. After that Step() goes on as before.
  Observation Advance(double duration_s, const std::optional<control::Setpoint>& setpoint = std::nullopt,
                      const std::function<bool()>& go_on = nullptr);

  // What the scenario's own mission decides on the frame that Step() gave last: a pilot to compare with, to
  // learn from, or to hand over to. Step() takes its setpoint and its aid; where it has an outcome, the next Step()
  // is the flight's end. Throws SimError without a frame or
  // without an image.
  const mission::Decision& Decide();

  // Changes a key that the scenario lets change in flight (its `changeable`), from the next step of the physics on;
  // value: YAML. Throws SimError that says why it cannot be done. Keys of the mission can be changed
  // once Decide() was asked. A flight by flown() is the same, bit for bit, where changes come before a Step().
  void Change(const std::string& key, const std::string& value);
  const flight::Scenario& flown() const;  // the scenario with the changes that were made

  // Ends the flight: done() is true from now on. outcome: for the summary, such as "landed".
  void Finish(const std::string& outcome);

  // What has come since the last Reset(), Step() or Advance() began, in the order of time: of the instruments
  // (the scenario's `instruments`, with the truth at each instant of the IMU), and frames of the cameras
  // beside the one that paces the flight (the scenario's `cameras`), of each camera in the order of time.
  const sim::Readings& readings() const;
  const std::vector<sim::CameraFrame>& camera_frames() const;
  // The same of the event camera. It samples light as often as the world moves, and so its events come up to some
  // 10 ms later than they happen, the last of them when the flight ends. SimError: there is none.
  const std::vector<sim::Event>& events() const;

  bool done() const;                   // time is up, or Finish(), or the scenario's mission has ended it
  const std::string& outcome() const;  // empty until then
  double t_s() const;
  double dt_s() const;  // of the physics
  const Truth& truth() const;
  const Truth& exposure() const;  // the truth at the exposure of the frame given last
  const sim::Simulator& simulator() const;
  const flight::LoadedScenario& scenario() const;
  const std::vector<records::LogRow>& rows() const;  // one for each frame

  // Metrics, criteria and hashes as `kestrel run` has them, of the flight so far. Metrics of what the flight code's vision
  // says are there as far as Decide() gave it.
  records::Summary Summarise() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel::flight

namespace kestrel {

using flight::Observation;
using flight::Sim;
using flight::SimError;
using flight::SimOptions;

}  // namespace kestrel
