// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/video/tracking.hpp>
#include <pugixml.hpp>
#include <sstream>
#include <thread>

#include "base/file/model_files.h"
#include "tests/support/content.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// Runs the program in a folder of its own.
class CommandLineTest : public InTemporaryFolder {
 protected:
  Ended Kestrel(const std::string& arguments, const std::string& environment = "") const {
    return Shell(folder_, fmt::format("{} " KESTREL_PROGRAM " {}", environment, arguments));
  }
  std::string Write(const char* name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
};

constexpr char kShort[] = "run pose --no-video --set duration_s=0.5 --set start.settle_s=1 ";

TEST_F(CommandLineTest, ARunThatMeetsItsCriteriaEndsWithZero) {
  const Ended run = Kestrel(std::string(kShort) + "--seed 7 --set criteria='{fix_share: {min: 0.1}}'");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("pose, seed 7: PASSED (completed)"), HasSubstr("fix_share"),
                             HasSubstr("at least 0.1"), HasSubstr("results/runs/pose-7")));
  EXPECT_THAT(run.err, IsEmpty());  // no progress where nobody watches
  const auto summary = nlohmann::json::parse(Content(folder_ / "results/runs/pose-7/summary.json"));
  EXPECT_EQ(summary["seed"], 7);
  EXPECT_EQ(summary["passed"], true);
  EXPECT_EQ(summary["complete"], true);
  EXPECT_FALSE(fs::exists(folder_ / "results/runs/pose-7/video.mp4"));
}

// By the least set, which every machine has.
TEST_F(CommandLineTest, ByAnInstructionSetAllThatChoosesGoesByIt) {
  const Ended run = Kestrel(std::string(kShort) + "--seed 7 --out least --isa ssse3");
  EXPECT_NE(run.status, 2) << run.err;
  const auto least = nlohmann::json::parse(Content(folder_ / "least/summary.json")).at("machine");
  EXPECT_EQ(least.at("instruction_set"), "ssse3");
  EXPECT_EQ(least.at("mathematics"), "sse2");
  EXPECT_THAT(least.at("opencv").get<std::string>(), Not(HasSubstr(" ")));  // no feature beyond its baseline
  // The same by what the environment says.
  Kestrel(std::string(kShort) + "--seed 7 --out again", "KESTREL_ISA=ssse3");
  const auto again = nlohmann::json::parse(Content(folder_ / "again/summary.json"));
  EXPECT_EQ(again.at("machine"), least);
  EXPECT_EQ(again.at("state_hash"),
            nlohmann::json::parse(Content(folder_ / "least/summary.json")).at("state_hash"));
}

TEST_F(CommandLineTest, AnInstructionSetThatThereIsNotIsRefused) {
  for (const char* command : {"run pose", "campaign short.yaml", "tune hover/poor", "bench speed"}) {
    const Ended run = Kestrel(fmt::format("{} --isa mmx", command));
    EXPECT_EQ(run.status, 2) << command;
    EXPECT_THAT(run.err, HasSubstr("--isa: 'mmx' is no instruction set that can be chosen; valid: ssse3"));
  }
}

TEST_F(CommandLineTest, ARunThatMissesThemEndsWithOne) {
  const Ended run =
      Kestrel(std::string(kShort) + "--out here --junit report.xml --set criteria='{fix_share: {max: 0}}'");
  EXPECT_EQ(run.status, 1) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("FAILED: 1 of 1 criteria not met"), HasSubstr("NOT  fix_share")));
  EXPECT_THAT(run.out, Not(HasSubstr("\x1b")));  // colours are for a terminal
  EXPECT_EQ(nlohmann::json::parse(Content(folder_ / "here/summary.json"))["passed"], false);
  pugi::xml_document junit;
  ASSERT_TRUE(junit.load_file((folder_ / "report.xml").c_str()));
  EXPECT_TRUE(junit.select_node("//failure"));
}

TEST_F(CommandLineTest, QuietPrintsNothing) {
  const Ended run =
      Kestrel(std::string(kShort) + "--quiet --out here --set criteria='{fix_share: {min: 0.1}}'");
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.out, IsEmpty());
  EXPECT_THAT(run.err, IsEmpty());
}

TEST_F(CommandLineTest, QuietSaysWhatFailed) {
  const Ended run =
      Kestrel(std::string(kShort) + "--quiet --out here --set criteria='{fix_share: {max: 0}}'");
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.out, IsEmpty());
  EXPECT_THAT(run.err, AllOf(HasSubstr("FAILED: 1 of 1 criteria not met"), HasSubstr("fix_share")));
}

// script(1) gives the program a terminal.
TEST_F(CommandLineTest, ATerminalGetsColoursUnlessNobodyWantsThem) {
  const auto out = [&](const std::string& environment) {
    return Shell(folder_,
                 fmt::format("TERM=xterm {} script -qec '" KESTREL_PROGRAM " {} --out here' /dev/null",
                             environment, kShort))
        .out;
  };
  EXPECT_THAT(out("NO_COLOR="), HasSubstr("\x1b[32mPASSED"));
  EXPECT_THAT(out("NO_COLOR=1"), AllOf(HasSubstr("PASSED"), Not(HasSubstr("\x1b[32m"))));
}

TEST_F(CommandLineTest, TheSeedOfTheCommandLineWins) {
  const Ended run = Kestrel(std::string(kShort) + "--set seed=5 --seed 6 --out here");
  EXPECT_EQ(nlohmann::json::parse(Content(folder_ / "here/summary.json"))["seed"], 6);
}

TEST_F(CommandLineTest, BadInputEndsWithTwoBeforeAnythingIsWritten) {
  const std::string file = Write("bad.yaml", "mission: pose\nwind: {mean_ms: 3}\nduration_s: -1\n");
  for (const char* verb : {"run ", "check "}) {
    const Ended bad = Kestrel(verb + file);
    EXPECT_EQ(bad.status, 2);
    EXPECT_THAT(bad.err, AllOf(HasSubstr("bad.yaml:2: wind.mean_ms: unknown key; did you mean 'mean_m_s'?"),
                               HasSubstr("bad.yaml:3: duration_s: -1")));
    EXPECT_THAT(bad.out, IsEmpty());
  }
  EXPECT_FALSE(fs::exists(folder_ / "results"));
}

TEST_F(CommandLineTest, WrongArgumentsEndWithTwo) {
  for (const char* arguments :
       {"", "fly", "run", "run pose --no-such-option", "run pose --seed x", "run posse", "check none.yaml",
        "run pose --set wind.mean_m_s", "run pose --set wind.mean_m_s=fast", "bench no_such_bench",
        "bench flights --seeds 5..1", "bench flights --jobs 0"}) {
    const Ended wrong = Kestrel(arguments);
    EXPECT_EQ(wrong.status, 2) << arguments;
    EXPECT_THAT(wrong.err, Not(IsEmpty())) << arguments;
  }
  EXPECT_THAT(Kestrel("run landin").err, HasSubstr("did you mean 'landing'?"));
  EXPECT_FALSE(fs::exists(folder_ / "results"));
}

TEST_F(CommandLineTest, AnOutputThatCannotBeWrittenIsRefusedBeforeTheWork) {
  Write("file", "in the way");
  cv::imwrite((folder_ / "grey.png").string(), cv::Mat(480, 640, CV_8UC1, cv::Scalar(77)));
  for (const char* arguments :
       {"run pose --no-video --out file/run", "run pose --no-video --out file", "run pose --out /proc/x",
        "view grey.png --camera thesis_6mm --out none/y.png",
        "calibrate grey.png --model pinhole --out /proc/x", "render-board --camera fisheye --out /proc/x",
        "render-board --camera fisheye --out file", "mirror --out none/mirror.png",
        "bench render --json none/x.json", "bench horizon --out file"}) {
    const Ended refused = Kestrel(arguments);
    EXPECT_EQ(refused.status, 2) << arguments << refused.err;
    EXPECT_THAT(refused.err, HasSubstr(std::string(arguments).ends_with(".json") ? "--json: " : "--out: "))
        << arguments;
  }
  EXPECT_EQ(Content(folder_ / "file"), "in the way");
  // What could be written is not there yet when something else is refused.
  EXPECT_EQ(Kestrel("calibrate none.png --model pinhole --out new/calibration").status, 2);
  EXPECT_FALSE(fs::exists(folder_ / "new"));
}

TEST_F(CommandLineTest, FilesThatAreNotImagesAreRefusedByWhatTheyAre) {
  cv::imwrite((folder_ / "grey.png").string(), cv::Mat(480, 640, CV_8UC1, cv::Scalar(77)));
  Write("cut.png", Content(folder_ / "grey.png").substr(0, 200));
  Write("film.mp4", "x");
  Write("text.txt", "x");
  fs::create_directory(folder_ / "folder");
  const Ended calibrate =
      Kestrel("calibrate grey.png cut.png film.mp4 text.txt folder none.png --model pinhole --out c");
  EXPECT_EQ(calibrate.status, 2);
  EXPECT_THAT(
      calibrate.err,
      AllOf(HasSubstr("cut.png: is a damaged image"), HasSubstr("film.mp4: is a video; valid: images"),
            HasSubstr("text.txt: is not an image"), HasSubstr("folder: is a folder"),
            HasSubstr("none.png: cannot be read: No such file"), Not(HasSubstr("libpng"))));
  const auto viewed = [&](const char* file) {
    return Kestrel(std::string("view ") + file + " --camera thesis_6mm --out out.png").err;
  };
  EXPECT_EQ(viewed("cut.png"), "cut.png: is a damaged image: it breaks off before its end\n");
  EXPECT_EQ(viewed("text.txt"), "text.txt: is neither an image nor a video that can be read\n");
  EXPECT_THAT(viewed("folder"), HasSubstr("folder: is a folder"));
}

TEST_F(CommandLineTest, FilesThatAreNotCamerasAreRefusedByWhatTheyAre) {
  cv::imwrite((folder_ / "grey.png").string(), cv::Mat(480, 640, CV_8UC1, cv::Scalar(77)));
  Write("opencv.xml", "<?xml version=\"1.0\"?>\n<opencv_storage>\n<fx>1</fx></opencv_storage>\n");
  EXPECT_EQ(Kestrel("render-board --camera nosuch --out x").err.rfind("--camera: there is no camera", 0), 0u);
  EXPECT_THAT(Kestrel("render-board --camera grey.png --out x").err, HasSubstr("is not a calibration file"));
  const std::string xml = Kestrel("render-board --camera opencv.xml --out x").err;
  EXPECT_THAT(xml, AllOf(HasSubstr("opencv.xml:1: is not a camera"), Not(HasSubstr("<fx>"))));
  const auto refused = [&](const char* board) {
    Write("board.yaml", board);
    return Kestrel("render-board --camera fisheye --board board.yaml --out x").err;
  };
  EXPECT_THAT(refused("target_type: dots\ntargetCols: 6\nspacingMeters: 0.02\n"),
              AllOf(HasSubstr("board.yaml:1: target_type: 'dots' is not valid; valid: checkerboard"),
                    Not(HasSubstr("targetRows"))));
  EXPECT_EQ(refused("target_type: circlegrid\ntargetCols: 6\nspacingMeters: 0.02\n"),
            "board.yaml:1: targetRows: must be given\nboard.yaml:1: circleDiameter: must be given\n");
}

TEST_F(CommandLineTest, MirrorRefusesFilesThatAreNotWhatTheirNamesSay) {
  const Ended mirror = Kestrel("mirror --out x.txt --camera hyper.png --width-px 0");
  EXPECT_EQ(mirror.status, 2);
  EXPECT_THAT(mirror.err,
              AllOf(HasSubstr("--out: 'x.txt'"), HasSubstr("valid: an ending .png"),
                    HasSubstr("--camera: 'hyper.png'"), HasSubstr("--width-px: 0 is out of range")));
}

TEST_F(CommandLineTest, ARunSaysWhatACheckSays) {
  Write("narrow.yaml",
        "width_px: 640\nheight_px: 480\nfx_px: 800\nfy_px: 800\ncx_px: 319.5\ncy_px: 239.5\nfield_deg: 30\n");
  const std::string run = std::string(kShort) + "--set camera=narrow.yaml --out run ";
  EXPECT_THAT(Kestrel(run).out, HasSubstr("fills 47 % of its image"));
  EXPECT_THAT(Kestrel(run + "--quiet").out, IsEmpty());
}

// gnuplot runs an output whose name begins with a bar.
TEST_F(CommandLineTest, AFolderMayBeCalledAsACommandIs) {
  const std::string folder = "| touch owned # `touch owned` \"x\"";
  const Ended run = Kestrel("run pose --set duration_s=0.6 --set start.settle_s=0.5 --out '" + folder + "'");
  EXPECT_EQ(run.err, "");
  EXPECT_FALSE(fs::exists(folder_ / "owned"));
  EXPECT_TRUE(fs::exists(folder_ / folder / "video.mp4")) << run.out;
  EXPECT_TRUE(fs::exists(folder_ / folder / "plots/position.png")) << run.out;
}

TEST_F(CommandLineTest, AFolderWhoseNameCommandsATerminalIsRefused) {
  const Ended run = Kestrel(std::string(kShort) + "--out \"$(printf 'a\\033[2Jb')\"");
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.err,
              AllOf(HasSubstr("--out: 'a\\x1b[2Jb' holds a control character"), Not(HasSubstr("\x1b"))));
}

TEST_F(CommandLineTest, WhatWasNotReachedIsSaidToBeSo) {
  const Ended run = Kestrel(
      "run landing --set duration_s=0.5 --set start.settle_s=0.5 --out run --set "
      "criteria='{touchdown_error_m: {max: 0.1}}'");
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.out, AllOf(HasSubstr("not reached"), Not(HasSubstr("nan"))));
}

TEST_F(CommandLineTest, TheTruthOfEachFrameIsWrittenWhenAskedFor) {
  EXPECT_EQ(Kestrel(std::string(kShort) + "--truth --out t").status, 0);
  const auto read = [&](const char* name) {
    return cv::imread((folder_ / "t" / "truth" / name).string(), cv::IMREAD_UNCHANGED);
  };
  const cv::Mat image = read("000001_image.png"), depth = read("000001_depth.tiff"),
                geom = read("000001_geom.png");
  ASSERT_EQ(image.size(), cv::Size(640, 480));
  ASSERT_EQ(depth.type(), CV_32F);
  ASSERT_EQ(geom.type(), CV_16U);
  double nearest = 0, farthest = 0;
  cv::minMaxLoc(depth, &nearest, &farthest);
  EXPECT_GT(nearest, 3);  // it hovers at 4.2 m and looks down
  EXPECT_LT(farthest, 12);
  const cv::Mat flow = cv::readOpticalFlow((folder_ / "t" / "truth" / "000001_flow.flo").string());
  ASSERT_EQ(flow.size(), image.size());
  EXPECT_LT(cv::norm(flow.at<cv::Vec2f>(240, 320)), 20);
  EXPECT_FALSE(fs::exists(folder_ / "t" / "truth" / "000010_flow.flo"));  // the last frame goes nowhere
  const std::string geoms = Content(folder_ / "t" / "truth" / "geoms.csv");
  EXPECT_THAT(geoms, HasSubstr("value,name,body"));
  EXPECT_THAT(geoms, HasSubstr(fmt::format("\n{},", geom.at<std::uint16_t>(240, 320))));
}

TEST_F(CommandLineTest, TheSummaryHasWhatScatterDrew) {
  const std::string run = std::string(kShort) + "--no-video --set image.scatter.gain=0.5 --out ";
  EXPECT_LE(Kestrel(run + "one --seed 1").status, 1);
  EXPECT_LE(Kestrel(run + "two --seed 2").status, 1);
  const auto drawn = [&](const char* folder) {
    return nlohmann::json::parse(Content(folder_ / folder / "summary.json"))["drawn"];
  };
  ASSERT_EQ(drawn("one").size(), 1u);
  EXPECT_NEAR(drawn("one")["image.gain"], 1, 0.5);
  EXPECT_NE(drawn("one")["image.gain"], drawn("two")["image.gain"]);
}

TEST_F(CommandLineTest, CheckSaysWhichCameraOfAFileOfKalibrItTook) {
  const auto camera = [](const char* name) {
    return fmt::format(
        "{}:\n  camera_model: pinhole\n  distortion_coeffs: []\n  distortion_model: none\n"
        "  intrinsics: [800, 800, 320, 240]\n  resolution: [640, 480]\n",
        name);
  };
  Write("two.yaml", camera("cam0") + camera("cam1"));
  Write("one.yaml", camera("cam0"));
  EXPECT_THAT(Kestrel("check pose --set camera=two.yaml").out,
              AllOf(HasSubstr("the camera is cam0 of "), HasSubstr("which has cam0, cam1")));
  EXPECT_THAT(Kestrel("check pose --set camera=two.yaml --set camera_name=cam1").out,
              HasSubstr("the camera is cam1 of "));
  EXPECT_EQ(Kestrel("check pose --set camera=two.yaml --set camera_name=cam2").status, 2);
  EXPECT_THAT(Kestrel("check pose --set camera=one.yaml").out, Not(HasSubstr("cam0")));
}

TEST_F(CommandLineTest, AVerbHasNoExamplesOfOthers) {
  EXPECT_THAT(Kestrel("check --help").out,
              AllOf(HasSubstr("kestrel check"), Not(HasSubstr("kestrel bench"))));
  EXPECT_THAT(Kestrel("list --help").out, Not(HasSubstr("kestrel run")));
}

TEST_F(CommandLineTest, AnInterruptEndsWithThreeAndLeavesWhatThereIs) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    execl(KESTREL_PROGRAM, "kestrel", "run", "pose", "--no-video", "--quiet", "--set", "duration_s=3000",
          "--out", (folder_ / "run").c_str(), nullptr);
    _exit(127);
  }
  for (int i = 0; i < 600 && !fs::exists(folder_ / "run/scenario.yaml"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 3);
  const auto summary = nlohmann::json::parse(Content(folder_ / "run/summary.json"));
  EXPECT_EQ(summary["complete"], false);
  EXPECT_EQ(summary["error"], "interrupted");
  EXPECT_TRUE(fs::exists(folder_ / "run/telemetry.csv"));
}

TEST_F(CommandLineTest, TheScenarioOfARunGivesItAgain) {
  EXPECT_LE(Kestrel(std::string(kShort) + "--seed 9 --out first").status, 1);
  EXPECT_LE(Kestrel("run first/scenario.yaml --no-video --out second").status, 1);
  const auto first = nlohmann::json::parse(Content(folder_ / "first/summary.json"));
  const auto second = nlohmann::json::parse(Content(folder_ / "second/summary.json"));
  EXPECT_EQ(first["state_hash"], second["state_hash"]);
  EXPECT_EQ(first["image_hash"], second["image_hash"]);
  EXPECT_EQ(second["seed"], 9);
  EXPECT_EQ(Content(folder_ / "first/telemetry.csv"), Content(folder_ / "second/telemetry.csv"));
}

TEST_F(CommandLineTest, ListShowsTheScenarios) {
  const Ended list = Kestrel("list --json");
  EXPECT_EQ(list.status, 0);
  for (const char* name : {"hover", "landing", "pose", "pose_high", "pelican", "thesis_6mm", "airfield"}) {
    EXPECT_THAT(list.out, HasSubstr(name));
  }
}

TEST_F(CommandLineTest, CheckSaysThatAFileIsValid) {
  const std::string file = Write("good.yaml", "mission: hover\n");
  const Ended check = Kestrel("check " + file);
  EXPECT_EQ(check.status, 0) << check.err;
  EXPECT_THAT(check.out, HasSubstr("good.yaml is valid"));
  EXPECT_EQ(Kestrel("check landing --set flight.blind_m=0.1").status, 0);
  EXPECT_EQ(Kestrel("check landing --set flight.blind_m=10").status, 2);
}

TEST_F(CommandLineTest, CheckSaysWhenTheLensDoesNotFillTheImage) {
  Write("narrow.yaml",
        "width_px: 640\nheight_px: 480\nfx_px: 800\nfy_px: 800\ncx_px: 319.5\ncy_px: 239.5\nfield_deg: 30\n");
  const Ended check = Kestrel("check pose --set camera=narrow.yaml");
  EXPECT_EQ(check.status, 0) << check.err;
  // A circle with a radius of 800 px * tan(15 deg).
  EXPECT_THAT(check.out, AllOf(HasSubstr("fills 47 % of its image"), HasSubstr("15 deg from its axis")));
  EXPECT_THAT(Kestrel("check pose").out, Not(HasSubstr("fills")));
}

TEST_F(CommandLineTest, MirrorDesignsTheThesisMirror) {
  const Ended mirror = Kestrel("mirror --camera mirror.yaml");
  EXPECT_EQ(mirror.status, 0) << mirror.err;
  for (const char* value : {"39.2920", "19.6460", "121.2585", "12.0000", "133.3333", "0.9938"})
    EXPECT_THAT(mirror.out, HasSubstr(value));
  EXPECT_THAT(Content(folder_ / "mirror.yaml"),
              AllOf(HasSubstr("model: unified"), HasSubstr("xi: 0.99380798")));
  EXPECT_EQ(Content(folder_ / "mirror.png").substr(1, 3), "PNG");
}

TEST_F(CommandLineTest, MirrorTakesAnyTwoOfHeightRimAndFocalLength) {
  for (const char* two :
       {"--height-mm 100 --rim-px 240", "--height-mm 100 --focal-mm 12", "--rim-px 240 --focal-mm 12"}) {
    const Ended mirror = Kestrel(std::string("mirror --out '' ") + two);
    EXPECT_EQ(mirror.status, 0) << mirror.err;
    for (const char* value : {"39.2920", "100.0000  mm", "240.0000  px", "12.0000  mm"})
      EXPECT_THAT(mirror.out, HasSubstr(value)) << two;
  }
}

TEST_F(CommandLineTest, AMirrorThatCannotBeIsRefusedWithAReason) {
  const Ended flat = Kestrel("mirror --ratio 5");
  EXPECT_EQ(flat.status, 2);
  EXPECT_THAT(flat.err, AllOf(HasSubstr("no hyperboloid of a / b = 5"), HasSubstr("below 5")));
  EXPECT_THAT(Kestrel("mirror --height-mm 100 --rim-px 240 --focal-mm 13").err,
              AllOf(HasSubstr("--focal-mm"), HasSubstr("need 12")));
  EXPECT_THAT(Kestrel("mirror --ratio -5 --pixel-um 0").err,
              AllOf(HasSubstr("--ratio"), HasSubstr("--pixel-um")));
  EXPECT_EQ(Kestrel("mirror --out nowhere/mirror.png").status, 2);
  EXPECT_TRUE(!fs::exists(folder_ / "mirror.png"));
}

TEST_F(CommandLineTest, HelpShowsExamplesAndTheExitStatus) {
  const Ended help = Kestrel("--help");
  EXPECT_EQ(help.status, 0);
  EXPECT_THAT(help.out, AllOf(HasSubstr("kestrel run landing"), HasSubstr("Exit status"), HasSubstr("bench"),
                              HasSubstr("check")));
  const Ended run = Kestrel("run --help");
  EXPECT_EQ(run.status, 0);
  for (const char* option : {"--seed", "--set", "--out", "--no-video", "--junit", "--quiet"})
    EXPECT_THAT(run.out, HasSubstr(option));
  EXPECT_EQ(Kestrel("--version").status, 0);
}

TEST_F(CommandLineTest, BrokenModelsUnderAnotherRootAreRefused) {
  const fs::path root = Root();
  for (const char* part : {"models", "scenarios"})
    fs::copy(root / part, folder_ / part, fs::copy_options::recursive);
  const std::string here = "KESTREL_ROOT=" + folder_.string();
  EXPECT_EQ(Kestrel("check pose", here).status, 0);
  fs::remove(folder_ / "models/vehicles/pelican/pelican.xml");
  const Ended broken = Kestrel("run pose", here);
  EXPECT_EQ(broken.status, 2);
  EXPECT_THAT(broken.err, HasSubstr((folder_ / "models/vehicles/pelican/pelican.xml").string()));
  fs::remove_all(folder_ / "models/cameras");
  EXPECT_THAT(Kestrel("run pose", here).err, HasSubstr("no camera 'thesis_6mm'"));
}

}  // namespace
}  // namespace kestrel::app
