// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/carried/carried_camera.h"

#include <utility>

#include "base/random.h"

namespace kestrel::sim {
namespace {

// So that its noise, its faults and its shaking are its own.
std::uint64_t OwnSeed(std::uint64_t seed, const std::string& name) {
  return RandomStream(seed, "camera " + name).Bits();
}

}  // namespace

CarriedCamera::CarriedCamera(const mjModel* model, const CarriedCameraParameters& p,
                             const RenderOptions& render, std::uint64_t seed, double duration_s,
                             const CarriedCameraOptions& options)
    : model_(model),
      name_(p.name),
      dt_s_(model->opt.timestep),
      X_BC_(vision::MountPose(p.mount)),
      image_(DrawScatter(p.image, OwnSeed(seed, p.name))),
      vibration_(p.mount.vibration, OwnSeed(seed, p.name)),
      clock_(image_, vision::HeightPx(p.camera), OwnSeed(seed, p.name), duration_s, dt_s_, p.timing),
      renderer_(options.images ? std::make_unique<FrameRenderer>(model, p.camera, render, image_, X_BC_,
                                                                 vibration_, OwnSeed(seed, p.name),
                                                                 options.surfaces, options.draw_beside)
                               : nullptr) {}

void CarriedCamera::Step(const mjData* data, std::int64_t step, const Pose& X_NB, double daylight) {
  step_ = step;
  const double t_s = static_cast<double>(step) * dt_s_;
  const auto snapshot = [&] {
    Snapshot now = SnapshotOf(model_, data, t_s);
    now.daylight = daylight;
    return now;
  };
  if (!clock_.Step(step, snapshot, renderer_.get())) return;
  const Pose X_NC = X_NB * X_BC_;
  exposures_.push_back(vibration_.still() ? X_NC : X_NC * vibration_.At(t_s));
}

std::optional<CameraFrame> CarriedCamera::Take() {
  const auto due_step = clock_.DueStep();
  if (!due_step || *due_step > step_) return std::nullopt;
  const CameraClock::Frame frame = clock_.Take();
  const Pose X_NC = exposures_.front();
  exposures_.pop_front();
  RenderedFrame picture = renderer_ ? renderer_->Next() : RenderedFrame{};
  return CameraFrame{name_, vision::Frame{picture.image, frame.t_s, frame.sequence}, X_NC,
                     std::move(picture.surfaces), std::move(picture.flow_here)};
}

}  // namespace kestrel::sim
