// SPDX-License-Identifier: Apache-2.0
#include "control/link/mavlink_session.h"

#include <gtest/gtest.h>

#include "control/wire/mavlink_messages.h"
#include "tests/control/mavlink_frames.h"

namespace kestrel::control {
namespace {

namespace mav = wire::mavlink;

// It is shown on a terminal, and anybody who reaches the port may have sent it.
TEST(MavlinkSession, WhatAnAutopilotSaysCommandsNoTerminal) {
  MavlinkSession session({});
  mav::Sender sender(1, 1);
  session.Receive(sender.Encode(mav::Statustext{.severity = 3, .text = mav::Text("no\x1b[2J fly\x07")}), 1);
  EXPECT_EQ(session.Health(1).error, "no\\x1b[2J fly\\x07");
}

}  // namespace
}  // namespace kestrel::control
