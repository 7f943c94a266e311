// SPDX-License-Identifier: Apache-2.0
// Names that are commands: to a shell, to gnuplot, ffmpeg and GNU parallel, to a terminal, to a browser, to a
// spreadsheet. They are names, or they are refused.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/attack/limited_program.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kCampaign[] = "scenario: pose\nset: [duration_s=1.3, start.settle_s=0.5]\nruns: 2\n";

// A control character other than the end of a line, as a terminal would take it.
bool CommandsTerminal(const std::string& text) {
  return std::any_of(text.begin(), text.end(),
                     [](unsigned char c) { return (c < 0x20 && c != '\n') || c == 0x7f; });
}

class NamesTest : public InTemporaryFolder {
 protected:
  Taken Kestrel(std::vector<std::string> words) const {
    words.insert(words.begin(), KESTREL_PROGRAM);
    return RunLimited(folder_, words);
  }
  // Every attack here would leave a file of that name, somewhere.
  void ExpectNothingRan(const std::string& by) const {
    for (const auto& each : fs::recursive_directory_iterator(folder_))
      EXPECT_NE(each.path().filename(), "owned") << by << ": " << each.path();
  }
  // A script by a shell, with a program that does nothing in place of ours.
  void RunScript(const std::string& shell, std::string script) const {
    for (std::size_t at; (at = script.find(KESTREL_PROGRAM)) != std::string::npos;)
      script.replace(at, std::string(KESTREL_PROGRAM).size(), "true");
    std::ofstream(folder_ / "go.sh") << script;
    Shell(folder_, "timeout 30 " + shell + " go.sh");
  }
};

// Each a command to one of them at least.
const std::vector<std::string> kHostile = {"| touch owned # `touch owned` $(touch owned)",
                                           "x'\"; touch owned; '`touch owned`",
                                           "{= system(q(touch owned)) =}", "-f concat:a|b %d"};

TEST_F(NamesTest, ToGnuplotAndFfmpegAFoldersNameIsAName) {
  for (const std::string& name : kHostile) {
    const Taken run = Kestrel({"run", "pose", "--set", "duration_s=1.3", "--set", "start.settle_s=0.5",
                               "--quiet", "--out=" + name});
    EXPECT_LE(run.status, 1) << name << ": " << run.output;
    EXPECT_GE(run.status, 0) << name << ": " << run.output;
    EXPECT_TRUE(fs::exists(folder_ / name / "video.mp4")) << name;
    EXPECT_TRUE(fs::exists(folder_ / name / "plots/position.png")) << name;
    ExpectNothingRan(name);
  }
}

TEST_F(NamesTest, ToFfmpegAVideosNameIsAName) {
  ASSERT_EQ(
      Shell(folder_, "ffmpeg -loglevel error -f lavfi -i testsrc=duration=0.2:size=640x480:rate=21 in.mp4")
          .status,
      0);
  for (const std::string& name : kHostile) {
    const std::string video = name + ".mp4", out = "out " + name + ".mp4";
    fs::copy_file(folder_ / "in.mp4", folder_ / video);
    const Taken view = Kestrel({"view", "--camera", "fisheye", "--out=" + out, "--", video});
    EXPECT_EQ(view.status, 0) << name << ": " << view.output;
    EXPECT_TRUE(fs::exists(folder_ / out)) << name;
    ExpectNothingRan(name);
  }
}

TEST_F(NamesTest, WordsThatCommandATerminalAreRefusedByEveryVerb) {
  const std::string word = "a\x1b]0;owned\a\ntouch owned #";
  const std::vector<std::vector<std::string>> all = {
      {word},
      {"--" + word},
      {"run", word},
      {"run", "pose", "--out", word},
      {"run", "pose", "--set", "name=" + word},
      {"run", "pose", "--junit", word},
      {"run", "pose", "--seed", word},
      {"check", word},
      {"serve", word, "--asctec"},
      {"serve", "hover", "--asctec", "--out", word},
      {"encounters", "--out", word},
      {"campaign", word},
      {"campaign", "c.yaml", "--out", word},
      {"campaign", "replay", word, "0"},
      {"campaign", "merge", "c.yaml", word},
      {"campaign", "report", word},
      {"campaign", "compare", word, word},
      {"campaign", "slurm", word, "--tasks", "2"},
      {"campaign", "parallel", word, "--tasks", "2"},
      {"campaign", "parallel", "c.yaml", "--tasks", "2", "--out", word},
      {"tune", word},
      {"bench", word},
      {"replay", word},
      {"mirror", "--camera", word},
      {"view", word, "--camera", "fisheye", "--out", "x.png"},
      {"horizon", word, "--camera", "fisheye"},
      {"calibrate", word, "--model", "pinhole", "--out", "c"},
      {"render-board", "--out", word}};
  std::ofstream(folder_ / "c.yaml") << kCampaign;
  for (const std::vector<std::string>& words : all) {
    const Taken taken = Kestrel(words);
    EXPECT_EQ(taken.status, 2) << words.front() << ' ' << taken.output;
    EXPECT_THAT(taken.output, HasSubstr("holds a control character")) << words.front();
    EXPECT_FALSE(CommandsTerminal(taken.output)) << words.front();
  }
  for (const char* each : {"a\x01", "a\x7f", "a\tb",
                           "a\xc2\x9b"
                           "31m"})
    EXPECT_EQ(Kestrel({"check", each}).status, 2);
  EXPECT_EQ(Kestrel({"check", "n\xc3\xb6", "\xff"}).output.find('\xff'), std::string::npos);
}

TEST_F(NamesTest, NoNameOfACampaignIsRunByItsScripts) {
  for (const char* name : {"x\\ntouch owned #", "x\\e[2J"}) {
    std::ofstream(folder_ / "named.yaml") << "name: \"" << name << "\"\n" << kCampaign;
    for (const char* verb : {"slurm", "parallel"}) {
      const Taken refused = Kestrel({"campaign", verb, "named.yaml", "--tasks", "2"});
      EXPECT_EQ(refused.status, 2) << verb;
      EXPECT_THAT(refused.output, AllOf(HasSubstr("name: "), HasSubstr("no control character"))) << verb;
    }
  }
  const bool has_parallel = Shell(folder_, "command -v parallel").status == 0;
  for (const std::string& name : kHostile) {
    if (name.find('"') == std::string::npos)
      std::ofstream(folder_ / "c.yaml") << "name: \"" << name << "\"\n" << kCampaign;
    else
      std::ofstream(folder_ / "c.yaml") << kCampaign;
    fs::create_directory(folder_ / name);
    fs::copy_file(folder_ / "c.yaml", folder_ / name / "c.yaml");
    for (const std::string verb : {"slurm", "parallel"}) {
      const Taken printed =
          Kestrel({"campaign", verb, "./" + name + "/c.yaml", "--tasks", "2", "--out=./" + name});
      ASSERT_EQ(printed.status, 0) << name << ": " << printed.output;
      for (const std::string shell : {"sh", "bash"}) {
        // Slurm's is of bash by its first line; and without parallel its line does nothing.
        if (verb == "slurm" ? shell == "sh" : !has_parallel) continue;
        RunScript(shell, printed.output);
        ExpectNothingRan(verb + " by " + shell + ": " + name);
      }
    }
    const Taken by_name = Kestrel({"campaign", "parallel", "c.yaml", "--tasks", "2"});  // whose folder it is
    ASSERT_EQ(by_name.status, 0) << name << ": " << by_name.output;
    RunScript("sh", by_name.output);
    ExpectNothingRan("parallel: " + name);
  }
}

// The working folder reaches a script too, and no word of the command line names it. What is right within
// $'...' for bash ends the quotes for dash.
TEST_F(NamesTest, AWorkingFolderThatWouldEndALineOfAScriptIsRefused) {
  for (const char* name : {"d\n';touch owned;'", "d\ntouch owned #", "d\x1b[2J"}) {
    const fs::path folder = folder_ / name;
    fs::create_directory(folder);
    std::ofstream(folder / "c.yaml") << kCampaign;
    for (const char* verb : {"slurm", "parallel"}) {
      const Taken taken = RunLimited(folder, {KESTREL_PROGRAM, "campaign", verb, "c.yaml", "--tasks", "2"});
      EXPECT_EQ(taken.status, 2) << verb;
      EXPECT_THAT(taken.output,
                  AllOf(HasSubstr("the working folder: '"), HasSubstr("holds a control character")))
          << verb;
      EXPECT_FALSE(CommandsTerminal(taken.output)) << verb;
    }
    // As its help says: | sh
    RunLimited(
        folder,
        {"/bin/sh", "-c",
         fmt::format(
             "{0} campaign parallel c.yaml --tasks 2 --out ../out 2>/dev/null | sed 's#{0}#true#g' | sh",
             KESTREL_PROGRAM)});
    ExpectNothingRan(name);
  }
}

// Results that somebody sent, in every word of theirs that is shown.
TEST_F(NamesTest, ForeignResultsAreShownAsText) {
  if (Shell(folder_, "command -v sqlite3").status != 0) GTEST_SKIP() << "needs the program sqlite3";
  std::ofstream(folder_ / "c.yaml") << kCampaign;
  const Taken flown =
      Kestrel({"campaign", "c.yaml", "--jobs", "1", "--record-failures", "0", "--out", "sent"});
  ASSERT_TRUE(fs::exists(folder_ / "sent/results.sqlite")) << flown.output;
  const std::string script = "<script>owned</script>";
  fs::create_directories(folder_ / "sent/javascript:alert(1)");
  std::ofstream(folder_ / "edit.sql")
      << "UPDATE runs SET outcome = '=cmd|' || char(27) || '[2J' WHERE row = 0;\n"
      << "UPDATE runs SET outcome = '=HYPERLINK(\"http://owned\")</script>" << script << "' WHERE row = 1;\n"
      << "UPDATE execution SET recording = 'javascript:alert(1)', log = '" << script
      << "' || char(27) || '[2J';\n"
      << "UPDATE campaign SET value = 'x' || char(27) || '[2J</title>" << script << "' WHERE key = 'name';\n"
      << "UPDATE origin SET value = char(27) || '" << script << "' WHERE key = 'file';\n";
  const Ended edited = Shell(folder_, "sqlite3 sent/results.sqlite < edit.sql");
  ASSERT_EQ(edited.status, 0) << edited.err;
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"campaign", "report", "sent"},
        {"campaign", "compare", "sent", "sent"},
        {"campaign", "replay", "c.yaml", "0", "--no-video", "--out", "sent"},
        {"campaign", "c.yaml", "--out", "sent"}}) {
    const Taken taken = Kestrel(words);
    EXPECT_GE(taken.status, 0) << words[1] << taken.output;
    EXPECT_FALSE(CommandsTerminal(taken.output)) << words[1] << taken.output;
  }
  // From within, where the name is one of a folder that is there.
  const Taken report =
      RunLimited(folder_ / "sent", {KESTREL_PROGRAM, "campaign", "report", "results.sqlite"});
  ASSERT_EQ(report.status, 0) << report.output;
  const std::string page = Content(folder_ / "sent/report.html");
  EXPECT_TRUE(page.find("\"./javascript:alert(1)\"") != std::string::npos);  // a path within the folder
  for (const std::string& never : {std::string("\"javascript:"), script, std::string("\x1b")})
    EXPECT_TRUE(page.find(never) == std::string::npos) << never.substr(1);
  const std::string table = Content(folder_ / "sent/runs.csv");
  EXPECT_THAT(table, AllOf(HasSubstr("'=cmd|"), HasSubstr("\"'=HYPERLINK"), Not(HasSubstr(",=")),
                           Not(HasSubstr(",\"=")), Not(HasSubstr("\x1b"))));
}

}  // namespace
}  // namespace kestrel
