// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <mutex>
#include <optional>

#include "control/link/autopilot_link.h"

namespace kestrel::control {

// A link without a wire.
class FakeLink final : public AutopilotLink {
  auto Locked(const auto& action) const {
    const std::lock_guard lock(mutex_);
    return action();
  }

 public:
  VehicleState State() const override {
    return Locked([&] { return state_; });
  }
  void Send(const Setpoint& setpoint) override {
    Locked([&] {
      sent_ = last_ = setpoint, ++sends_;
      if (answer_) answer_(setpoint, state_);
    });
  }
  void Aid(const AttitudeAid&) override {}
  LinkHealth Health() const override {
    return Locked([&] { return health_; });
  }
  void Silence() override {
    Locked([&] { sent_.reset(), silent_ = true; });
  }

  void Set(const std::function<void(VehicleState&, LinkHealth&)>& change) {
    Locked([&] { change(state_, health_); });
  }
  // What the aircraft makes of each setpoint.
  void Answer(const std::function<void(const Setpoint&, VehicleState&)>& answer) {
    Locked([&] { answer_ = answer; });
  }
  std::optional<Setpoint> last() const {  // before the silence
    return Locked([&] { return last_; });
  }
  std::optional<Setpoint> sent() const {
    return Locked([&] { return sent_; });
  }
  int sends() const {
    return Locked([&] { return sends_; });
  }
  bool silent() const {
    return Locked([&] { return silent_; });
  }
  std::optional<Eigen::Vector3d> velocity() const {
    const auto s = sent();
    return s && std::holds_alternative<VelocitySetpoint>(*s)
               ? std::optional(std::get<VelocitySetpoint>(*s).v_H)
               : std::nullopt;
  }

 private:
  static LinkHealth Alive() {
    LinkHealth health;
    health.open = true;
    health.state_age_s = 0;
    health.pilot_allows = true;
    return health;
  }
  mutable std::mutex mutex_;
  VehicleState state_;
  LinkHealth health_ = Alive();
  std::optional<Setpoint> sent_, last_;
  std::function<void(const Setpoint&, VehicleState&)> answer_;
  int sends_ = 0;
  bool silent_ = false;
};

}  // namespace kestrel::control
