// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/piped_process.h"
#include "geometry/tait_bryan.h"
#include "records/recorder.h"
#include "records/summary.h"
#include "records/video/video.h"
#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"
#include "vision/write_image.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class Folder : public InTemporaryFolder {
 protected:
  std::vector<std::string> Files() const {
    std::vector<std::string> files;
    for (const auto& each : fs::recursive_directory_iterator(folder_)) {
      if (each.is_regular_file()) files.push_back(fs::relative(each.path(), folder_).string());
    }
    return files;
  }
};

using PartFileTest = Folder;
using PipedProgramTest = Folder;
using VideoTest = Folder;
using RecorderTest = Folder;

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',')
      cells.emplace_back();
    else
      cells.back() += c;
  }
  return cells;
}

// A cell of a line of telemetry by the name of its column.
std::string Cell(const records::LogRow& row, const std::string& column) {
  const auto names = Cells(records::TelemetryHeader()), cells = Cells(records::TelemetryLine(row));
  EXPECT_EQ(names.size(), cells.size());
  const auto found = std::find(names.begin(), names.end(), column);
  if (found == names.end()) return "no such column";
  return cells.at(found - names.begin());
}

std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "nothing thrown";
}

records::LogRow RowAt(double t_s) {
  records::LogRow row;
  row.sequence = static_cast<std::int64_t>(t_s * 30);
  row.exposure.t_s = t_s;
  row.now.t_s = t_s + 0.1;
  for (Truth* truth : {&row.exposure, &row.now}) {
    truth->X_NT = {HeadingRotation(Radians(90)), {10, 20, 0}};
    truth->X_NB = {HeadingRotation(Radians(100)), {10.5 - 0.1 * t_s, 19, -4}};
  }
  row.estimate.p_NB = row.now.X_NB.p + Eigen::Vector3d(0.2, 0, 0);
  row.decision.phase = t_s < 1 ? "search" : "descend";
  row.decision.target = "tracked";
  row.decision.fix = mission::TargetFix{{-1, -0.5, -4}, Radians(9), 30, 0.5, 1, true};
  return row;
}

records::Summary Passed() {
  records::Summary summary;
  summary.scenario = "land";
  summary.complete = summary.passed = true;
  return summary;
}

TEST_F(PartFileTest, AFileHasItsNameOnlyOnceItIsComplete) {
  const fs::path file = folder_ / "a.txt";
  {
    PartFile part(file);
    part.Write("one");
    EXPECT_THAT(Files(), ElementsAre("a.txt.part"));
    part.Close();
  }
  EXPECT_THAT(Files(), ElementsAre("a.txt"));
  EXPECT_EQ(Content(file), "one");
  { PartFile left(folder_ / "b.txt"); }
  EXPECT_THAT(Files(), UnorderedElementsAre("a.txt", "b.txt.part"));
  WriteFile(file, "two");
  EXPECT_EQ(Content(file), "two");
}

TEST_F(PartFileTest, AFailureNamesTheFileAndTheReason) {
  EXPECT_EQ(MessageOf([] { WriteFile("/nowhere/a.txt", ""); }),
            "cannot write /nowhere/a.txt: No such file or directory");
  fs::create_symlink("/dev/full", folder_ / "a.txt.part");  // a device that is always full
  EXPECT_THAT(MessageOf([&] { WriteFile(folder_ / "a.txt", "one"); }),
              AllOf(HasSubstr("a.txt: No space left on device")));
  EXPECT_THAT(Files(), IsEmpty());  // of a whole file nothing stays behind
}

// A disk on which files end at so many bytes.
class FullDisk {
 public:
  explicit FullDisk(std::uintmax_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    signal_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit now{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &now);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signal_);
  }

 private:
  rlimit before_{};
  void (*signal_)(int) = nullptr;
};

TEST_F(PartFileTest, AnImageIsWholeOrHasNotItsName) {
  cv::Mat image(60, 80, CV_8UC3);
  cv::randu(image, 0, 255);
  vision::WriteImage(folder_ / "whole.png", image);
  EXPECT_EQ(cv::norm(cv::imread((folder_ / "whole.png").string()), image, cv::NORM_INF), 0);
  {
    const FullDisk disk(fs::file_size(folder_ / "whole.png") - 1);
    EXPECT_THAT(MessageOf([&] { vision::WriteImage(folder_ / "cut.png", image); }),
                HasSubstr("cut.png: File too large"));
  }
  EXPECT_THAT(MessageOf([&] { vision::WriteImage(folder_ / "image.none", image); }),
              HasSubstr("image.none: it cannot be encoded so"));
  EXPECT_THAT(Files(), ElementsAre("whole.png"));
}

TEST_F(VideoTest, IsAFailureWhereTheDiskIsFullAtItsVeryEnd) {
  const auto film = [&](const char* name) {
    records::Video video(folder_ / name, 25);
    for (int i = 0; i < 20; ++i) video.Write(cv::Mat(64, 64, CV_8UC3, cv::Scalar::all(i)));
    video.Close();
  };
  film("whole.mp4");
  {
    const FullDisk disk(fs::file_size(folder_ / "whole.mp4") - 1);
    EXPECT_THAT(MessageOf([&] { film("cut.mp4"); }),
                AllOf(HasSubstr("cut.mp4: ffmpeg gave up"), HasSubstr("File too large")));
  }
  EXPECT_FALSE(fs::exists(folder_ / "cut.mp4"));
}

TEST_F(PartFileTest, ADeviceIsNotReplacedByAFile) {
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  Mistakes mistakes;
  CheckWritableFile(folder_ / "pipe", "--json", mistakes);
  CheckWritableFile(folder_ / "a.txt", "--json", mistakes);
  EXPECT_THAT(mistakes.Texts(), ElementsAre(HasSubstr("pipe' cannot be written: it is a device or a pipe")));
}

TEST_F(PartFileTest, AfterAFailedWriteTheFileIsNeverGivenItsName) {
  fs::create_symlink("/dev/full", folder_ / "a.txt.part");
  PartFile file(folder_ / "a.txt");
  EXPECT_THAT(MessageOf([&] { file.Write(std::string(1 << 20, 'x')); }), HasSubstr("No space left"));
  EXPECT_THAT(MessageOf([&] { file.Close(); }), HasSubstr("cannot write"));
  EXPECT_FALSE(fs::exists(folder_ / "a.txt"));
}

TEST_F(PipedProgramTest, GetsEveryByteAndItsFailureIsToldInItsOwnWords) {
  std::string bytes(3'000'000, 'k');
  for (std::size_t i = 0; i < bytes.size(); i += 997) bytes[i] = static_cast<char>(i);
  PipedProcess copy({"dd", "status=none", "bs=64k", "iflag=fullblock", "of=" + (folder_ / "copy").string()});
  copy.Write(bytes);
  copy.Close();
  EXPECT_EQ(Content(folder_ / "copy"), bytes);

  EXPECT_EQ(MessageOf([] { PipedProcess({"no-such-program"}); }),
            "the program no-such-program is not installed: install the package that has it");
  PipedProcess fails({"sh", "-c", "echo first >&2; echo the reason >&2; exit 5"});
  EXPECT_EQ(MessageOf([&] { fails.Close(); }), "sh gave up with status 5: the reason");
  PipedProcess killed({"sh", "-c", "kill -9 $$"});
  EXPECT_EQ(MessageOf([&] { killed.Close(); }), "sh was ended by signal 9");
}

TEST_F(PipedProgramTest, ADeadProgramIsAnErrorAndNoSignal) {
  PipedProcess dead({"sh", "-c", "exec <&-; echo gone >&2; exit 1"});
  EXPECT_EQ(MessageOf([&] {
              for (int i = 0; i < 1000; ++i) dead.Write(std::string(100'000, 'x'));
            }),
            "sh gave up with status 1: gone");
  EXPECT_THAT(MessageOf([&] { dead.Close(); }), HasSubstr("gone"));
  PipedProcess early({"true"});
  EXPECT_THAT(MessageOf([&] {
                for (int i = 0; i < 1000; ++i) early.Write(std::string(100'000, 'x'));
              }),
              HasSubstr("true gave up"));
  EXPECT_THAT(MessageOf([&] { early.Close(); }), HasSubstr("true gave up"));
}

TEST_F(VideoTest, IsAPlayableFileThatHasItsNameOnlyAtTheEnd) {
  records::Video video(folder_ / "video.mp4", 25);
  const cv::Mat wide(61, 163, CV_8UC3, cv::Scalar(10, 200, 30));
  const cv::Mat part = wide(cv::Rect(1, 0, 161, 61));  // rows that do not follow one another, and an odd size
  for (int i = 0; i < 20; ++i) video.Write(part);
  EXPECT_FALSE(fs::exists(folder_ / "video.mp4"));
  video.Close();
  EXPECT_THAT(Files(), ElementsAre("video.mp4"));
  const std::string bytes = Content(folder_ / "video.mp4");
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));  // the index first, so that it plays while it loads
  EXPECT_NE(bytes.find("avc1"), std::string::npos);

  const std::string picture = (folder_ / "first.png").string();
  PipedProcess decode(
      {"ffmpeg", "-loglevel", "error", "-i", (folder_ / "video.mp4").string(), "-frames:v", "1", picture});
  decode.Close();
  const cv::Mat first = cv::imread(picture);
  ASSERT_EQ(first.size(), cv::Size(162, 62));
  const cv::Vec3b pixel = first.at<cv::Vec3b>(30, 80);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(pixel[i], (cv::Vec3b(10, 200, 30))[i], 6);
}

TEST_F(VideoTest, AFailureNamesTheFileAndWhatFfmpegSaid) {
  records::Video video(folder_ / "none" / "video.mp4", 25);
  const std::string message = MessageOf([&] {
    for (int i = 0; i < 20; ++i) video.Write(cv::Mat::zeros(64, 64, CV_8UC3));
    video.Close();
  });
  EXPECT_THAT(message, AllOf(HasSubstr("cannot write"), HasSubstr("video.mp4: ffmpeg gave up"),
                             HasSubstr("No such file or directory")));
  records::Video changing(folder_ / "video.mp4", 25);
  changing.Write(cv::Mat::zeros(64, 64, CV_8UC3));
  EXPECT_THAT(MessageOf([&] { changing.Write(cv::Mat::zeros(32, 64, CV_8UC3)); }),
              HasSubstr("a frame of 64x32 px follows frames of 64x64 px"));
}

TEST(Telemetry, SaysTruthFixAndTheTruthOfTheFixEachInItsFrame) {
  // The pad lies at (10, 20) turned by 90 degrees: its x is east, its y south. The aircraft, at (10.5, 19),
  // is 1 m before it and 0.5 m to its left.
  const records::LogRow row = RowAt(0);
  EXPECT_EQ(Cell(row, "truth_x_m"), "10.5");
  EXPECT_EQ(Cell(row, "truth_y_m"), "19");
  EXPECT_EQ(Cell(row, "truth_z_m"), "-4");
  EXPECT_NEAR(std::stod(Cell(row, "truth_yaw_deg")), 100, 1e-6);
  EXPECT_NEAR(std::stod(Cell(row, "target_x_m")), -1, 1e-8);
  EXPECT_NEAR(std::stod(Cell(row, "target_y_m")), -0.5, 1e-8);
  EXPECT_NEAR(std::stod(Cell(row, "target_yaw_deg")), 10, 1e-6);
  EXPECT_EQ(Cell(row, "fix_x_m"), "-1");
  EXPECT_NEAR(std::stod(Cell(row, "fix_yaw_deg")), 9, 1e-6);
  EXPECT_EQ(Cell(row, "fix_registered"), "1");
  EXPECT_EQ(Cell(row, "t_s"), "0.1");
  EXPECT_EQ(Cell(row, "exposure_t_s"), "0");
  EXPECT_EQ(Cell(row, "phase"), "search");
  EXPECT_EQ(Cell(row, "estimate_x_m"), "10.7");
}

TEST(Telemetry, WhatThereIsNotIsAnEmptyCell) {
  records::LogRow row = RowAt(0);
  row.decision.fix.reset();
  EXPECT_EQ(Cell(row, "fix_x_m"), "");
  EXPECT_EQ(Cell(row, "fix_inliers"), "");
  EXPECT_EQ(Cell(row, "setpoint_vx_m_s"), "");
  row.decision.setpoint = control::VelocitySetpoint{{1, 2, 3}, Radians(45)};
  EXPECT_EQ(Cell(row, "setpoint_vy_m_s"), "2");
  EXPECT_EQ(Cell(row, "setpoint_yaw_rate_deg_s"), "45");
  EXPECT_EQ(Cell(row, "setpoint_x_m"), "");
  row.decision.setpoint = control::PositionSetpoint{{1, 2, 3}, Radians(-30)};
  EXPECT_EQ(Cell(row, "setpoint_z_m"), "3");
  EXPECT_EQ(Cell(row, "setpoint_yaw_deg"), "-30");
  EXPECT_EQ(Cell(row, "setpoint_vx_m_s"), "");
  row.decision.setpoint = control::AttitudeSetpoint{Radians(4), Radians(-5), Radians(6), 0.5};
  EXPECT_EQ(Cell(row, "setpoint_roll_deg"), "4");
  EXPECT_EQ(Cell(row, "setpoint_pitch_deg"), "-5");
  EXPECT_EQ(Cell(row, "setpoint_yaw_rate_deg_s"), "6");
  EXPECT_EQ(Cell(row, "setpoint_thrust"), "0.5");
}

TEST(Telemetry, HasNoTimesOfTheProcessor) {
  records::LogRow row = RowAt(0);
  const std::string before = records::TelemetryLine(row);
  row.decision.vision_s = 0.01, row.decision.control_s = 0.02;
  EXPECT_EQ(records::TelemetryLine(row), before);
}

TEST_F(RecorderTest, LeavesAWholeFolderAfterAWholeRun) {
  for (const char* old : {"summary.json", "video.mp4", "telemetry.csv.part"})
    std::ofstream(folder_ / old) << "old";
  records::Recorder recorder(folder_, {true, 30, {"it's `land`, seed 1", Eigen::Vector2d(1.19, 0.91)}});
  EXPECT_THAT(Files(), ElementsAre("telemetry.csv.part"));
  ASSERT_TRUE(recorder.wants_images());
  for (int i = 0; i < 60; ++i) {
    recorder.Write(RowAt(i / 30.0));
    recorder.WriteImage(cv::Mat::zeros(48, 64, CV_8UC3));
  }
  const records::Summary summary = recorder.Finish(Passed());
  EXPECT_TRUE(summary.complete) << summary.error;
  EXPECT_TRUE(summary.passed);
  EXPECT_THAT(Files(), UnorderedElementsAre("summary.json", "telemetry.csv", "video.mp4",
                                            "plots/position.png", "plots/error.png", "plots/trajectory.png"));
  const std::string telemetry = Content(folder_ / "telemetry.csv");
  EXPECT_EQ(std::count(telemetry.begin(), telemetry.end(), '\n'), 61);
  EXPECT_EQ(records::ReadSummary(folder_ / "summary.json").scenario, "land");
  for (const char* name : {"position.png", "error.png", "trajectory.png"}) {
    cv::Mat gray = cv::imread((folder_ / "plots" / name).string(), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(gray.empty()) << name;
    EXPECT_GT(cv::countNonZero(gray < 128), 2000) << name;  // something is drawn
  }
}

TEST_F(RecorderTest, ARunWithoutFixOrMotionIsDrawnToo) {
  records::Recorder recorder(folder_, {false, 30, {"", Eigen::Vector2d(1.19, 0.91)}});
  EXPECT_FALSE(recorder.wants_images());
  records::LogRow row;
  recorder.Write(row);
  const records::Summary summary = recorder.Finish(Passed());
  EXPECT_TRUE(summary.complete) << summary.error;
  EXPECT_TRUE(fs::exists(folder_ / "plots/error.png"));
}

TEST_F(RecorderTest, ARunThatBrokeOffLeavesWhatItHadAndSaysSo) {
  records::Recorder recorder(folder_, {true, 30, {}});
  records::Summary summary;
  summary.error = "the world came to an end";
  recorder.Finish(summary);
  EXPECT_THAT(Files(), UnorderedElementsAre("summary.json", "telemetry.csv"));
  const records::Summary read = records::ReadSummary(folder_ / "summary.json");
  EXPECT_FALSE(read.complete);
  EXPECT_EQ(read.error, "the world came to an end");
}

TEST_F(RecorderTest, WhatCannotBeWrittenMakesTheRunOneThatBrokeOff) {
  records::Recorder recorder(folder_, {true, 30, {}});
  recorder.Write(RowAt(0));
  fs::remove(folder_ / "telemetry.csv.part");  // as if someone had cleaned up
  fs::remove_all(folder_ / "plots");
  const records::Summary summary = recorder.Finish(Passed());
  EXPECT_FALSE(summary.complete);
  EXPECT_FALSE(summary.passed);
  EXPECT_THAT(summary.error, AllOf(HasSubstr("telemetry.csv: No such file"), HasSubstr("; cannot draw")));
  EXPECT_FALSE(records::ReadSummary(folder_ / "summary.json").complete);
  EXPECT_THAT(Files(), ElementsAre("summary.json"));
}

TEST_F(RecorderTest, AFolderThatCannotBeIsRefusedAtOnce) {
  std::ofstream(folder_ / "file") << "x";
  EXPECT_THAT(MessageOf([&] { records::Recorder(folder_ / "file", {}); }),
              HasSubstr("cannot write " + (folder_ / "file").string()));
}

}  // namespace
}  // namespace kestrel::flight
