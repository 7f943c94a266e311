// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/autopilot.h"
#include "sim/emulated_autopilot.h"
#include "sim/image_sensor.h"
#include "sim/multirotor.h"
#include "sim/renderer.h"
#include "sim/scene.h"
#include "sim/sensors.h"
#include "sim/truth.h"
#include "sim/wind.h"
#include "vision/camera.h"
#include "vision/camera_model.h"

namespace kestrel {

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

// The camera's place on the aircraft: looking down with the top of the image forward, then turned by the
// angles.
struct CameraMount {
  Eigen::Vector3d position_m{0, 0, 0.05};  // in B
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
};
Pose MountPose(const CameraMount& mount);  // X_BC

// A dark sheet over part of the pad for some time.
struct OcclusionParameters {
  double share = 0;
  double from_s = 0, until_s = 1e9;
};

template <class Visitor>
void Fields(Visitor& v, StartParameters& p) {
  v("offset_m", p.offset_m, -100.0, 100.0);
  v("scatter_m", p.scatter_m, 0.0, 20.0);
  v("height_m", p.height_m, 0.3, 120.0);
  v("on_ground", p.on_ground);
  v("yaw_deg", p.yaw_deg, -360.0, 360.0);
  v("yaw_scatter_deg", p.yaw_scatter_deg, 0.0, 180.0);
  v("settle_s", p.settle_s, 0.0, 60.0);
}

template <class Visitor>
void Fields(Visitor& v, CameraMount& m) {
  v("position_m", m.position_m, -1.0, 1.0);
  v("yaw_deg", m.yaw_deg, -180.0, 180.0);
  v("pitch_deg", m.pitch_deg, -90.0, 90.0);
  v("roll_deg", m.roll_deg, -90.0, 90.0);
}

template <class Visitor>
void Fields(Visitor& v, OcclusionParameters& p) {
  v("share", p.share, 0.0, 1.0);
  v("from_s", p.from_s, 0.0, 1e9);
  v("until_s", p.until_s, 0.0, 1e9);
}

struct SimulatorParameters {
  SceneParameters scene;
  MultirotorParameters vehicle;
  AutopilotParameters autopilot;
  SensorParameters sensors;
  CameraModel camera;
  CameraMount mount;
  ImageParameters image;
  RenderOptions render;
  WindParameters wind;
  StartParameters start;
  OcclusionParameters occlusion;
  std::uint64_t seed = 1;
  double duration_s = 60;
};

// Something in a run is not a number, or the physics gave up: names what and when.
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The far end of both wires: the camera and the autopilot of an aircraft in a simulated world. Lockstep: time
// passes only in Next(), which advances the world until the next frame has come through its latency. An image
// is drawn on a second thread while the flight code works on the one before; what is drawn depends on the
// snapshot alone.
class Simulator final : public Camera, public Autopilot {
 public:
  explicit Simulator(const SimulatorParameters& parameters);
  ~Simulator() override;

  std::optional<Frame> Next() override;  // none: the next exposure would be after the duration
  VehicleState State() const override;
  void Send(const Setpoint& setpoint) override;

  const Truth& truth() const { return truth_; }
  const Truth& exposure() const { return exposure_; }           // of the frame that Next() gave last
  const std::optional<Truth>& touch() const { return touch_; }  // the instant before the first touch-down
  const Pose& X_BC() const { return X_BC_; }
  std::string renderer_name() const;

  std::uint64_t state_hash() const;  // of the physical state at every exposure
  std::uint64_t image_hash() const;  // of every frame given out
  struct Timing {
    std::vector<double> physics_s, render_s, sensor_s;  // one for each frame
  };
  const Timing& timing() const { return timing_; }

 private:
  class Studio;  // the drawing thread
  struct Hashes;

  void Step();
  void Expose();
  void AdvanceTo(double t_s);
  Truth Look() const;

  SimulatorParameters parameters_;
  ModelPtr model_;
  DataPtr data_;
  Multirotor vehicle_;
  Wind wind_;
  Sensors sensors_;
  std::unique_ptr<EmulatedAutopilot> autopilot_;
  Pose X_BC_;
  std::unique_ptr<Studio> studio_;
  std::unique_ptr<Hashes> hashes_;

  std::int64_t steps_ = 0;  // since time 0, negative while settling
  std::int64_t exposures_ = 0, delivered_ = 0;
  std::deque<Truth> exposed_;  // of the frames under way
  Truth truth_, exposure_;
  std::optional<Truth> touch_;
  bool airborne_ = false;
  double occluded_ = 0;
  Timing timing_;
};

}  // namespace kestrel
