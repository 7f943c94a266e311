// SPDX-License-Identifier: Apache-2.0
// An aircraft that is let go, over each wire: what it follows at the end is to stand still.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <thread>

#include "base/stopwatch.h"
#include "control/link/afcs_link.h"
#include "control/link/asctec_link.h"
#include "control/link/mavlink_link.h"
#include "control/link/safe_autopilot.h"
#include "sim/server/afcs_server.h"
#include "sim/server/asctec_server.h"
#include "sim/server/mavlink/mavlink_server.h"
#include "tests/sim/server/fake_aircraft.h"

namespace kestrel::sim {
namespace {

constexpr double kDeadline_s = 30;

// A served aircraft, on a thread of its own.
class Served {
 public:
  explicit Served(AutopilotServer& server) : server_(server), thread_([this] { Run(); }) {}
  ~Served() {
    stop_ = true;
    thread_.join();
  }
  // What it follows; none: not a velocity.
  std::optional<Eigen::Vector3d> Follows() const {
    const std::lock_guard lock(mutex_);
    const auto* v =
        aircraft_.following ? std::get_if<control::VelocitySetpoint>(&*aircraft_.following) : nullptr;
    return v ? std::optional(v->v_H) : std::nullopt;
  }

 private:
  void Run() {
    for (double last_s = MonotonicNow_s(); !stop_;) {
      const double now_s = MonotonicNow_s();
      {
        const std::lock_guard lock(mutex_);
        aircraft_.Step(now_s - last_s);
        server_.Serve(now_s, aircraft_);
      }
      last_s = now_s;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  AutopilotServer& server_;
  mutable std::mutex mutex_;
  FakeAircraft aircraft_ = Flying(15);
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

void ExpectLetGo(AutopilotServer& server, control::AutopilotLink& link) {
  const Served served(server);
  control::SafeAutopilot safe(link, [] { return 0.0; }, {.limits = {}, .pilot_untold = true});
  const double until_s = MonotonicNow_s() + kDeadline_s;
  const auto flies = [&] {
    const auto v = served.Follows();
    return v && v->x() > 0.3 && link.State().v_N.norm() > 0.3;
  };
  while (!flies()) {
    ASSERT_LT(MonotonicNow_s(), until_s) << link.Health().error;
    safe.Send(control::VelocitySetpoint{{0.5, 0, 0}, 0});
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const auto released = safe.LetGo({.still_s = 0.1, .max_s = kDeadline_s});
  ASSERT_TRUE(released);
  EXPECT_EQ(released->how, control::Release::kHeld);
  const auto v = served.Follows();
  ASSERT_TRUE(v);
  EXPECT_LT(v->norm(), 0.01);
  const std::uint64_t sent = link.Health().sent;
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  EXPECT_LE(link.Health().sent, sent + 1);  // one may have been under way
}

TEST(ReleaseOverWires, Mavlink) {
  for (const char* dialect : {"px4", "ardupilot"}) {
    MavlinkServerOptions options;
    options.dialect = dialect, options.port = 0;
    MavlinkServer server(options);
    control::MavlinkLink link(server.Where(), {.take_control = true});
    ExpectLetGo(server, link);
  }
}

TEST(ReleaseOverWires, Afcs) {
  AfcsServerOptions options;
  options.port = 0;
  AfcsServer server(options);
  control::AfcsLinkOptions link_options;
  const std::string where = server.Where();
  link_options.port = std::stoi(where.substr(where.rfind(':') + 1));
  control::AfcsLink link(link_options);
  ExpectLetGo(server, link);
}

TEST(ReleaseOverWires, AscTec) {
  AscTecServer server({});
  control::AscTecOptions options;
  options.device = server.Where().substr(std::string("serial:").size());
  options.mode = "gps";  // in the other the velocity loop is at our end: tests/sim/server/asctec_link_test.cc
  control::AscTecLink link(options);
  ExpectLetGo(server, link);
}

}  // namespace
}  // namespace kestrel::sim
