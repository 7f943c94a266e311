// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <future>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <queue>
#include <string>
#include <thread>
#include <vector>

#include "sim/camera/exposure.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/renderer.h"
#include "sim/camera/snapshots.h"

namespace kestrel::sim {

// A frame that is to be drawn.
struct FrameRequest {
  enum class Content { kScene, kRepeat, kGarbage };  // kRepeat: the image of the frame before
  double t_s = 0;                                    // middle of the exposure of the middle row
  std::int64_t sequence = 0;
  Content content = Content::kScene;
  std::vector<Snapshot> snapshots;  // around its exposure
};

struct RenderedFrame {
  cv::Mat image;
  double render_s = 0, sensor_s = 0;  // time spent
  // If asked for, at the middle of the exposure of the middle row: what is truly there, whatever the sensor
  // makes of it, and how what was in the frame before has moved since.
  Surfaces surfaces;
  cv::Mat flow_here;  // as in Renderer::Flow, of the frame before; empty for the first
};

// Draws frames in the order in which they come: renders what is seen while the shutter is open, makes the
// sensor's image of it, and meters that for the next. Beside who submits them, on a thread of its own that
// holds the renderer, and that is helped by who waits for a frame; or, if not beside, in Submit(), all of it on one
// thread.
class FrameRenderer {
 public:
  // image: without scatter. surfaces: whether they and the flow are asked for. The model must outlive it.
  // Throws what the Renderer throws.
  FrameRenderer(const mjModel* model, const vision::CameraModel& camera, const RenderOptions& render,
                const ImageParameters& image, const Pose& X_BC, const Vibration& vibration,
                std::uint64_t seed, bool surfaces = false, bool beside = true);
  ~FrameRenderer();
  FrameRenderer(const FrameRenderer&) = delete;
  FrameRenderer& operator=(const FrameRenderer&) = delete;

  void Submit(FrameRequest request);
  RenderedFrame Next();  // of the earliest frame that is not taken yet; waits for it
  const std::string& renderer_name() const { return renderer_->name(); }

 private:
  void Work(std::promise<void> ready);
  RenderedFrame Draw(const FrameRequest& request);
  cv::Mat Render(const FrameRequest& request, const ExposureSetting& setting);
  void Survey(const FrameRequest& request, RenderedFrame& picture);

  const mjModel* model_;
  vision::CameraModel camera_;
  RenderOptions options_;
  ImageParameters parameters_;
  ImageSensor sensor_;
  ExposureControl control_;
  SnapshotInterpolator interpolator_;
  SharedLoop loop_;
  std::unique_ptr<Renderer> renderer_;
  bool may_repeat_, surfaces_;
  std::vector<Snapshot> surveyed_;  // the snapshots around the last frame, if surfaces are asked for
  Surfaces seen_;                   // in it
  double surveyed_s_ = 0;
  cv::Mat last_;  // only while it may be asked for again

  std::deque<std::future<RenderedFrame>> pictures_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::queue<std::packaged_task<RenderedFrame()>> tasks_;
  bool stop_ = false;
  std::thread thread_;  // none: not beside
};

}  // namespace kestrel::sim
