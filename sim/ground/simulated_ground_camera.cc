// SPDX-License-Identifier: Apache-2.0
#include "sim/ground/simulated_ground_camera.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "base/random.h"
#include "geometry/tait_bryan.h"
#include "sim/world/scene.h"

namespace kestrel::sim {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
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
      duration_s_(duration_s),
      X_NG_(DrawPlace(X_NT, parameters.view.place.value_or(parameters.place), parameters.view.error, seed)),
      faults_(view_.image.faults, OwnSeed(seed), duration_s),
      renderer_(model, parameters.camera, render, view_.image, Pose{}, Vibration{{}, seed}, OwnSeed(seed),
                false, draw_beside) {
  const double open_s =
      LongestExposure_s(view_.image) + LongestReadout_s(view_.image, vision::HeightPx(parameters.camera));
  half_exposure_ = static_cast<std::int64_t>(std::ceil(open_s / 2 / dt_s_ - 1e-6));
}

Pose SimulatedGroundCamera::X_NC() const {
  return {X_NG_.R * vision::HeadRotation({angles_.pan, angles_.tilt}), X_NG_.p};
}

std::int64_t SimulatedGroundCamera::StepOf(double t_s) const { return std::llround(t_s / dt_s_); }

std::int64_t SimulatedGroundCamera::TickStep() const {
  const double due_s = static_cast<double>(tick_) / view_.image.rate_hz;
  return due_s <= duration_s_ ? StepOf(due_s) : kNever;
}

bool SimulatedGroundCamera::Blocked(double t_s) const {
  return std::any_of(view_.blocked.begin(), view_.blocked.end(),
                     [&](const BlockedTime& b) { return t_s >= b.from_s && t_s < b.until_s; });
}

void SimulatedGroundCamera::Step(mjData* data, std::int64_t step) {
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
  if (!open_.empty() || TickStep() <= step_ + half_exposure_) {
    snapshots_.push_back(SnapshotOf(model_, data, t_s));
    snapshots_.back().X_NC = X_NC();
  }
  if (step_ == TickStep()) Tick();
  const double half_s = (static_cast<double>(half_exposure_) + 0.5) * dt_s_;
  while (!open_.empty() && StepOf(open_.front().t_s) + half_exposure_ <= step_) {
    FrameRequest request = std::move(open_.front());
    open_.pop_front();
    std::copy_if(snapshots_.begin(), snapshots_.end(), std::back_inserter(request.snapshots),
                 [&](const Snapshot& m) { return m.t_s > request.t_s - half_s; });
    renderer_.Submit(std::move(request));
  }
  const double next_s = open_.empty() ? static_cast<double>(TickStep()) * dt_s_ : open_.front().t_s;
  while (!snapshots_.empty() && snapshots_.front().t_s < next_s - half_s) snapshots_.pop_front();
}

void SimulatedGroundCamera::Tick() {
  const double t_s = static_cast<double>(step_) * dt_s_;
  const CameraCondition& condition = faults_.At(t_s);
  const std::int64_t tick = tick_++;
  const double due_s = static_cast<double>(tick) / view_.image.rate_hz;
  if (condition.off) {
    ++sequence_;
    return;
  }
  if (due_s < last_frame_s_ + condition.period_s - 1e-9) return;
  last_frame_s_ = due_s;
  const std::int64_t sequence = sequence_++;
  if (faults_.Loses(condition, tick)) return;
  Coming coming{t_s,
                sequence,
                StepOf(due_s + view_.image.latency_s + condition.delay_s),
                {Rounded(angles_.pan, view_.encoder_deg), Rounded(angles_.tilt, view_.encoder_deg)},
                X_NC()};
  coming.due_step = std::max(coming.due_step, step_ + half_exposure_);
  if (!coming_.empty()) coming.due_step = std::max(coming.due_step, coming_.back().due_step);
  coming_.push_back(coming);
  const auto content = condition.stuck     ? FrameRequest::Content::kRepeat
                       : condition.garbage ? FrameRequest::Content::kGarbage
                                           : FrameRequest::Content::kScene;
  open_.push_back({t_s, sequence, content, {}});
}

std::optional<vision::GroundFrame> SimulatedGroundCamera::Take() {
  if (coming_.empty() || coming_.front().due_step > step_) return std::nullopt;
  const Coming coming = coming_.front();
  coming_.pop_front();
  taken_X_NC_ = coming.X_NC;
  return vision::GroundFrame{{renderer_.Next().image, coming.t_s + view_.clock_offset_s, coming.sequence},
                             {coming.at.pan, coming.at.tilt}};
}

}  // namespace kestrel::sim
