// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/frame_renderer.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "base/stopwatch.h"

namespace kestrel::sim {
namespace {

double DaylightAt(const FrameRequest& request) {
  const auto later = std::ranges::upper_bound(request.snapshots, request.t_s + 1e-9, {}, &Snapshot::t_s);
  return later == request.snapshots.begin() ? request.snapshots.front().daylight : std::prev(later)->daylight;
}

}  // namespace

FrameRenderer::FrameRenderer(const mjModel* model, const vision::CameraModel& camera,
                             const RenderOptions& render, const ImageParameters& image, const Pose& X_BC,
                             const Vibration& vibration, std::uint64_t seed, bool surfaces, bool beside)
    : model_(model),
      camera_(camera),
      options_(render),
      parameters_(image),
      sensor_(image, camera, seed),
      control_(image.exposure, image.auto_exposure, image.gain, image.gamma),
      interpolator_(model, X_BC, vibration),
      may_repeat_(std::any_of(image.faults.begin(), image.faults.end(),
                              [](const CameraFault& f) { return f.type == "stuck"; })),
      surfaces_(surfaces) {
  if (!beside) {
    renderer_ = std::make_unique<Renderer>(model_, camera_, options_);
    return;
  }
  std::promise<void> ready;
  std::future<void> is_ready = ready.get_future();
  thread_ = std::thread([this, ready = std::move(ready)]() mutable { Work(std::move(ready)); });
  try {
    is_ready.get();
  } catch (...) {
    thread_.join();
    throw;
  }
}

FrameRenderer::~FrameRenderer() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void FrameRenderer::Submit(FrameRequest request) {
  std::packaged_task<RenderedFrame()> task([this, s = std::move(request)] { return Draw(s); });
  pictures_.push_back(task.get_future());
  if (!thread_.joinable()) return task();
  {
    const std::lock_guard lock(mutex_);
    tasks_.push(std::move(task));
  }
  wake_.notify_one();
}

RenderedFrame FrameRenderer::Next() {
  std::future<RenderedFrame>& next = pictures_.front();
  loop_.HelpUntil([&] { return next.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
  RenderedFrame picture = next.get();
  pictures_.pop_front();
  return picture;
}

void FrameRenderer::Work(std::promise<void> ready) {
  try {
    renderer_ = std::make_unique<Renderer>(model_, camera_, options_, &loop_);
    ready.set_value();
  } catch (...) {
    renderer_.reset();
    ready.set_exception(std::current_exception());
    return;
  }
  for (;;) {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [this] { return stop_ || !tasks_.empty(); });
    if (stop_) break;
    std::packaged_task<RenderedFrame()> task = std::move(tasks_.front());
    tasks_.pop();
    lock.unlock();
    task();
    loop_.Wake();
  }
  renderer_.reset();  // on the thread of its context
}

RenderedFrame FrameRenderer::Draw(const FrameRequest& request) {
  RenderedFrame picture;
  if (surfaces_) Survey(request, picture);
  may_repeat_ |= request.content == FrameRequest::Content::kRepeat;
  if (request.content == FrameRequest::Content::kRepeat && !last_.empty()) {
    picture.image = last_.clone();
    return picture;
  }
  auto start = std::chrono::steady_clock::now();
  if (request.content == FrameRequest::Content::kGarbage) {
    picture.image = sensor_.Garbage({vision::WidthPx(camera_), vision::HeightPx(camera_)}, request.sequence);
  } else {
    ExposureSetting setting = control_.setting();
    const cv::Mat bgr = Render(request, setting);
    setting.light *= DaylightAt(request);
    picture.render_s = SecondsSince(start);
    start = std::chrono::steady_clock::now();
    picture.image = sensor_.Expose(bgr, request.sequence, setting);
    if (control_.automatic()) control_.Meter(sensor_.MeanGrey(picture.image), request.t_s);
  }
  picture.sensor_s = SecondsSince(start);
  if (may_repeat_) last_ = picture.image.clone();
  return picture;
}

void FrameRenderer::Survey(const FrameRequest& request, RenderedFrame& picture) {
  std::vector<Snapshot> snapshots = std::move(surveyed_);
  const bool first = snapshots.empty();
  if (first) surveyed_s_ = request.t_s;
  snapshots.insert(snapshots.end(), request.snapshots.begin(), request.snapshots.end());
  const auto states = interpolator_.Of(snapshots, surveyed_s_, request.t_s);
  const SceneState &before = states.front(), &now = states.back();
  picture.surfaces = renderer_->Trace(now.data, now.X_NC);
  if (!first) picture.flow_here = renderer_->Flow(seen_, before, now);
  seen_ = picture.surfaces;
  surveyed_ = request.snapshots;
  surveyed_s_ = request.t_s;
}

cv::Mat FrameRenderer::Render(const FrameRequest& request, const ExposureSetting& setting) {
  const double line_s = parameters_.exposure.line_s;
  const double to_end_s = line_s * (vision::HeightPx(camera_) - 1) / 2 + setting.time_s / 2;
  const auto states = interpolator_.Of(request.snapshots, request.t_s - to_end_s, request.t_s + to_end_s);
  if (to_end_s <= 0) return renderer_->Render(states.front().data, states.front().X_NC);
  const Shutter shutter{request.t_s - line_s * (vision::HeightPx(camera_) - 1) / 2, setting.time_s, line_s,
                        setting.time_s > 0 ? parameters_.exposure.samples : 1};
  return renderer_->Render(states, shutter);
}

}  // namespace kestrel::sim
