// SPDX-License-Identifier: Apache-2.0
#include "app/flight/fly_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <thread>

#include "base/diagnostics.h"
#include "base/file/writer_lock.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::HasSubstr;

class FlyCommandTest : public InTemporaryFolder {
 protected:
  static std::string MistakesOf(const FlyArguments& a) {
    try {
      FlyCommand(a);
    } catch (const InputError& e) {
      return e.what();
    }
    ADD_FAILURE() << "nothing was refused";
    return "";
  }
  FlyArguments Arguments() const {
    FlyArguments a;
    a.scenario = "landing";
    a.cameras = {"v4l2:/dev/none"};
    a.autopilot = "mavlink:udp://127.0.0.1:1";
    a.out = (folder_ / "run").string();
    return a;
  }
};

TEST_F(FlyCommandTest, AllMistakesAreToldAtOnce) {
  FlyArguments a = Arguments();
  a.cameras = {"foo"};
  a.autopilot = "bar";
  a.overrides = {"a.b=1"};
  a.aircraft_overrides = {"safety.spede_m_s=1"};
  a.for_s = -5;
  a.dry_run = a.arm = true;
  const std::string told = MistakesOf(a);
  for (const char* each : {"--camera foo", "bar", "a.b", "spede_m_s", "--for: -5", "--arm"})
    EXPECT_THAT(told, HasSubstr(each));
}

TEST_F(FlyCommandTest, AsManyCamerasAsTheMissionFliesBy) {
  FlyArguments a = Arguments();
  a.cameras = {"v4l2:/dev/none", "v4l2:/dev/another"};
  EXPECT_THAT(MistakesOf(a), HasSubstr("2 of them, and the mission 'landing' flies by one"));
  a.scenario = "landing_hybrid";
  a.cameras.push_back("v4l2:/dev/third");
  EXPECT_THAT(MistakesOf(a), HasSubstr("3 of them, and the mission 'landing_hybrid' flies by two at most"));
  a.cameras.resize(1);
  EXPECT_THAT(MistakesOf(a), HasSubstr("--camera twice, that on board, then that on the ground"));
  a.cameras.push_back("foo");
  EXPECT_THAT(MistakesOf(a), HasSubstr("--camera foo"));
}

TEST_F(FlyCommandTest, ATimeThatIsNoneIsRefusedWithNumbersThatCanBeRead) {
  for (const double for_s : {std::numeric_limits<double>::quiet_NaN(), 0.0, -1.0, 1e9}) {
    FlyArguments a = Arguments();
    a.for_s = for_s;
    const std::string told = MistakesOf(a);
    EXPECT_THAT(told, HasSubstr("valid: from 0.1 to 36000"));
    EXPECT_LT(told.size(), 120u);
  }
}

TEST_F(FlyCommandTest, HowLongItWaitsMustBeATime) {
  FlyArguments a = Arguments();
  for (const double wait_s : {std::numeric_limits<double>::quiet_NaN(), -1.0, 1e9}) {
    a.wait_s = wait_s;
    EXPECT_THAT(MistakesOf(a), HasSubstr("--wait: "));
  }
}

TEST_F(FlyCommandTest, AFolderToWhichAnotherWritesIsRefusedBeforeAnythingIsOpened) {
  const WriterLock other = LockFolder(folder_ / "run");
  EXPECT_THAT(MistakesOf(Arguments()), HasSubstr("another process is writing to"));
}

TEST_F(FlyCommandTest, ATerminalThatGoesEndsTheCheckListInGoodOrderAndItIsOnRecord) {
  std::filesystem::create_directory(folder_ / "images");
  for (const char* name : {"1.png", "2.png", "3.png"})
    cv::imwrite((folder_ / "images" / name).string(), cv::Mat(480, 640, CV_8UC1, cv::Scalar(128)));
  FlyArguments a = Arguments();
  a.cameras = {"file:" + (folder_ / "images").string()};
  std::signal(SIGHUP, SIG_DFL);
  std::thread terminal([] {
    struct sigaction now {};
    do {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      sigaction(SIGHUP, nullptr, &now);
    } while (now.sa_handler == SIG_DFL);
    kill(getpid(), SIGHUP);
  });
  EXPECT_FALSE(FlyCommand(a));
  terminal.join();
  for (const int each : {SIGHUP, SIGINT, SIGTERM, SIGPIPE}) std::signal(each, SIG_DFL);
  std::ostringstream events;
  events << std::ifstream(folder_ / "run/events.log").rdbuf();
  EXPECT_THAT(events.str(), HasSubstr("camera: file:"));
  EXPECT_THAT(events.str(), HasSubstr("end: not flown: interrupted during the check list"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "run/aircraft.yaml"));
}

}  // namespace
}  // namespace kestrel::app
