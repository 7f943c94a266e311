// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/yaml/fields.h"
#include "control/autopilot.h"
#include "geometry/truth.h"
#include "sim/aircraft/airframe.h"
#include "sim/autopilot/emulated_autopilot.h"
#include "sim/autopilot/external_autopilot.h"
#include "sim/camera/camera_clock.h"
#include "sim/camera/camera_error.h"
#include "sim/camera/carried/carried_camera.h"
#include "sim/camera/event/event_renderer.h"
#include "sim/camera/frame_renderer.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/pan_tilt.h"
#include "sim/camera/renderer.h"
#include "sim/camera/snapshots.h"
#include "sim/camera/vibration.h"
#include "sim/carried_path.h"
#include "sim/contact_search.h"
#include "sim/deck/deck.h"
#include "sim/fault_schedule.h"
#include "sim/ground/simulated_ground_camera.h"
#include "sim/instrument/instruments.h"
#include "sim/sensor/sensor_faults.h"
#include "sim/sensor/sensors.h"
#include "sim/world/scene.h"
#include "sim/world/target.h"
#include "sim/world/wind.h"
#include "vision/camera.h"
#include "vision/camera/camera_model.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::sim {

// Where a flight begins: over the pad, in the air unless on_ground. scatter: uniform, by the seed.
struct StartParameters {
  Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();  // north and east of the pad
  double scatter_m = 0;                                // radius of the disc around that
  double height_m = 5;                                 // of the aircraft above the pad
  bool on_ground = false;
  double yaw_deg = 0;
  double yaw_scatter_deg = 0;
  double settle_s = 20;  // held there by the autopilot before the first frame
};

// A dark sheet over part of the pad for some time.
struct OcclusionParameters {
  double share = 0;
  double from_s = 0, until_s = 1e9;
};

inline void Fields(FieldVisitor& v, StartParameters& p) {
  v({"offset_m", "north and east of the pad"}, p.offset_m, -300.0, 300.0);
  v({"scatter_m", "radius of the disc around the offset in which the start is drawn uniformly, by the seed"},
    p.scatter_m, 0.0, 20.0);
  v({"height_m", "height of the aircraft above the pad"}, p.height_m, 0.3, 600.0);
  v({"on_ground", "whether the flight begins on the ground, with motors off"}, p.on_ground);
  v({"yaw_deg", "heading, clockwise from north"}, p.yaw_deg, -360.0, 360.0);
  v({"yaw_scatter_deg",
     "half width of the interval around yaw_deg in which the heading is drawn, by the seed"},
    p.yaw_scatter_deg, 0.0, 180.0);
  v({"settle_s", "time for which the autopilot holds the start before the first frame"}, p.settle_s, 0.0,
    60.0);
}

inline void Fields(FieldVisitor& v, OcclusionParameters& p) {
  v({"share", "share of the pad that a dark sheet covers"}, p.share, 0.0, 1.0);
  v({"from_s", "when the sheet comes, in the time of the flight"}, p.from_s, 0.0, 1e9);
  v({"until_s", "when the sheet goes"}, p.until_s, 0.0, 1e9);
}

struct SimulatorParameters {
  SceneParameters scene;
  AirframeParameters vehicle;
  AutopilotParameters autopilot;
  SensorParameters sensors;
  ActuatorParameters actuators = {};
  vision::CameraModel camera;
  vision::CameraMount mount;
  CameraErrorParameters camera_error =
      {};  // of the camera that it flies by; camera and mount are as believed
  ImageParameters image;
  RenderOptions render;
  WindParameters wind;
  StartParameters start;
  OcclusionParameters occlusion;
  std::uint64_t seed = 1;
  double duration_s = 60;
  std::optional<double> step_s =
      {};  // of the physics and the inertial sensors; none: 2 ms, as all flights have it
  std::vector<TargetParameters> targets = {};
  std::optional<CarryParameters> carry = {};          // in place of flight and of start
  std::optional<GroundCameraParameters> ground = {};  // a second camera, on the ground; none: there is none
  std::optional<EventCameraParameters> events = {};   // a camera behind the same lens; none: there is none
  InstrumentParameters instruments = {};
  std::vector<CarriedCameraParameters> cameras = {};  // beside the one above
  bool images = true;     // false: frames come when they would, and show nothing; none is drawn
  bool surfaces = false;  // of each frame, and the flow between them, for records: see picture()
  // An image is drawn on a thread of its own, beside the flight code that works on the one before; if not,
  // a flight is one thread, for who flies as many at once as there are cores. The flight is the same.
  bool draw_beside = true;
};

// Something in a run is not a number, or the physics gave up: names what and when.
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The far end of both wires: the camera and the autopilot of an aircraft in a simulated world. Lockstep: time
// passes only in Next(), which advances the world until the next frame has come through its latency, or to
// the end if none comes any more, and in NextUntil(), for who keeps time himself. What
// an image shows depends on the snapshots around its exposure, and on the frames before it, alone.
//
// When it exposes, and when its frames come, is CameraClock's.
class Simulator final : public vision::Camera, public control::Autopilot {
 public:
  explicit Simulator(const SimulatorParameters& parameters);
  ~Simulator() override;

  std::optional<vision::Frame> Next()
      override;  // none: no exposure is left within the duration; or see FlyBy
  // The same, but the world goes no further than to this time, and without a frame always there, also when
  // no exposure is left. The flight is the same, bit for bit, in whatever slices.
  std::optional<vision::Frame> NextUntil(double t_s);
  control::VehicleState State() const override;
  void Send(const control::Setpoint& setpoint) override;
  void Aid(const control::AttitudeAid& aid) override;

  // From the next step on, this moves the rotors, for as long as the simulator lives; until its first word
  // they do what they were told last. When it ends the flight, Next() gives none from then on. The emulated
  // autopilot goes on estimating: State() is its own, on the ground or holding, and what it is sent moves
  // nothing.
  void FlyBy(ExternalAutopilot* external) { external_ = external; }

  // From now on the camera is on this platform, for as long as the simulator lives: each step turns it, by
  // where the autopilot believes the aircraft to be.
  void CarryCamera(PanTilt* platform) { platform_ = platform; }

  // From the next step on. Of targets: how they move, from where they are; there are as many as before.
  void ChangeDaylight(double daylight);
  void Change(const WindParameters& wind);
  void Change(const std::vector<TargetParameters>& targets);
  // Faults of the camera, of the aircraft's sensors and of its actuators. One that is to begin in the past begins now.
  void Change(const std::vector<CameraFault>& faults);
  void Change(const std::vector<SensorFault>& faults, const std::vector<AttitudeFault>& attitude);
  void Change(const ActuatorParameters& actuators);

  // The camera on the ground; null: there is none. Its frames have come when those of Next() do, or earlier.
  SimulatedGroundCamera* ground_camera() { return ground_.get(); }

  // The event camera, from time 0 on; null: there is none.
  EventRenderer* event_camera() { return events_.get(); }

  // What has come during the last Next() or NextUntil(), the next one's taking its place: of the instruments, and of
  // the cameras beside this one, in the order of the parameters and each in the order of time.
  const Readings& readings() const { return readings_; }
  const std::vector<CameraFrame>& camera_frames() const { return camera_frames_; }

  const Truth& truth() const { return truth_; }
  const Truth& exposure() const { return exposure_; }           // of the frame that Next() gave last
  const RenderedFrame& picture() const { return picture_; }     // of the same
  const std::optional<Truth>& touch() const { return touch_; }  // the instant before the first touch-down
  const Pose& X_BC() const { return X_BC_; }                    // now
  const mjModel* model() const { return model_.get(); }
  Snapshot snapshot() const;  // of the world now, for pictures of it: sim/view
  // The changes of the camera's condition until now.
  std::span<const CameraCondition> camera_changes() const { return clock_.ChangesUntil(truth_.t_s); }
  // The faults of sensors and actuators, and what the autopilot makes of its sensors, until now.
  std::span<const StateChange> state_changes() const { return state_changes_; }
  std::string renderer_name() const;

  std::uint64_t state_hash() const;  // of the physical state at every exposure
  std::uint64_t image_hash() const;  // of every frame given out
  struct Timing {
    std::vector<double> physics_s, render_s, sensor_s;  // one for each frame
  };
  const Timing& timing() const { return timing_; }

 private:
  struct Hashes;
  void Step();
  void AdvanceTo(std::int64_t step);
  std::optional<vision::Frame> NextUntilStep(std::int64_t last);
  void Gather();
  void NoteChanges();
  void ScheduleFaults();
  void CoverPad();
  void MoveTargets();
  void Carry();
  void MoveDeck();
  double SurfaceBelow_m() const;
  void RunCamera();
  Truth Look() const;

  CameraError camera_error_;
  SimulatorParameters parameters_;  // with the camera's scatter drawn, and the camera as it truly is
  ModelPtr model_;
  DataPtr data_;
  Airframe vehicle_;
  std::optional<ContactSearch> contact_search_;
  Wind wind_;
  Sensors sensors_;
  SensorFaults sensor_faults_;
  std::unique_ptr<EmulatedAutopilot> autopilot_;
  ExternalAutopilot* external_ = nullptr;
  bool ended_ = false;  // by it
  PanTilt* platform_ = nullptr;
  Pose X_BC_;
  Vibration vibration_;
  std::unique_ptr<FrameRenderer> renderer_;  // null: without images
  std::unique_ptr<SimulatedGroundCamera> ground_;
  std::unique_ptr<EventRenderer> events_;
  std::unique_ptr<Instruments> instruments_;  // null: none
  Beam beam_;
  Readings readings_;
  std::vector<std::unique_ptr<CarriedCamera>> cameras_;
  std::vector<CameraFrame> camera_frames_;
  std::unique_ptr<Hashes> hashes_;

  std::int64_t steps_ = 0;  // since time 0, negative while settling
  Truth truth_, exposure_;
  RenderedFrame picture_;
  std::optional<Truth> touch_;
  bool airborne_ = false;
  std::optional<double> occluded_;
  std::vector<TargetPath> targets_;
  std::optional<CarriedPath> carried_;
  std::optional<Deck> deck_;
  double stands_since_s_ = 0;       // on the deck, while it touches
  std::optional<Pose> X_TB_fixed_;  // where a deck that holds it fast has it

  std::vector<StateChange> scheduled_;  // the faults that are still to come, the last first
  std::vector<StateChange> state_changes_;
  NavigationHealth health_;

  CameraClock clock_;
  std::deque<Truth> exposures_;  // of the frames under way
  double physics_s_ = 0;         // spent since the last frame
  Timing timing_;
};

}  // namespace kestrel::sim
