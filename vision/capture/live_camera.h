// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/camera.h"
#include "vision/capture/image_source.h"

namespace kestrel::vision {

struct LiveCameraOptions {
  double stalled_s = 1;
  double reopen_first_s = 0.1, reopen_max_s = 5;
  double exposure_before_stamp_s = 0;  // calibrated
};

inline void Fields(FieldVisitor& v, LiveCameraOptions& o) {
  v({"stalled_s", "time without an image after which the camera is opened anew"}, o.stalled_s, 0.05, 60.0);
  v({"reopen_first_s", "first pause before the camera is opened again; doubles with each failure"},
    o.reopen_first_s, 0.01, 60.0);
  v(Renamed("reopen_max_s", "reopen_most_s", "longest pause before the camera is opened again"),
    o.reopen_max_s, 0.01, 600.0);
  v({"exposure_before_stamp_s",
     "time from the middle of the exposure to the image's time stamp, or its arrival if it has none"},
    o.exposure_before_stamp_s, -1.0, 1.0);
}

enum class LiveCameraState { kOpening, kStreaming, kStalled, kEnded };
const char* NameOf(LiveCameraState state);

struct LiveCameraHealth {
  LiveCameraState state = LiveCameraState::kOpening;
  std::int64_t images = 0;       // grabbed
  std::int64_t overwritten = 0;  // of them, newer ones came before anybody took them
  std::int64_t missed = 0;       // by the driver's own count
  std::int64_t disordered = 0;   // came again, or after newer ones, by the driver's count or stamp: not given
  std::int64_t openings = 0;     // that succeeded
  std::optional<double> age_s;   // of the newest image, by its exposure; none: no image yet
  std::string error;             // why the source failed last; empty: it has not, or it does not say
};

// A real camera. A thread grabs, and the newest image wins: whoever is slow gets fresh images and the rest
// are counted, never queued. A source that fails is opened again, after pauses that grow; one that hangs
// within its library is left behind and another is made in its place. An image that comes twice, or later
// than a newer one, is not given, and does not count as a sign of life: a driver that repeats itself has
// stalled.
//
// The driver's stamps are taken for the monotonic clock's if the first after opening is of the last
// kMonotonic_s; otherwise for those of a clock of its own, which is mapped (base/clock_sync.h). A stamp in
// the future is not believed; a frame's time never is later than its image's arrival.
class LiveCamera final : public Camera {
 public:
  static constexpr double kMonotonic_s = 5;

  LiveCamera(ImageSourceMaker source, const LiveCameraOptions& options);
  // Waits until the thread has left the source, which it does with the image that it waits for; but not for
  // longer than stalled_s: one that hangs is left behind.
  ~LiveCamera() override;
  // Threads of this program's cameras that hung within their library to the end. Exit handlers would take
  // that library down beneath them: see app/option/exit_status.h.
  static int LeftBehind();

  // The next image that nobody has taken yet, waiting for it however long the source takes to come back; its
  // time is that of the monotonic clock. None: the source has ended, or Stop() was called.
  std::optional<Frame> Next() override;
  // The same, but waits no longer than this. None: also that nothing came.
  std::optional<Frame> Next(double max_s);
  void Stop();  // from any thread

  LiveCameraHealth Health() const;  // from any thread

 private:
  struct Mailbox;
  void Watch();

  ImageSourceMaker source_;
  LiveCameraOptions options_;
  std::shared_ptr<Mailbox> mailbox_;  // outlives the camera where a thread hangs
  std::vector<std::thread> threads_;  // of worker 1, 2, ...
};

}  // namespace kestrel::vision
