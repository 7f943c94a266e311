// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/live_camera.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <set>
#include <utility>

#include "base/clock_sync.h"
#include "base/stopwatch.h"

namespace kestrel::vision {
namespace {

constexpr double kOpening_s = 10;  // what some cameras take to be opened
constexpr int kMaxLeftBehind = 8;  // sources that hang; then it is waited for the last one

std::atomic<int> left_behind = 0;

std::chrono::duration<double> Seconds(double s) { return std::chrono::duration<double>(s); }

}  // namespace

struct LiveCamera::Mailbox {
  std::mutex mutex;
  std::condition_variable changed;
  bool stop = false, ended = false, open = false;
  bool opening = false;  // within the library
  int worker = 0;        // whose images count; the others are left behind
  std::set<int> done;    // workers that have left their source for good
  std::optional<Frame> newest;
  std::int64_t taken = -1;  // sequence of the last frame that was taken
  std::int64_t sequence = 0;
  std::optional<std::int64_t> driver_count;
  std::optional<bool> own_clock;       // whether the driver's stamps are of a clock of its own
  ClockSync clock;                     // that one
  std::optional<double> driver_stamp;  // the newest by it
  std::optional<double> newest_stamp;  // mapped, of all that came; the monotonic clock outlives openings
  double heard_s = MonotonicNow_s();   // when an image last came, or the camera was made
  double begun_s = heard_s;            // when the worker last came from the library, or went into it to open
  LiveCameraHealth health;

  // The rest runs on a worker's own thread.
  bool Current(int which) const { return !stop && which == worker; }

  void Work(int which, const ImageSourceMaker& make, const LiveCameraOptions& options) {
    double pause_s = options.reopen_first_s;
    while (true) {
      {
        const std::lock_guard lock(mutex);
        if (!Current(which)) return;
        opening = true, begun_s = MonotonicNow_s();
      }
      const std::unique_ptr<ImageSource> source = make();
      const bool opened = source && source->Open();
      {
        const std::lock_guard lock(mutex);
        if (!Current(which)) return;
        open = opened, opening = false, begun_s = MonotonicNow_s();
        driver_count.reset(), own_clock.reset(), driver_stamp.reset(), clock = {};
        if (opened)
          ++health.openings;
        else
          health.error = source ? source->Error() : "";
      }
      while (opened) {
        std::optional<Grabbed> grabbed = source->Grab();
        const std::lock_guard lock(mutex);
        if (!Current(which)) return;
        if (!grabbed || grabbed->image.empty()) {
          health.error = source->Error();
          if (source->Ended()) {
            ended = true;
            changed.notify_all();
            return;
          }
          break;
        }
        pause_s = options.reopen_first_s;
        Put(std::move(*grabbed), options);
      }
      std::unique_lock lock(mutex);
      if (!Current(which)) return;
      open = false;
      changed.wait_for(lock, Seconds(pause_s), [&] { return !Current(which); });
      if (!Current(which)) return;
      pause_s = std::min(2 * pause_s, options.reopen_max_s);
    }
  }

  // The driver's stamp on the monotonic clock.
  std::optional<double> Mapped(const std::optional<double>& stamp_s, double now_s) {
    if (!stamp_s || !std::isfinite(*stamp_s)) return std::nullopt;
    const double age_s = now_s - *stamp_s;
    if (!own_clock) own_clock = age_s < 0 || age_s > LiveCamera::kMonotonic_s;
    clock.AddSample(*stamp_s, now_s);
    return std::min(*own_clock ? *clock.ToOurs(*stamp_s) : *stamp_s, now_s);
  }

  // The driver gave this image before, or a newer one.
  bool Disordered(const Grabbed& grabbed, const std::optional<double>& mapped_s) const {
    if (grabbed.count && driver_count && *grabbed.count <= *driver_count) return true;
    if (!mapped_s) return false;
    // As the drift of a clock of its own is followed, an old stamp may seem new; one that is much older is of
    // a clock that was set anew.
    if (*own_clock && driver_stamp && *grabbed.stamp_s <= *driver_stamp &&
        *grabbed.stamp_s > *driver_stamp - ClockSync::kJump_s)
      return true;
    return newest_stamp && *mapped_s <= *newest_stamp;
  }

  void Put(Grabbed grabbed, const LiveCameraOptions& options) {
    const double now_s = MonotonicNow_s();
    const std::optional<double> mapped_s = Mapped(grabbed.stamp_s, now_s);
    if (Disordered(grabbed, mapped_s)) {
      ++health.disordered;
      return;
    }
    heard_s = begun_s = now_s;
    // Exposures that the driver counted and nobody saw are gaps, as lost frames are.
    if (grabbed.count && driver_count && *grabbed.count > *driver_count + 1) {
      const std::int64_t gap = *grabbed.count - *driver_count - 1;
      health.missed += gap, sequence += gap;
    }
    driver_count = grabbed.count;
    if (mapped_s) newest_stamp = mapped_s, driver_stamp = grabbed.stamp_s;
    if (newest && newest->sequence > taken) ++health.overwritten;
    newest = Frame{std::move(grabbed.image), mapped_s.value_or(now_s) - options.exposure_before_stamp_s,
                   sequence++};
    ++health.images;
    changed.notify_all();
  }
};

LiveCamera::LiveCamera(ImageSourceMaker source, const LiveCameraOptions& options)
    : source_(std::move(source)), options_(options), mailbox_(std::make_shared<Mailbox>()) {
  const std::lock_guard lock(mailbox_->mutex);
  Watch();
}

LiveCamera::~LiveCamera() {
  Stop();
  std::unique_lock lock(mailbox_->mutex);
  mailbox_->changed.wait_for(lock, Seconds(options_.stalled_s),
                             [&] { return mailbox_->done.size() == threads_.size(); });
  const std::set<int> done = mailbox_->done;
  lock.unlock();
  for (std::size_t i = 0; i < threads_.size(); ++i) {
    if (done.contains(static_cast<int>(i) + 1)) {
      threads_[i].join();
    } else {
      threads_[i].detach();
      ++left_behind;
    }
  }
}

int LiveCamera::LeftBehind() { return left_behind; }

void LiveCamera::Stop() {
  const std::lock_guard lock(mailbox_->mutex);
  mailbox_->stop = true;
  mailbox_->changed.notify_all();
}

// Begins with the first source, and again where one hangs. The mailbox is locked.
void LiveCamera::Watch() {
  Mailbox& m = *mailbox_;
  const double silent_s = MonotonicNow_s() - m.begun_s;
  const bool hangs = (m.open && silent_s > options_.stalled_s) ||
                     (m.opening && silent_s > std::max(kOpening_s, options_.stalled_s));
  if (m.worker > 0 && !(hangs && m.worker <= kMaxLeftBehind)) return;
  m.begun_s = MonotonicNow_s(), m.open = m.opening = false;
  const int which = ++m.worker;
  m.changed.notify_all();
  threads_.emplace_back([mailbox = mailbox_, which, make = source_, options = options_] {
    mailbox->Work(which, make, options);
    const std::lock_guard lock(mailbox->mutex);
    mailbox->done.insert(which);
    mailbox->changed.notify_all();
  });
}

std::optional<Frame> LiveCamera::Next() {
  while (true) {
    if (auto frame = Next(options_.stalled_s)) return frame;
    const std::lock_guard lock(mailbox_->mutex);
    if (mailbox_->stop || mailbox_->ended) return std::nullopt;
  }
}

std::optional<Frame> LiveCamera::Next(double max_s) {
  Mailbox& m = *mailbox_;
  std::unique_lock lock(m.mutex);
  const auto fresh = [&] { return m.newest && m.newest->sequence > m.taken; };
  const double until_s = MonotonicNow_s() + max_s;
  while (!fresh() && !m.stop && !m.ended) {
    const double left_s = until_s - MonotonicNow_s();
    if (left_s <= 0) return std::nullopt;
    m.changed.wait_for(lock, Seconds(std::min(left_s, options_.stalled_s / 4)));
    Watch();
  }
  if (m.stop || !fresh()) return std::nullopt;
  m.taken = m.newest->sequence;
  return std::exchange(m.newest, std::nullopt);
}

LiveCameraHealth LiveCamera::Health() const {
  const std::lock_guard lock(mailbox_->mutex);
  LiveCameraHealth health = mailbox_->health;
  const double silent_s = MonotonicNow_s() - mailbox_->heard_s;
  if (health.images > 0) health.age_s = silent_s + options_.exposure_before_stamp_s;
  health.state = mailbox_->ended                       ? LiveCameraState::kEnded
                 : silent_s > options_.stalled_s       ? LiveCameraState::kStalled
                 : mailbox_->open && health.images > 0 ? LiveCameraState::kStreaming
                                                       : LiveCameraState::kOpening;
  return health;
}

const char* NameOf(LiveCameraState state) {
  switch (state) {
    case LiveCameraState::kOpening:
      return "opening";
    case LiveCameraState::kStreaming:
      return "streaming";
    case LiveCameraState::kStalled:
      return "stalled";
    case LiveCameraState::kEnded:
      return "ended";
  }
  return "?";
}

}  // namespace kestrel::vision
