// SPDX-License-Identifier: Apache-2.0
// Files that are small, or none at all, and would take a machine's memory and time: each is refused as bad
// input, soon, in the memory that the program takes anyway.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "tests/attack/limited_program.h"
#include "tests/support/temporary_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kMaxCpu_s = 5;  // it takes a tenth of that, and a busy machine counts more
constexpr double kMost_mib = 300;
constexpr std::size_t kMaxSaid = 110'000;  // fifty mistakes of 2000 letters

class FilesTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    cv::imwrite((folder_ / "grey.png").string(), cv::Mat(480, 640, CV_8UC3, cv::Scalar(7, 8, 9)));
    ASSERT_EQ(mkfifo((folder_ / "pipe.yaml").c_str(), 0600), 0);
    Write("sparse.yaml", "");
    fs::resize_file(folder_ / "sparse.yaml", std::uintmax_t{20} << 30);
    fs::create_symlink("/dev/zero", folder_ / "zero.yaml");
    fs::create_symlink("/proc/kcore", folder_ / "kcore.yaml");
    fs::create_symlink("loop.yaml", folder_ / "loop.yaml");
  }
  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  Taken Kestrel(std::vector<std::string> arguments, const std::vector<std::string>& environment = {}) const {
    arguments.insert(arguments.begin(), KESTREL_PROGRAM);
    return RunLimited(folder_, arguments, environment);
  }
  // With the file's name, or what stands for it, in the place of "@".
  void IsRefused(std::vector<std::string> arguments, const std::string& file,
                 const std::vector<std::string>& environment = {}) const {
    for (std::string& each : arguments)
      if (const std::size_t at = each.find('@'); at != std::string::npos) each.replace(at, 1, file);
    const Taken taken = Kestrel(arguments, environment);
    const std::string command = fmt::format("kestrel {}", fmt::join(arguments, " ")).substr(0, 300);
    SCOPED_TRACE(command);
    RecordProperty("peak_mib", static_cast<int>(taken.peak_mib));
    EXPECT_EQ(taken.status, 2) << taken.output.substr(0, 1000);
    EXPECT_LT(taken.cpu_s, kMaxCpu_s);
    EXPECT_LT(taken.peak_mib, kMost_mib);
    EXPECT_LT(taken.output.size(), kMaxSaid);
    EXPECT_THAT(taken.output, HasSubstr(file.substr(0, 200)));
    EXPECT_THAT(taken.output, Not(HasSubstr("filesystem error")));
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  }
};

const std::vector<std::vector<std::string>>& ReadersOfYaml() {
  static const std::vector<std::vector<std::string>> kReaders = {
      {"check", "@"},
      {"run", "@", "--out", "out"},
      {"check", "pose", "--set", "gains=@"},
      {"check", "pose", "--set", "camera=@"},
      {"campaign", "@", "--out", "out"},
      {"tune", "@", "--out", "out"},
      {"calibrate", "grey.png", "--model", "pinhole", "--board", "@", "--out", "out"},
      {"render-board", "--camera", "@", "--out", "out"},
      {"view", "grey.png", "--camera", "@", "--out", "out.png"}};
  return kReaders;
}

TEST_F(FilesTest, AFewLinesOfAliases) {
  std::string text = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 9; ++i)
    text += fmt::format(
        "a{0}: &a{0} [*a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}]\n", i, i - 1);
  Write("aliases.yaml", text);
  for (const auto& reader : ReadersOfYaml()) IsRefused(reader, "aliases.yaml");
}

TEST_F(FilesTest, AListOfAMillionEntries) {
  std::string text = "mission: pose\nsensors: {faults: [1";
  for (int i = 0; i < 1'000'000; ++i) text += ",1";
  Write("list.yaml", text + "]}\n");
  text.resize(1'000'000);
  Write("shorter.yaml", text + "]}\n");
  for (const auto& reader : ReadersOfYaml()) IsRefused(reader, "list.yaml");
  IsRefused({"check", "@"}, "shorter.yaml");
  IsRefused({"campaign", "@"}, "shorter.yaml");
}

TEST_F(FilesTest, AHundredThousandUnknownKeys) {
  std::string text = "mission: pose\n";
  for (int i = 0; i < 100'000; ++i) text += fmt::format("k{}: 1\n", i);
  Write("keys.yaml", text);
  IsRefused({"check", "@"}, "keys.yaml");
  Write("keys.yaml", text.substr(0, text.find("k20000:")));
  IsRefused({"check", "@"}, "keys.yaml");
}

TEST_F(FilesTest, WhatIsNoRegularFileOrHasNoEnd) {
  for (const char* file : {"zero.yaml", "pipe.yaml", "sparse.yaml", "kcore.yaml"})
    for (const auto& reader : ReadersOfYaml()) IsRefused(reader, file);
}

TEST_F(FilesTest, LoopsOfLinksAndNamesThatAreTooLong) {
  for (const std::string& file : {std::string("loop.yaml"), std::string(300, 'n') + ".yaml"})
    for (const auto& reader : ReadersOfYaml()) IsRefused(reader, file);
  fs::create_symlink("loop", folder_ / "loop");
  for (const std::string& name : {std::string("./loop"), std::string(300, 'n')}) {
    for (const auto& reader : ReadersOfYaml()) IsRefused(reader, name);
    for (const std::vector<std::string>& reader : {std::vector<std::string>{"replay", "@"},
                                                   {"campaign", "report", "@"},
                                                   {"campaign", "compare", "@", "@"},
                                                   {"check", "pose", "--set", "vehicle=@"},
                                                   {"check", "pose", "--set", "world=@"},
                                                   {"check", "pose", "--set", "pad.name=@"},
                                                   {"run", "pose", "--out", "@"},
                                                   {"render-board", "--camera", "fisheye", "--out", "@"}})
      IsRefused(reader, name);
  }
  IsRefused({"check", "pose", "--set", "name=@"}, std::string(300, 'n'));
}

TEST_F(FilesTest, ImagesThatAreNone) {
  const std::vector<std::vector<std::string>> readers = {
      {"calibrate", "@", "--model", "pinhole", "--out", "out"},
      {"view", "@", "--camera", "thesis_6mm", "--out", "out.png"},
      {"horizon", "@", "--camera", "thesis_6mm"},
      {"horizon", "grey.png", "--camera", "thesis_6mm", "--mask", "@"}};
  fs::create_symlink("loop", folder_ / "loop");
  for (const std::string& file :
       {std::string("zero.yaml"), std::string("pipe.yaml"), std::string("sparse.yaml"),
        std::string("kcore.yaml"), std::string("loop"), std::string(300, 'n')})
    for (const auto& reader : readers) IsRefused(reader, file);
}

// A picture of nothing: 16384 x 16384 pixels in a quarter of a megabyte, or in no more than its header.
TEST_F(FilesTest, ImagesThatAreLargeOnceDecoded) {
  std::vector<uchar> bytes;
  cv::imencode(".png", cv::Mat(16384, 16384, CV_8U, cv::Scalar(0)), bytes, {cv::IMWRITE_PNG_COMPRESSION, 9});
  ASSERT_LT(bytes.size(), 1'000'000u);
  Write("bomb.png", {bytes.begin(), bytes.end()});
  Write("bomb.pgm", "P5 30000 30000 255\n");
  for (const char* file : {"bomb.png", "bomb.pgm"}) {
    IsRefused({"calibrate", "@", "--model", "pinhole", "--out", "out"}, file);
    IsRefused({"view", "@", "--camera", "thesis_6mm", "--out", "out.png"}, file);
    IsRefused({"horizon", "@", "--camera", "thesis_6mm"}, file);
    IsRefused({"horizon", "grey.png", "--camera", "thesis_6mm", "--mask", "@"}, file);
  }
}

// A checkout of links to this one, but for its pad.
TEST_F(FilesTest, PicturesOfPads) {
  const fs::path source = KESTREL_SOURCE_DIR, root = folder_ / "root", pad = root / "models/pads/helipad";
  fs::create_directories(pad);
  fs::create_symlink(source / "scenarios", root / "scenarios");
  for (const auto& kind : fs::directory_iterator(source / "models"))
    if (kind.path().filename() != "pads")
      fs::create_symlink(kind.path(), root / "models" / kind.path().filename());
  const std::vector<std::string> environment = {"KESTREL_ROOT=" + root.string()};
  const auto with_texture = [&](const std::string& texture) {
    std::ofstream(pad / "helipad.yaml") << "texture: '" << texture << "'\n";
    return Kestrel({"check", "pose"}, environment);
  };
  std::vector<uchar> bytes;
  cv::imencode(".png", cv::Mat(16384, 16384, CV_8U, cv::Scalar(0)), bytes, {cv::IMWRITE_PNG_COMPRESSION, 9});
  std::ofstream(pad / "bomb.png").write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
  cv::imwrite((pad / "dot.png").string(), cv::Mat(1, 1, CV_8U, cv::Scalar(0)));
  cv::imwrite((pad / "deep.png").string(), cv::Mat(64, 64, CV_16U, cv::Scalar(0)));
  cv::imwrite((pad / "black.png").string(), cv::Mat(64, 64, CV_8U, cv::Scalar(0)));
  fs::copy_file(source / "models/pads/helipad/helipad.png", pad / "whole.png");
  ASSERT_EQ(mkfifo((pad / "pipe.png").c_str(), 0600), 0);
  fs::create_symlink("loop.png", pad / "loop.png");
  for (const std::string& texture :
       {std::string("bomb.png"), std::string("dot.png"), std::string("deep.png"), std::string("black.png"),
        std::string("pipe.png"), std::string("loop.png"), std::string("/dev/zero"), std::string("."),
        std::string(), std::string(300, 'n')}) {
    const Taken taken = with_texture(texture);
    EXPECT_EQ(taken.status, 2) << texture << ": " << taken.output;
    EXPECT_LT(taken.cpu_s, kMaxCpu_s) << texture;
    EXPECT_LT(taken.peak_mib, kMost_mib) << texture;
    EXPECT_THAT(taken.output, HasSubstr("helipad.yaml: texture: '")) << texture;
  }
  EXPECT_EQ(with_texture("whole.png").status, 0);  // so that it is the picture, and not the checkout
}

TEST_F(FilesTest, MoreTargetsThanCanBeFlown) {
  std::string text = "mission: pose\nduration_s: 0.5\nstart: {settle_s: 1}\ntargets:\n";
  for (int i = 0; i < 200; ++i)
    text += fmt::format("  - {{position_m: [{}, {}, 50], diameter_m: 0.3, string_m: 9}}\n", i % 20, i / 20);
  Write("targets.yaml", text);
  const Taken flown = Kestrel({"run", "targets.yaml", "--no-video", "--out", "flown"});
  EXPECT_EQ(flown.status, 0) << flown.output;
  for (const int more : {1, 2000, 20000}) {
    std::string with = text;
    for (int i = 0; i < more; ++i) with += "  - {position_m: [0, 0, 60], diameter_m: 0.3}\n";
    Write("targets.yaml", with);
    IsRefused({"check", "@"}, "targets.yaml");
    IsRefused({"run", "@", "--out", "out"}, "targets.yaml");
  }
}

// As in a sandbox. Nothing is in the way of the flight, nor of a campaign's workers.
TEST_F(FilesTest, NoProc) {
  const auto without_proc = [&](const std::string& command) {
    return RunLimited(
        folder_,
        {"/bin/sh", "-c", "exec unshare -r -m sh -c 'mount -t tmpfs none /proc && exec " + command + "'"});
  };
  if (without_proc("true").status != 0) GTEST_SKIP() << "this machine lets nobody unmount /proc";
  const Taken check = without_proc(KESTREL_PROGRAM " check pose");
  EXPECT_EQ(check.status, 0) << check.output;
  Write("small.yaml",
        "name: small\nscenario: pose\nset: [duration_s=0.5, start.settle_s=1, 'criteria={}']\nruns: 2\n"
        "thresholds: {success: {min: 0.1}}\n");
  const Taken campaign = without_proc(KESTREL_PROGRAM " campaign small.yaml --jobs 1 --out flown");
  EXPECT_EQ(campaign.status, 0) << campaign.output;
}

TEST_F(FilesTest, DamagedRecordings) {
  const Taken run = Kestrel({"run", "pose", "--no-video", "--images", "--set", "duration_s=0.5", "--set",
                             "start.settle_s=1", "--set", "criteria={}", "--out", "flown"});
  ASSERT_EQ(run.status, 0) << run.output;
  const fs::path recording = folder_ / "flown/recording", table = recording / "frames.csv";
  ASSERT_EQ(Kestrel({"replay", "flown"}).status, 0);
  const std::string frames = Content(table);
  const std::size_t second = frames.find('\n') + 1, third = frames.find('\n', second) + 1;
  for (const std::string& damaged :
       {std::string(), std::string("sequence\n"), frames.substr(0, second),
        frames.substr(0, third + 20) + '\n', frames.substr(0, second) + std::string(1000, ',') + '\n',
        std::string(100'000, '\0'),
        frames.substr(0, second) + "-1" + frames.substr(frames.find(',', second))}) {
    std::ofstream(table, std::ios::binary) << damaged;
    IsRefused({"replay", "@"}, "flown");
  }
  fs::resize_file(table, std::uintmax_t{20} << 30);
  IsRefused({"replay", "@"}, "flown");
  fs::remove(table);
  ASSERT_EQ(mkfifo(table.c_str(), 0600), 0);
  IsRefused({"replay", "@"}, "flown");
  fs::remove(table);
  std::ofstream(table, std::ios::binary) << frames;
  fs::path image;
  for (const auto& each : fs::directory_iterator(recording))
    if (each.path().extension() == ".png") image = each.path();
  std::string bytes = Content(image);
  std::ofstream(image, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  IsRefused({"replay", "@"}, "flown");
  for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 1000; ++i) bytes[i] = 'x';
  std::ofstream(image, std::ios::binary) << bytes;  // whole, but for what is in it
  IsRefused({"replay", "@"}, "flown");
  cv::imwrite(image.string(), cv::Mat(3, 5, CV_8U, cv::Scalar(0)));
  IsRefused({"replay", "@"}, "flown");
}

}  // namespace
}  // namespace kestrel
