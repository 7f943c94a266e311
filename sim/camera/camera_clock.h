// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <span>

#include "sim/camera/camera_faults.h"
#include "sim/camera/frame_renderer.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/snapshots.h"

namespace kestrel::sim {

// How a camera's clock stands to the flight's.
struct CameraTiming {
  double phase_s = 0;    // its first tick
  double drift_ppm = 0;  // how much faster it goes
};

// When a camera exposes and when its frames come, in steps of the world. Its clock ticks at its rate, and each
// tick is a frame unless a fault takes it. A frame's time, from which its latency counts, is the middle of the
// exposure of the middle row; exposure and readout reach to both sides of it, and the latency and the period must
// leave room for them (a frame whose latency does not comes as soon as it is read out). Both the time and the
// latency are kept to the nearest step.
class CameraClock {
 public:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  struct Frame {
    double t_s = 0;
    std::int64_t sequence = 0, due_step = 0;
  };

  // image: without scatter. seed: of its faults.
  CameraClock(const ImageParameters& image, int rows, std::uint64_t seed, double duration_s, double dt_s,
              const CameraTiming& timing = {});

  // From t_s on the camera has these faults.
  void ChangeFaults(const CameraFaults& faults, double t_s) { faults_.Change(faults, t_s); }

  std::int64_t TickStep() const;  // of the next tick; kNever when there is none

  // After each step of the world, and at its beginning: keeps a snapshot of it while one is needed, begins an
  // exposure, and submits those that have ended. renderer: null: nothing is drawn. Whether this step is the middle of a frame's exposure.
  bool Step(std::int64_t step, const std::function<Snapshot()>& snapshot, FrameRenderer* renderer);

  // Of the next frame under way; none: no exposure has begun since the last.
  std::optional<std::int64_t> DueStep() const;
  Frame Take();  // that frame, whose image the renderer gives next

  std::span<const CameraCondition> ChangesUntil(double t_s) const { return faults_.ChangesUntil(t_s); }

 private:
  std::int64_t StepOf(double t_s) const;
  double TickTime_s() const;  // as it should be, not yet brought to a step
  bool Tick(std::int64_t step);

  double dt_s_, duration_s_, phase_s_, rate_hz_, latency_s_;
  CameraFaults faults_;
  std::int64_t half_exposure_;      // steps on either side of a tick in which pixels may be open
  std::int64_t tick_ = 0;           // the next one
  std::int64_t earliest_ = 0;       // step that it may have: one has one tick at most
  std::int64_t sequence_ = 0;       // of the next frame
  double last_frame_s_ = -1e9;      // when the last one that was not lost was due
  std::deque<FrameRequest> open_;   // their exposures have not ended
  std::deque<Snapshot> snapshots_;  // that open exposures need, or the next one
  std::deque<Frame> coming_;
};

}  // namespace kestrel::sim
