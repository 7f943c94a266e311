// SPDX-License-Identifier: Apache-2.0
#include "app/option/live_option.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "flight/live/pace.h"

namespace kestrel::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> MistakesOf(const LiveArguments& arguments) {
  Mistakes mistakes;
  EXPECT_FALSE(ReadLive(arguments, mistakes));
  return mistakes.Texts();
}

TEST(LiveOptions, AreTheUsualOnesWhereNothingElseIsSaid) {
  Mistakes mistakes;
  const auto options = ReadLive({.port = "", .address = {}, .speed = {}, .origins = {}}, mistakes);
  ASSERT_TRUE(options);
  EXPECT_EQ(options->server.port, 8765);
  EXPECT_EQ(options->server.address, "127.0.0.1");
  EXPECT_EQ(options->speed, 1);
}

TEST(LiveOptions, AreTakenAsGiven) {
  Mistakes mistakes;
  const auto options =
      ReadLive({.port = "0", .address = "0.0.0.0", .speed = "max", .origins = {"https://a.b"}}, mistakes);
  ASSERT_TRUE(options);
  EXPECT_EQ(options->server.port, 0);
  EXPECT_EQ(options->server.address, "0.0.0.0");
  EXPECT_THAT(options->server.origins, ElementsAre("https://a.b"));
  EXPECT_EQ(options->speed, flight::Pace::kAsFast);
}

TEST(LiveOptions, AreRefusedAllAtOnceWithWhatIsValid) {
  EXPECT_THAT(MistakesOf({.port = "landing", .address = {}, .speed = "0.05", .origins = {}}),
              ElementsAre(HasSubstr("valid: from 1 to 65535"), HasSubstr("valid: from 0.1 to 100")));
  EXPECT_THAT(MistakesOf({.port = "65536", .address = {}, .speed = {}, .origins = {}}),
              ElementsAre(HasSubstr("'65536' is no port")));
  EXPECT_THAT(MistakesOf({.port = {}, .address = "0.0.0.0", .speed = "2", .origins = {"https://a.b"}}),
              ElementsAre(HasSubstr("--live-address: given without --live"), HasSubstr("--live-origin"),
                          HasSubstr("--live-speed")));
}

TEST(LiveOptions, AnEmptyAddressIsNoneAndAnEmptySpeedIsRefused) {
  EXPECT_THAT(
      MistakesOf({.port = {}, .address = "", .speed = "", .origins = {}}),
      ElementsAre(HasSubstr("--live-address: given without"), HasSubstr("--live-speed: given without")));
  Mistakes mistakes;
  const auto options = ReadLive({.port = "0", .address = "", .speed = {}, .origins = {}}, mistakes);
  ASSERT_TRUE(options);
  EXPECT_THROW(MakeLive(options), InputError);
}

TEST(LiveOptions, AnOriginIsASchemeAndAHost) {
  for (const char* wrong : {"not a url", "*", "https://", "https://*.a.b", "https://a.b/", "a.b", ""})
    EXPECT_THAT(MistakesOf({.port = "", .address = {}, .speed = {}, .origins = {wrong}}),
                ElementsAre(HasSubstr("is no origin of web pages")))
        << wrong;
}

TEST(LiveOptions, AreNoneWhereNobodyAskedForThem) { EXPECT_THAT(MistakesOf({}), IsEmpty()); }

}  // namespace
}  // namespace kestrel::app
