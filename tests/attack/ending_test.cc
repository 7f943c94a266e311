// SPDX-License-Identifier: Apache-2.0
// How the program ends: terminals that go, two that write to one folder, disks that are full. What it leaves
// is whole or has not its name, and its status says what became of it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/inotify.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kEndless[] = "run pose --no-video --set duration_s=3000 --out run";
constexpr char kShort[] = "run pose --set duration_s=0.5 --set start.settle_s=1 --out run ";

void WaitFor(const fs::path& file) {
  for (int i = 0; i < 6000 && !fs::exists(file); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_TRUE(fs::exists(file)) << file;
}

int StatusOf(pid_t child) {
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

class EndingTest : public InTemporaryFolder {
 protected:
  Ended Kestrel(const std::string& arguments) const {
    return Shell(folder_, fmt::format("{} {}", KESTREL_PROGRAM, arguments));
  }
  // Files end at so many blocks of 512 bytes, as on a disk that is full.
  Ended KestrelOnAFullDisk(std::uintmax_t blocks, const std::string& arguments) const {
    return Shell(folder_,
                 fmt::format("trap '' XFSZ; ulimit -f {}; {} {}", blocks, KESTREL_PROGRAM, arguments));
  }
  // Within a shell, in the folder; what it says goes to said.txt. It is this process's child.
  pid_t Start(const std::string& arguments, const std::string& before = "true") const {
    const std::string command = fmt::format("cd {} && {} && exec {} {} >said.txt 2>&1 </dev/null",
                                            folder_.string(), before, KESTREL_PROGRAM, arguments);
    const pid_t child = fork();
    if (child == 0) {
      execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      _exit(127);
    }
    return child;
  }
};

TEST_F(EndingTest, AHangUpEndsARunWithItsRecord) {
  const pid_t child = Start(kEndless);
  WaitFor(folder_ / "run/scenario.yaml");
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  kill(child, SIGHUP);
  kill(child, SIGHUP);  // as terminals do: it is not the second word of somebody who waits
  EXPECT_EQ(StatusOf(child), 3);
  EXPECT_THAT(Content(folder_ / "run/summary.json"), HasSubstr("\"error\": \"interrupted\""));
  EXPECT_TRUE(fs::exists(folder_ / "run/telemetry.csv"));
}

TEST_F(EndingTest, ATerminalThatIsClosedEndsARunWithItsRecord) {
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(child, 0);
  if (child == 0) {
    const std::string out = (folder_ / "run").string();
    execl(KESTREL_PROGRAM, "kestrel", "run", "pose", "--no-video", "--set", "duration_s=3000", "--out",
          out.c_str(), nullptr);
    _exit(127);
  }
  WaitFor(folder_ / "run/scenario.yaml");
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  close(terminal);  // what it prints from now on cannot be written
  EXPECT_EQ(StatusOf(child), 3);
  EXPECT_THAT(Content(folder_ / "run/summary.json"), HasSubstr("\"error\": \"interrupted\""));
}

TEST_F(EndingTest, UnderNohupAHangUpIsOfNoMatter) {
  const pid_t child = Start(std::string(kShort) + "--no-video --set duration_s=3", "trap '' HUP");
  WaitFor(folder_ / "run/scenario.yaml");
  kill(child, SIGHUP);
  EXPECT_LE(StatusOf(child), 1);
  EXPECT_THAT(Content(folder_ / "run/summary.json"), HasSubstr("\"complete\": true"));
}

TEST_F(EndingTest, AHangUpEndsAServedFlightWithItsRecord) {
  const pid_t child = Start("serve hover --asctec --out run");
  WaitFor(folder_ / "run/scenario.yaml");
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  kill(child, SIGHUP);
  EXPECT_LE(StatusOf(child), 3) << Content(folder_ / "said.txt");
  EXPECT_TRUE(fs::exists(folder_ / "run/summary.json")) << Content(folder_ / "said.txt");
}

TEST_F(EndingTest, AHangUpEndsACampaignThatGoesOnLater) {
  std::ofstream(folder_ / "long.yaml") << "scenario: pose\nset: [duration_s=0.5]\nruns: 5000\n"
                                          "vary:\n  start.height_m: {uniform: [3, 6]}\n";
  const pid_t child = Start("campaign long.yaml --jobs 1 --out here --record-failures 0");
  WaitFor(folder_ / "here/results.sqlite");
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  kill(child, SIGHUP);
  EXPECT_EQ(StatusOf(child), 3);
  EXPECT_THAT(Content(folder_ / "said.txt"), HasSubstr("the same command goes on"));
}

TEST_F(EndingTest, ASecondThatWouldWriteToAFolderIsRefused) {
  const pid_t child = Start(kEndless);
  WaitFor(folder_ / "run/scenario.yaml");
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  for (const std::string& second :
       {std::string(kShort), std::string("serve hover --asctec --for 1 --out run"),
        std::string("encounters --count 1 --harmless 0 --out run")}) {
    const Ended ended = Kestrel(second);
    EXPECT_EQ(ended.status, 2) << second << '\n' << ended.err;
    EXPECT_THAT(ended.err,
                HasSubstr("--out: another process is writing to 'run'; valid: to let it end, or another "
                          "folder"))
        << second;
  }
  EXPECT_FALSE(fs::exists(folder_ / "run/summary.json"));
  kill(child, SIGINT);
  EXPECT_EQ(StatusOf(child), 3);
  EXPECT_THAT(Content(folder_ / "run/scenario.yaml"), HasSubstr("3000"));
  EXPECT_LE(Kestrel(std::string(kShort) + "--no-video").status, 1);  // now it is free
}

TEST_F(EndingTest, AVideoThatADiskHadNoRoomForIsAFailure) {
  ASSERT_EQ(
      Shell(folder_, "ffmpeg -loglevel error -f lavfi -i testsrc=duration=1:size=640x480:rate=21 in.mp4")
          .status,
      0);
  const std::string view = "view in.mp4 --camera fisheye --out ";
  ASSERT_EQ(Kestrel(view + "whole.mp4").status, 0);
  // The last bytes have no room: those that ffmpeg by itself leaves out without a bad status.
  const std::uintmax_t blocks = (fs::file_size(folder_ / "whole.mp4") - 1) / 512;
  const Ended ended = KestrelOnAFullDisk(blocks, view + "cut.mp4");
  EXPECT_EQ(ended.status, 3);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("cannot write cut.mp4"), HasSubstr("File too large")));
  EXPECT_THAT(ended.out, Not(HasSubstr("frames")));
  EXPECT_FALSE(fs::exists(folder_ / "cut.mp4"));
}

TEST_F(EndingTest, OfARunOnAFullDiskNothingCutHasItsName) {
  ASSERT_LE(Kestrel(std::string(kShort) + "--images").status, 1);
  const std::uintmax_t whole = fs::file_size(folder_ / "run/video.mp4");
  const auto images = fs::file_size(folder_ / "run/recording/000001.png");
  const Ended video = KestrelOnAFullDisk((whole - 1) / 512, kShort);
  EXPECT_EQ(video.status, 3);
  EXPECT_FALSE(fs::exists(folder_ / "run/video.mp4"));
  EXPECT_THAT(Content(folder_ / "run/summary.json"),
              AllOf(HasSubstr("video.mp4: ffmpeg gave up"), HasSubstr("\"complete\": false")));

  for (const char* what : {"--images", "--truth"}) {
    const Ended ended = KestrelOnAFullDisk(images / 1024, std::string(kShort) + "--no-video " + what);
    EXPECT_EQ(ended.status, 3) << what;
    EXPECT_THAT(ended.out + ended.err, HasSubstr("File too large")) << what;
    int named = 0;
    for (const char* folder : {"run/recording", "run/truth"}) {
      if (!fs::exists(folder_ / folder)) continue;
      for (const auto& each : fs::directory_iterator(folder_ / folder)) {
        if (each.path().extension() != ".png") continue;
        ++named;
        EXPECT_THAT(Content(each.path()), ::testing::EndsWith(std::string("IEND\xae\x42\x60\x82")))
            << each.path();
      }
    }
    RecordProperty(std::string("whole") + what, named);
    fs::remove_all(folder_ / "run");
  }
}

TEST_F(EndingTest, APictureHasItsNameOnlyOnceItIsWholeSoThatAKillCutsNone) {
  for (const char* what : {"recording", "truth"}) {
    fs::remove_all(folder_ / "run");
    const pid_t child =
        Start(fmt::format("{} {}", kEndless, what == std::string("truth") ? "--truth" : "--images"));
    WaitFor(folder_ / "run" / what);
    const int watch = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    ASSERT_GE(inotify_add_watch(watch, (folder_ / "run" / what).c_str(), IN_CREATE | IN_MOVED_TO), 0);
    const fs::path some =
        folder_ / "run" / what / (what == std::string("truth") ? "000020_image.png" : "000020.png");
    WaitFor(some);
    kill(child, SIGKILL);
    EXPECT_EQ(StatusOf(child), -1);
    int whole = 0;
    alignas(inotify_event) char buffer[1 << 16];
    for (ssize_t size; (size = read(watch, buffer, sizeof buffer)) > 0;) {
      for (const char* at = buffer; at < buffer + size;) {
        const auto& event = *reinterpret_cast<const inotify_event*>(at);
        const std::string name = event.len > 0 ? event.name : "";
        at += sizeof event + event.len;
        if (name.ends_with(".part") || name == "geoms.csv") continue;
        EXPECT_TRUE(event.mask & IN_MOVED_TO) << name << " was written under its name";
        ++whole;
      }
    }
    close(watch);
    EXPECT_GT(whole, 0) << what;
  }
}

TEST_F(EndingTest, ResultsThatCannotBePrintedAreNoResults) {
  cv::imwrite((folder_ / "grey.png").string(), cv::Mat(480, 640, CV_8UC3, cv::Scalar(7, 8, 9)));
  for (const std::string& what :
       {std::string("check pose"), std::string("--version"), std::string("run --help"),
        std::string("horizon grey.png --camera fisheye"),
        std::string("view grey.png --camera fisheye --out out.png"), std::string(kShort) + "--no-video"}) {
    const Ended ended = Kestrel(what + " >/dev/full");
    EXPECT_EQ(ended.status, 3) << what;
    EXPECT_THAT(ended.err, HasSubstr("could not be written")) << what;
  }
  EXPECT_THAT(Content(folder_ / "run/summary.json"), HasSubstr("\"complete\": true"));  // which it was
  EXPECT_EQ(Kestrel("check none >/dev/full 2>/dev/full").status, 2);
  EXPECT_EQ(Kestrel("check pose >&-").status, 3);
  EXPECT_EQ(Kestrel("view grey.png --camera fisheye --out out.png --quiet >&-").status,
            0);  // nothing to print
}

}  // namespace
}  // namespace kestrel
