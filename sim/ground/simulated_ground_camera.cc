// SPDX-License-Identifier: Apache-2.0
#include "sim/ground/simulated_ground_camera.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "geometry/tait_bryan.h"
#include "sim/world/scene.h"

namespace kestrel::sim {
namespace {

constexpr double kBlindBefore_m = 0.6;  // the lens
constexpr double kBlindAway_m = 100;    // below the ground

// So that its noise and its faults are not those of the camera on board.
std::uint64_t OwnSeed(std::uint64_t seed) { return RandomStream(seed, "ground camera").Bits(); }

// The mast as it truly stands.
Pose DrawPlace(const Pose& X_NT, const vision::GroundPlace& place, const GroundPlaceError& error,
               std::uint64_t seed) {
  RandomStream random(seed, "ground camera's place");
  Pose X_TG = vision::MastPose(place);
  for (int i = 0; i < 3; ++i) X_TG.p[i] += error.position_m * random.Normal();
  Eigen::Vector3d turn;
  for (int i = 0; i < 3; ++i) turn[i] = Radians(error.angle_deg) * random.Normal();
  X_TG.R = X_TG.R * ExpRotation(turn);
  return X_NT * X_TG;
}

GroundViewParameters WithScatterDrawn(GroundViewParameters view, std::uint64_t seed) {
  view.image = DrawScatter(view.image, seed);
  return view;
}

double Rounded(double angle, double resolution_deg) {
  if (resolution_deg <= 0) return angle;
  const double unit = Radians(resolution_deg);
  return unit * std::round(angle / unit);
}

}  // namespace

SimulatedGroundCamera::SimulatedGroundCamera(const mjModel* model, const Pose& X_NT,
                                             const GroundCameraParameters& parameters,
                                             const RenderOptions& render, std::uint64_t seed,
                                             double duration_s, bool draw_beside)
    : model_(model),
      view_(WithScatterDrawn(parameters.view, OwnSeed(seed))),
      dt_s_(model->opt.timestep),
      X_NG_(DrawPlace(X_NT, parameters.view.place.value_or(parameters.place), parameters.view.error, seed)),
      clock_(view_.image, vision::HeightPx(parameters.camera), OwnSeed(seed), duration_s, dt_s_),
      renderer_(model, parameters.camera, render, view_.image, Pose{}, Vibration{{}, seed}, OwnSeed(seed),
                false, draw_beside) {}

Pose SimulatedGroundCamera::X_NC() const {
  return {X_NG_.R * vision::HeadRotation({angles_.pan, angles_.tilt}), X_NG_.p};
}

bool SimulatedGroundCamera::Blocked(double t_s) const {
  return std::any_of(view_.blocked.begin(), view_.blocked.end(),
                     [&](const BlockedTime& b) { return t_s >= b.from_s && t_s < b.until_s; });
}

void SimulatedGroundCamera::Step(mjData* data, std::int64_t step, double daylight) {
  step_ = step;
  const double t_s = static_cast<double>(step) * dt_s_;
  if (view_.head) {
    const Gaze gaze = LookFromAircraft{wanted_.pan, wanted_.tilt};  // here from the mast
    const Eigen::Vector3d at = Eigen::Vector3d::Zero();
    angles_ = Turned(angles_, AnglesFor(gaze, Pose{}, at, angles_, *view_.head), dt_s_, *view_.head);
  }
  if (!view_.blocked.empty()) {
    const Pose X_NC = this->X_NC();
    Pose X_NQ{X_NC.R, X_NC * Eigen::Vector3d(0, 0, kBlindBefore_m)};
    if (!Blocked(t_s)) X_NQ.p.z() = kBlindAway_m;
    PlaceBlind(model_, data, X_NQ);
  }
  const auto snapshot = [&] {
    Snapshot now = SnapshotOf(model_, data, t_s);
    now.X_NC = X_NC();
    now.daylight = daylight;
    return now;
  };
  if (clock_.Step(step, snapshot, &renderer_))
    gazed_.push_back(
        {{Rounded(angles_.pan, view_.encoder_deg), Rounded(angles_.tilt, view_.encoder_deg)}, X_NC()});
}

std::optional<vision::GroundFrame> SimulatedGroundCamera::Take() {
  const auto due_step = clock_.DueStep();
  if (!due_step || *due_step > step_) return std::nullopt;
  const CameraClock::Frame frame = clock_.Take();
  const Gazed gazed = gazed_.front();
  gazed_.pop_front();
  taken_X_NC_ = gazed.X_NC;
  return vision::GroundFrame{{renderer_.Next().image, frame.t_s + view_.clock_offset_s, frame.sequence},
                             {gazed.at.pan, gazed.at.tilt}};
}

}  // namespace kestrel::sim
