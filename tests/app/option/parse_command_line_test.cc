// SPDX-License-Identifier: Apache-2.0
#include "app/option/parse_command_line.h"

#include <gmock/gmock.h>

#include <CLI/CLI.hpp>

#include "app/option/one_of.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

struct Answer {
  std::optional<int> status;
  std::string out, err;
};

class ParseCommandLineTest : public testing::Test {
 protected:
  ParseCommandLineTest() {
    app_.require_subcommand(1);
    app_.set_version_flag("--version", "1.2.3");
    CLI::App* run = app_.add_subcommand("run", "Fly a scenario");
    run->add_option("scenario", scenario_, "A name")->required();
    run->add_option("--seed", seed_);
    CLI::App* campaign = app_.add_subcommand("campaign", "Fly many");
    campaign->require_subcommand(0, 1);
    campaign->add_option("file", file_);
    campaign->add_subcommand("replay", "One of them again")->add_option("--row", seed_);
    app_.add_subcommand("bench", "Measure")->add_option("name", file_)->check(OneOf({"render", "servo"}));
  }
  Answer Parse(std::vector<const char*> words) {
    words.insert(words.begin(), "kestrel");
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Answer answer;
    answer.status = ParseCommandLine(app_, static_cast<int>(words.size()), words.data());
    std::fflush(stdout), std::fflush(stderr);
    answer.out = testing::internal::GetCapturedStdout();
    answer.err = testing::internal::GetCapturedStderr();
    return answer;
  }
  CLI::App app_{"", "kestrel"};
  std::string scenario_, file_;
  int seed_ = 0;
};

TEST_F(ParseCommandLineTest, WhatIsRightIsLeftToTheCaller) {
  const Answer answer = Parse({"run", "hover", "--seed", "3"});
  EXPECT_FALSE(answer.status);
  EXPECT_EQ(scenario_, "hover");
  EXPECT_EQ(seed_, 3);
  EXPECT_THAT(answer.out + answer.err, IsEmpty());
}

TEST_F(ParseCommandLineTest, AMisspeltVerbIsAnsweredWithTheNearest) {
  const Answer answer = Parse({"rn", "hover"});
  EXPECT_EQ(answer.status, 2);
  EXPECT_THAT(answer.err, AllOf(HasSubstr("kestrel: there is no verb 'rn'; did you mean 'run'?"),
                                HasSubstr("`kestrel --help`"), Not(HasSubstr("hover"))));
  EXPECT_THAT(Parse({"campaign", "file.yaml", "repaly"}).err,
              HasSubstr("kestrel campaign: there is no verb 'repaly'; did you mean 'replay'?"));
  EXPECT_THAT(Parse({"campaign", "repaly", "file.yaml"}).err,  // which was taken for a file
              HasSubstr("kestrel campaign: there is no verb 'repaly'; did you mean 'replay'?"));
  EXPECT_THAT(Parse({"quack"}).err, HasSubstr("valid: run, campaign"));
  EXPECT_THAT(Parse({"help", "rn"}).err, HasSubstr("kestrel: there is no verb 'rn'; did you mean 'run'?"));
  EXPECT_THAT(Parse({"help", "campaign", "repaly"}).err, HasSubstr("did you mean 'replay'?"));
}

TEST_F(ParseCommandLineTest, AMisspeltOptionIsAnsweredWithTheNearest) {
  for (const std::vector<const char*>& words :
       {std::vector<const char*>{"run", "hover", "--sed", "3"}, {"run", "hover", "--sed=3"}}) {
    const Answer answer = Parse(words);
    EXPECT_EQ(answer.status, 2);
    EXPECT_EQ(answer.err,
              "kestrel run: there is no option '--sed'; did you mean '--seed'?\n`kestrel run --help` tells "
              "more\n");
  }
  EXPECT_THAT(Parse({"campaign", "replay", "--rwo", "3"}).err,
              HasSubstr("kestrel campaign replay: there is no option '--rwo'; did you mean '--row'?"));
  EXPECT_THAT(Parse({"run", "hover", "again"}).err, HasSubstr("kestrel run: 'again' is one word too many"));
  EXPECT_THAT(Parse({"run", "--seed", "3"}).err, HasSubstr("scenario is required; valid: A name"));
}

TEST_F(ParseCommandLineTest, AValueThatIsNoneIsAnsweredWithWhatWouldBe) {
  EXPECT_THAT(Parse({"run", "hover", "--seed", "x"}).err,
              HasSubstr("kestrel run: --seed: 'x' is not valid; valid: a whole number\n"));
  EXPECT_THAT(Parse({"run", "hover", "--seed"}).err,
              HasSubstr("kestrel run: --seed: its value is missing\n"));
  EXPECT_THAT(Parse({"bench", "rendr"}).err, HasSubstr("'rendr' is not valid; did you mean 'render'?"));
  EXPECT_THAT(Parse({"bench", "quack"}).err, HasSubstr("'quack' is not valid; valid: render, servo"));
}

TEST_F(ParseCommandLineTest, WithoutAVerbTheVerbsAreNamed) {
  const Answer answer = Parse({});
  EXPECT_EQ(answer.status, 2);
  EXPECT_THAT(answer.err, HasSubstr("kestrel: a verb is missing; valid: run, campaign"));
}

TEST_F(ParseCommandLineTest, HelpAndVersionAreVerbsToo) {
  EXPECT_EQ(Parse({"version"}).out, "1.2.3\n");
  EXPECT_EQ(Parse({"help"}).out, Parse({"--help"}).out);
  const Answer of_run = Parse({"help", "run"});
  EXPECT_EQ(of_run.status, 0);
  EXPECT_EQ(of_run.out, Parse({"run", "--help"}).out);
  EXPECT_THAT(of_run.out, HasSubstr("--seed"));
}

}  // namespace
}  // namespace kestrel::app
