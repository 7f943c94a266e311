// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <utility>

#include "vision/aircraft/ground_camera.h"
#include "vision/capture/live_camera.h"

// A real camera on the ground, without a head. Its frames are stamped by the clock of this computer, as those of the
// camera on board and the autopilot's states are.
namespace kestrel::flight {

// Beside the camera that paces the flight.
class LiveGroundCamera final : public vision::GroundCamera {
 public:
  explicit LiveGroundCamera(vision::LiveCamera& camera) : camera_(camera) {}
  std::optional<vision::GroundFrame> Take() override {
    auto frame = camera_.Next(0);
    return frame ? std::optional(vision::GroundFrame{std::move(*frame), {}}) : std::nullopt;
  }
  void Turn(const vision::PanTilt&) override {}

 private:
  vision::LiveCamera& camera_;
};

// The one that paces the flight itself, of an aircraft that carries none: it is given each frame first.
class PacingGroundCamera final : public vision::GroundCamera {
 public:
  void Give(const vision::Frame& frame) { frames_.push_back(frame); }
  std::optional<vision::GroundFrame> Take() override {
    if (frames_.empty()) return std::nullopt;
    vision::GroundFrame frame{std::move(frames_.front()), {}};
    frames_.pop_front();
    return frame;
  }
  void Turn(const vision::PanTilt&) override {}

 private:
  std::deque<vision::Frame> frames_;
};

}  // namespace kestrel::flight
