// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "geometry/pose.h"
#include "sim/camera/event/event_camera.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/snapshots.h"
#include "sim/render/ray/ray_renderer.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

// An event camera in a world that moves. Its light is sampled as often as the world moves in the image (ESIM,
// section 4.2, by optical flow): the states of the world are waited for until what is seen has moved by
// largest_move_px, at every eighth pixel of every eighth row by the ray renderer's exact flow, or for 10 ms; a
// longer move is divided evenly. With largest_change, two samples between which a pixel changes more are
// divided in halves, to 20 us. Rays draw it, whatever draws the frames; there are no bytes between them and
// the logarithm.
//
// The same states give the same events, for any number of threads.
class EventRenderer {
 public:
  // image: its lens and its gamma are the event camera's too; without scatter. The model must outlive it.
  // Throws what the RayRenderer throws.
  EventRenderer(const mjModel* model, const vision::CameraModel& camera, const RenderOptions& render,
                const ImageParameters& image, const Pose& X_BC, const Vibration& vibration,
                const EventCameraParameters& parameters, std::uint64_t seed);

  // The next state of the world, later than the one before. Events begin after the first.
  void Add(Snapshot snapshot);
  void Finish();  // samples up to the last state

  std::vector<Event> Take();  // those since it was last called, in their order
  std::int64_t samples() const { return samples_; }
  // The log of the light that each pixel gets, as it was sampled last.
  const cv::Mat& brightness() const { return brightness_; }
  const EventCamera& camera() const { return events_camera_; }

 private:
  double MoveBetween(const SceneState& before, const SceneState& now);
  cv::Mat BrightnessAt(std::span<const SceneState> states, double t_s);
  void SampleUntil(std::span<const SceneState> states, int parts);
  void Approach(std::span<const SceneState> states, double from_s, double until_s, const cv::Mat& brightness);

  EventCameraParameters parameters_;
  EventCamera events_camera_;
  SnapshotInterpolator interpolator_;
  RayRenderer renderer_, flow_;  // flow_: of every eighth pixel
  Defocus defocus_;
  cv::Mat shade_;
  double gamma_;
  std::vector<Snapshot> snapshots_;  // from the last sample on
  Surfaces seen_;                    // by flow_ at the last sample; empty: not looked at yet
  cv::Mat brightness_;
  std::vector<Event> events_;
  std::int64_t samples_ = 0;
};

}  // namespace kestrel::sim
