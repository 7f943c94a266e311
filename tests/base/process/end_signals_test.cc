// SPDX-License-Identifier: Apache-2.0
#include "base/process/end_signals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <vector>

namespace kestrel {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<int> heard;
void Asked(int signal) { heard.push_back(signal); }  // of signals that this thread raises itself

class EndSignalsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    Default();
    heard.clear();
  }
  void TearDown() override { Default(); }
  static void Default() {
    for (const int each : {SIGINT, SIGTERM, SIGHUP}) std::signal(each, SIG_DFL);
  }
};

TEST_F(EndSignalsTest, AHangUpIsAsTheRequestToTerminateHoweverOftenItComes) {
  OnEndSignals(Asked);
  for (const int each : {SIGINT, SIGTERM, SIGHUP, SIGHUP}) std::raise(each);
  EXPECT_THAT(heard, ElementsAre(SIGINT, SIGTERM, SIGTERM, SIGTERM));
  EndOnNextSignal();
  std::raise(SIGHUP);
  EXPECT_EQ(heard.size(), 5u);
}

TEST_F(EndSignalsTest, TheNextInterruptOrRequestEndsTheProgramWhereThatIsAskedFor) {
  OnEndSignals([](int) { EndOnNextSignal(); });
  std::raise(SIGHUP);
  EXPECT_EXIT(std::raise(SIGINT), testing::KilledBySignal(SIGINT), "");
  EXPECT_EXIT(std::raise(SIGTERM), testing::KilledBySignal(SIGTERM), "");
}

TEST_F(EndSignalsTest, UnderNohupAHangUpIsOfNoMatter) {
  std::signal(SIGHUP, SIG_IGN);
  OnEndSignals(Asked);
  std::raise(SIGHUP);
  EXPECT_THAT(heard, IsEmpty());
}

}  // namespace
}  // namespace kestrel
