// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/stamp.h"

#include <gtest/gtest.h>

namespace kestrel::vision {
namespace {

TEST(Stamp, NanosecondsAreDigitsAlone) {
  EXPECT_EQ(StampOfNanoseconds("1403636579763555584"), 1403636579763555584);
  EXPECT_EQ(StampOfNanoseconds("0"), 0);
  for (const char* none : {"", "-5", "+5", "1.5", "12a", " 12", "1e3", "99999999999999999999"})
    EXPECT_FALSE(StampOfNanoseconds(none)) << none;
}

// A double holds a time of day in s to 2.4e-7 s only; these are to the nanosecond.
TEST(Stamp, SecondsAreExactToTheNanosecond) {
  EXPECT_EQ(StampOfSeconds("1305031102.175304"), 1305031102175304000);
  EXPECT_EQ(StampOfSeconds("1305031102.175304123"), 1305031102175304123);
  EXPECT_EQ(StampOfSeconds("1305031102.1753041234"), 1305031102175304123);
  EXPECT_EQ(StampOfSeconds("1305031102.1753041235"), 1305031102175304124);
  EXPECT_EQ(StampOfSeconds("7"), 7000000000);
  EXPECT_EQ(StampOfSeconds("0.05"), 50000000);
  EXPECT_EQ(StampOfSeconds("1.036224e-01"), 103622400);
  EXPECT_EQ(StampOfSeconds("0.000000e+00"), 0);
  for (const char* none : {"", ".5", "-1", "1.2.3", "nan", "inf", "1e300", "1e", "9999999999999.5", "0x10"})
    EXPECT_FALSE(StampOfSeconds(none)) << none;
}

TEST(Stamp, ANumberOfAnImageIsNone) {
  EXPECT_EQ(StampOfName("1403636579763555584"), 1403636579763555584);
  EXPECT_EQ(StampOfName("1305031102.175304"), 1305031102175304000);
  for (const char* none :
       {"000012", "0000000000", "1403636579763555", "view1", "1.5", "clip.mp4-00.06.13.959", ""})
    EXPECT_FALSE(StampOfName(none)) << none;
}

}  // namespace
}  // namespace kestrel::vision
