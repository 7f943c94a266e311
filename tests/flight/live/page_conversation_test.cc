// SPDX-License-Identifier: Apache-2.0
#include "flight/live/page_conversation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace kestrel::flight {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class LiveConversation : public testing::Test {
 protected:
  LiveConversation() {
    pages_.feed.Begin({{"scenario", "landing"}}, "t_s");
    pages_.command = [this](LiveCommand command) {
      commands_.push_back(std::move(command));
      return room_;
    };
    while (page_.Next()) {}
  }
  // The refusal that a message gets; empty: none.
  std::string Answer(std::string_view message, bool binary = false) {
    page_.Hear(message, binary);
    const auto answer = page_.Next();
    if (!answer) return {};
    const json parsed = json::parse(*answer->bytes);
    EXPECT_EQ(parsed["op"], "refused");
    return parsed["why"];
  }

  Pages pages_;
  std::vector<LiveCommand> commands_;
  bool room_ = true;
  PageConversation page_{pages_};
};

TEST_F(LiveConversation, CommandsReachTheFlight) {
  for (const char* message :
       {R"({"op":"pause"})", R"({"op":"resume"})", R"({"op":"step"})", R"({"op":"speed","value":0.1})",
        R"({"op":"speed","value":0})", R"({"op":"change","key":"wind.mean_m_s","value":[1,2]})"})
    EXPECT_EQ(Answer(message), "") << message;
  ASSERT_EQ(commands_.size(), 6u);
  EXPECT_EQ(commands_[3].speed, 0.1);
  EXPECT_EQ(commands_[5].key, "wind.mean_m_s");
  EXPECT_EQ(commands_[5].value, "[1,2]");
}

TEST_F(LiveConversation, WhatIsNoCommandIsRefusedWithAWord) {
  const std::string deep(20000, '['), long_key(3000, 'k');
  for (const std::string& message :
       {std::string(), std::string("\0\xff\x80", 3), std::string("["), std::string("42"), std::string("{}"),
        deep, std::string(R"({"op":5})"), std::string(R"({"op":"land"})"), std::string(R"({"op":"<b>"})"),
        std::string(R"({"op":"speed"})"), std::string(R"({"op":"speed","value":"fast"})"),
        std::string(R"({"op":"speed","value":-1})"), std::string(R"({"op":"speed","value":1e300})"),
        std::string(R"({"op":"speed","value":0.05})"), std::string(R"({"op":"change","value":1})"),
        std::string(R"({"op":"change","key":"a"})"), std::string(R"({"op":"change","key":["a"],"value":1})"),
        R"({"op":"change","key":")" + long_key + R"(","value":1})", R"({"op":")" + long_key + R"("})"}) {
    const std::string why = Answer(message);
    EXPECT_NE(why, "") << message.substr(0, 40);
    EXPECT_LT(why.size(), 1000u);
  }
  EXPECT_NE(Answer("{\"op\":\"pause\"}", true), "");
  EXPECT_TRUE(commands_.empty());
}

TEST_F(LiveConversation, AFlightThatIsOnlyWatchedRefusesEveryCommand) {
  pages_.refusals = {"this page only watches", "nothing is changed from here"};
  EXPECT_THAT(Answer(R"({"op":"pause"})"), HasSubstr("only watches"));
  EXPECT_THAT(Answer(R"({"op":"speed","value":2})"), HasSubstr("only watches"));
  EXPECT_THAT(Answer(R"({"op":"change","key":"a","value":1})"), HasSubstr("nothing is changed"));
  EXPECT_TRUE(commands_.empty());
}

TEST_F(LiveConversation, AFlightThatIsOverOrHasTooMuchToDoSaysSo) {
  room_ = false;
  EXPECT_THAT(Answer(R"({"op":"step"})"), HasSubstr("later"));
  pages_.feed.End({});
  page_.Hear(R"({"op":"step"})", false);
  EXPECT_THAT(*page_.Next()->bytes, HasSubstr("over"));
}

TEST_F(LiveConversation, WhoReadsNoAnswersDoesNotPileThemUp) {
  for (int i = 0; i < 10000; ++i) page_.Hear("garbage", false);
  int answers = 0;
  while (page_.Next()) ++answers;
  EXPECT_LE(answers, 100);
}

}  // namespace
}  // namespace kestrel::flight
