// SPDX-License-Identifier: Apache-2.0
#include "app/option/exit_status.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "vision/capture/live_camera.h"

namespace kestrel::app {
namespace {

class Hanging final : public vision::ImageSource {
 public:
  static inline std::atomic<bool> opening = false;
  bool Open() override {
    opening = true;
    while (true) std::this_thread::sleep_for(std::chrono::seconds(1));
  }
  std::optional<vision::Grabbed> Grab() override { return std::nullopt; }
};

// What an exit handler must not be run beneath: a program that comes to this does not end with its status.
[[noreturn]] void ExitHandler() { std::abort(); }

TEST(LeaveTest, WhereACameraHangsTheProgramEndsWithItsStatusAndNoExitHandlerRuns) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  const auto program = [] {
    std::atexit(ExitHandler);
    {
      vision::LiveCamera camera([] { return std::make_unique<Hanging>(); }, {.stalled_s = 0.05});
      while (!Hanging::opening) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::fputs("the last line", stderr);
    std::exit(ExitWith(3));
  };
  EXPECT_EXIT(program(), testing::ExitedWithCode(3), "the last line");
}

TEST(LeaveTest, OtherwiseItLeavesAsAnyProgramDoes) { EXPECT_EQ(ExitWith(2), 2); }

TEST(LeaveTest, AResultThatCouldNotBePrintedIsNone) {
  const auto program = [](int status) {
    if (!std::freopen("/dev/full", "w", stdout)) std::abort();
    std::puts("met");
    std::_Exit(ExitWith(status));
  };
  EXPECT_EXIT(program(kMet), testing::ExitedWithCode(3), "could not be written: No space left on device");
  EXPECT_EXIT(program(kNotMet), testing::ExitedWithCode(3), "could not be written");
  EXPECT_EXIT(program(kBadInput), testing::ExitedWithCode(2), "");
}

}  // namespace
}  // namespace kestrel::app
