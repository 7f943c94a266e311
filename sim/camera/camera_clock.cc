// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/camera_clock.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace kestrel::sim {

CameraClock::CameraClock(const ImageParameters& image, int rows, std::uint64_t seed, double duration_s,
                         double dt_s, const CameraTiming& timing)
    : dt_s_(dt_s),
      duration_s_(duration_s),
      phase_s_(timing.phase_s),
      rate_hz_(image.rate_hz * (1 + 1e-6 * timing.drift_ppm)),
      latency_s_(image.latency_s),
      faults_(image.faults, seed, duration_s) {
  const double open_s = LongestExposure_s(image) + LongestReadout_s(image, rows);
  half_exposure_ = static_cast<std::int64_t>(std::ceil(open_s / 2 / dt_s_ - 1e-6));
}

std::int64_t CameraClock::StepOf(double t_s) const { return std::llround(t_s / dt_s_); }

double CameraClock::TickTime_s() const { return phase_s_ + static_cast<double>(tick_) / rate_hz_; }

std::int64_t CameraClock::TickStep() const {
  const double due_s = TickTime_s();
  return due_s <= duration_s_ ? std::max(StepOf(due_s), earliest_) : kNever;
}

bool CameraClock::Step(std::int64_t step, const std::function<Snapshot()>& snapshot,
                       FrameRenderer* renderer) {
  if (renderer != nullptr && (!open_.empty() || TickStep() <= step + half_exposure_))
    snapshots_.push_back(snapshot());
  const bool exposes = step == TickStep() && Tick(step);
  const double half_s =
      (static_cast<double>(half_exposure_) + 0.5) * dt_s_;  // half a step more, for rounding
  while (!open_.empty() && StepOf(open_.front().t_s) + half_exposure_ <= step) {
    FrameRequest request = std::move(open_.front());
    open_.pop_front();
    if (renderer == nullptr) continue;
    std::copy_if(snapshots_.begin(), snapshots_.end(), std::back_inserter(request.snapshots),
                 [&](const Snapshot& m) { return m.t_s > request.t_s - half_s; });
    renderer->Submit(std::move(request));
  }
  const double next_s = open_.empty() ? static_cast<double>(TickStep()) * dt_s_ : open_.front().t_s;
  while (!snapshots_.empty() && snapshots_.front().t_s < next_s - half_s) snapshots_.pop_front();
  return exposes;
}

// The middle of an exposure, unless a fault takes it.
bool CameraClock::Tick(std::int64_t step) {
  const double t_s = static_cast<double>(step) * dt_s_;
  const CameraCondition& condition = faults_.At(t_s);
  const double due_s = TickTime_s();
  const std::int64_t tick = tick_++;
  earliest_ = step + 1;
  if (condition.off) {
    ++sequence_;
    return false;
  }
  if (due_s < last_frame_s_ + condition.period_s - 1e-9) return false;
  last_frame_s_ = due_s;
  const std::int64_t sequence = sequence_++;
  if (faults_.Loses(condition, tick)) return false;

  Frame frame{t_s, sequence, StepOf(due_s + latency_s_ + condition.delay_s)};
  frame.due_step = std::max(frame.due_step, step + half_exposure_);
  if (!coming_.empty()) frame.due_step = std::max(frame.due_step, coming_.back().due_step);
  coming_.push_back(frame);
  const auto content = condition.stuck     ? FrameRequest::Content::kRepeat
                       : condition.garbage ? FrameRequest::Content::kGarbage
                                           : FrameRequest::Content::kScene;
  open_.push_back({t_s, sequence, content, {}});
  return true;
}

std::optional<std::int64_t> CameraClock::DueStep() const {
  if (coming_.empty()) return std::nullopt;
  return coming_.front().due_step;
}

CameraClock::Frame CameraClock::Take() {
  const Frame frame = coming_.front();
  coming_.pop_front();
  return frame;
}

}  // namespace kestrel::sim
