// SPDX-License-Identifier: Apache-2.0
#include "app/option/within.h"

#include <gmock/gmock.h>

#include <string>

namespace kestrel::app {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string Refusal(std::string text) { return Within(0.3, 0.95)(text); }

TEST(WithinTest, BothEndsAreWithin) {
  EXPECT_THAT(Refusal("0.3"), IsEmpty());
  EXPECT_THAT(Refusal("0.95"), IsEmpty());
}

TEST(WithinTest, WhatIsNotWithinIsToldWithWhatIsValid) {
  for (const char* text : {"0.29", "1", "nan", "-nan", "inf", "-inf", "half", ""})
    EXPECT_THAT(Refusal(text), HasSubstr("valid: 0.3 to 0.95")) << text;
}

TEST(WholeNumberTest, WhatIsNoneOrNotWithinIsToldWithWhatIsValid) {
  const auto refusal = [](std::string text) { return WholeNumber(9, 200)(text); };
  EXPECT_THAT(refusal("9"), IsEmpty());
  EXPECT_THAT(refusal("200"), IsEmpty());
  for (const char* text : {"8", "201", "9.5", "x", "", "99999999999"})
    EXPECT_THAT(refusal(text), HasSubstr("valid: a whole number, 9 to 200")) << text;
}

}  // namespace
}  // namespace kestrel::app
