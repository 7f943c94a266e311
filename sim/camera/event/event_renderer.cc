// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/event/event_renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "base/nanoseconds.h"

namespace kestrel::sim {
namespace {

constexpr int kEvery = 8;             // px between the pixels whose flow is looked at
constexpr double kLongest_s = 0.01;   // between samples
constexpr double kShortest_s = 2e-5;  // of an interval that is divided no further

// One that sees the same with every eighth pixel of every eighth row.
vision::CameraModel Sparse(vision::CameraModel camera) {
  Eigen::VectorXd parameters = vision::Parameters(camera);
  parameters.head<2>() /= kEvery;
  parameters.segment<2>(2) = (parameters.segment<2>(2).array() + 0.5) / kEvery - 0.5;
  vision::SetParameters(camera, parameters);
  std::visit(
      [](auto& c) {
        c.width_px = std::max(1, c.width_px / kEvery);
        c.height_px = std::max(1, c.height_px / kEvery);
      },
      camera);
  return camera;
}

}  // namespace

EventRenderer::EventRenderer(const mjModel* model, const vision::CameraModel& camera,
                             const RenderOptions& render, const ImageParameters& image, const Pose& X_BC,
                             const Vibration& vibration, const EventCameraParameters& parameters,
                             std::uint64_t seed)
    : parameters_(parameters),
      events_camera_(parameters, {vision::WidthPx(camera), vision::HeightPx(camera)}, seed),
      interpolator_(model, X_BC, vibration),
      renderer_(model, camera, render),
      flow_(model, Sparse(camera), render),
      defocus_(image.lens),
      shade_(Shade(image.lens, camera, seed)),
      gamma_(image.gamma) {}

void EventRenderer::Add(Snapshot snapshot) {
  snapshots_.push_back(std::move(snapshot));
  const double from_s = snapshots_.front().t_s, until_s = snapshots_.back().t_s;
  const auto states = interpolator_.Of(snapshots_, from_s, until_s);
  if (snapshots_.size() == 1) {
    brightness_ = BrightnessAt(states, until_s);
    events_camera_.Begin(brightness_, Nanoseconds(until_s));
    return;
  }
  const double move_px = MoveBetween(states.front(), states.back());
  if (move_px <= parameters_.largest_move_px && until_s - from_s < kLongest_s - 1e-9) return;
  SampleUntil(states, std::max(1, static_cast<int>(std::ceil(move_px / parameters_.largest_move_px))));
}

void EventRenderer::Finish() {
  if (snapshots_.size() < 2) return;
  SampleUntil(interpolator_.Of(snapshots_, snapshots_.front().t_s, snapshots_.back().t_s), 1);
}

std::vector<Event> EventRenderer::Take() { return std::exchange(events_, {}); }

double EventRenderer::MoveBetween(const SceneState& before, const SceneState& now) {
  if (seen_.geom.empty()) seen_ = flow_.Trace(before.data, before.X_NC);
  const cv::Mat flow = flow_.Flow(seen_, before, now);
  float largest = 0;
  for (const cv::Vec2f& move : cv::Mat_<cv::Vec2f>(flow))
    if (!std::isnan(move[0])) largest = std::max(largest, std::hypot(move[0], move[1]));
  return kEvery * static_cast<double>(largest);
}

// The order in which light meets the parts is the image sensor's.
cv::Mat EventRenderer::BrightnessAt(std::span<const SceneState> states, double t_s) {
  ++samples_;
  cv::Mat light = renderer_.RenderGrey(states, t_s) / 255;
  if (gamma_ != 1) cv::pow(light, gamma_, light);
  if (!defocus_.sharp()) light = defocus_.Spread(light);
  if (!shade_.empty()) light = light.mul(shade_);
  light += parameters_.log_eps;
  cv::log(light, light);
  return light;
}

void EventRenderer::SampleUntil(std::span<const SceneState> states, int parts) {
  const double from_s = snapshots_.front().t_s, gap_s = snapshots_.back().t_s - from_s;
  for (int i = 0; i < parts; ++i) {
    const double until_s = i + 1 == parts ? snapshots_.back().t_s : from_s + gap_s * (i + 1) / parts;
    Approach(states, from_s + gap_s * i / parts, until_s, BrightnessAt(states, until_s));
  }
  snapshots_.erase(snapshots_.begin(), snapshots_.end() - 1);
  seen_ = {};
}

// Halves what the brightness changes too much in: the far end is drawn already and is drawn but once.
void EventRenderer::Approach(std::span<const SceneState> states, double from_s, double until_s,
                             const cv::Mat& brightness) {
  if (parameters_.largest_change > 0 && until_s - from_s > kShortest_s &&
      events_camera_.LargestChange(brightness) > parameters_.largest_change) {
    const double middle_s = (from_s + until_s) / 2;
    Approach(states, from_s, middle_s, BrightnessAt(states, middle_s));
    return Approach(states, middle_s, until_s, brightness);
  }
  const std::vector<Event> events = events_camera_.Update(brightness, Nanoseconds(until_s));
  events_.insert(events_.end(), events.begin(), events.end());
  brightness_ = brightness;
}

}  // namespace kestrel::sim
