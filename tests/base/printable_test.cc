// SPDX-License-Identifier: Apache-2.0
#include "base/printable.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

TEST(Printable, WhatCommandsATerminalIsAControlCharacterAndIsShownAsItsBytes) {
  for (const char* text : {"\n", "\t", "\r", "a\x1b[2Jb", "\x7f",
                           "\xc2\x9b"
                           "2J",
                           "x\x01"})
    EXPECT_TRUE(HasControl(text)) << Printable(text);
  EXPECT_TRUE(HasControl(std::string_view("\0", 1)));
  for (const char* text :
       {"", "plain", "gr\xc3\xbcn", "\xc2\xa0", "\xe2\x82\xac", "| touch 'x' `y` \"z\" {= =}"})
    EXPECT_FALSE(HasControl(text)) << text;

  EXPECT_EQ(Printable("a\x1b[2J \xc2\x9b \r gr\xc3\xbcn\n\t\xff"),
            "a\\x1b[2J \\xc2\\x9b \\x0d gr\xc3\xbcn\n\t\\xff");
  EXPECT_EQ(Printable("\xe2\x82"), "\\xe2\\x82");  // cut within a letter
}

}  // namespace
}  // namespace kestrel
