// SPDX-License-Identifier: Apache-2.0
#include "base/process/status_line.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

// The standard error is a file here, and no terminal.
TEST(StatusLine, IsALineEverySoOftenWhereThereIsNoTerminal) {
  testing::internal::CaptureStderr();
  {
    StatusLine line("bench", 1000);
    line.Show("1 of 2");
    line.Show("2 of 2");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  testing::internal::CaptureStderr();
  {
    StatusLine line("bench", 0);
    line.Show("1 of 2");
    line.Show("2 of 2");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "bench: 1 of 2\nbench: 2 of 2\n");
}

}  // namespace
}  // namespace kestrel
