// SPDX-License-Identifier: Apache-2.0
#include "app/flight/replay_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "app/flight/replay_log.h"
#include "app/flight/replay_records.h"
#include "app/option/bits_option.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/stopwatch.h"
#include "base/user_file.h"
#include "flight/flight_plan.h"
#include "records/recording.h"
#include "records/telemetry/flight_mode.h"
#include "records/video/drawn_view.h"
#include "records/video/video.h"

namespace kestrel::app {
namespace {

// How one quantity differs over a flight.
struct Difference {
  std::size_t frames = 0, first = 0;
  double most = 0;  // infinite: given in one and not in the other, or another text

  void Note(std::size_t frame, double by) {
    if (frames++ == 0) first = frame;
    most = std::max(most, by);
  }
};

constexpr double kOther = std::numeric_limits<double>::infinity();

double By(const std::optional<double>& a, const std::optional<double>& b) {
  if (a.has_value() != b.has_value()) return kOther;
  if (!a || *a == *b || (std::isnan(*a) && std::isnan(*b))) return 0;
  const double by = std::abs(*a - *b);
  return std::isnan(by) ? kOther : by;
}

class Comparison {
 public:
  // Of the numbers of a recording, those that the mission has.
  Comparison(double tolerance, const std::vector<std::string>& then, const std::vector<std::string>& now)
      : tolerance_(tolerance) {
    for (std::size_t i = 0; i < then.size(); ++i) {
      const auto found = std::find(now.begin(), now.end(), then[i]);
      if (found != now.end()) pairs_.push_back({then[i], i, static_cast<std::size_t>(found - now.begin())});
    }
  }

  void Compare(std::size_t frame, const records::RecordedDecision& then,
               const records::RecordedDecision& now) {
    const auto text = [&](const char* name, const std::string& a, const std::string& b) {
      if (a != b) differences_[name].Note(frame, kOther);
    };
    text("phase", then.phase, now.phase);
    text("target", then.target, now.target);
    text("outcome", then.outcome, now.outcome);
    for (const Pair& each : pairs_) {
      const double by = By(then.numbers[each.then], now.numbers[each.now]);
      if (by > tolerance_) differences_[each.name].Note(frame, by);
    }
  }

  bool same() const { return differences_.empty(); }
  void Print(const std::vector<records::RecordedFrame>& frames) const {
    fmt::print("| {:<24} | {:>6} | {:>12} | {:>12} | {:>12} |\n", "differs", "frames", "first frame", "at",
               "by at most");
    for (const auto& [name, d] : differences_)
      fmt::print("| {:<24} | {:>6} | {:>12} | {:>10.3f} s | {:>12} |\n", name, d.frames,
                 frames[d.first].sequence, frames[d.first].t_s - frames.front().t_s,
                 std::isinf(d.most) ? "another" : fmt::format("{:.3g}", d.most));
  }

 private:
  struct Pair {
    std::string name;
    std::size_t then, now;  // where each has it
  };

  double tolerance_;
  std::vector<Pair> pairs_;
  std::map<std::string, Difference> differences_;
};

}  // namespace

void RequireSizeOf(const vision::CameraModel& camera, const vision::Frame& frame, const std::string& folder) {
  if (frame.image.cols == vision::WidthPx(camera) && frame.image.rows == vision::HeightPx(camera)) return;
  throw InputError(
      folder,
      fmt::format("its image {} has {} x {} pixels", frame.sequence, frame.image.cols, frame.image.rows),
      fmt::format("valid: the camera's {} x {}", vision::WidthPx(camera), vision::HeightPx(camera)));
}

CLI::App* AddReplayCommand(CLI::App& app, ReplayArguments& a) {
  CLI::App* command = app.add_subcommand(
      "replay", "Give a recorded flight's images and states to its mission again, and compare");
  command
      ->add_option(
          "folder", a.folder,
          "Of a flight with recording/: run or fly with --images; or an MCAP of ROS 2, of any flight")
      ->type_name("FLIGHT")
      ->required();
  command
      ->add_option("--set", a.overrides,
                   "key.path=value of the flight, to see what another gain or tracker would have said")
      ->type_name("KEY=VALUE");
  command->add_option("--tolerance", a.tolerance, "Up to which numbers count as equal, in their units")
      ->capture_default_str();
  command->add_option("--video", a.video, "Also write what the vision code sees now to this MP4")
      ->type_name("FILE");
  command
      ->add_option(
          "--out", a.out,
          "Also write the records of what the mission makes of it now, with their page, to this folder")
      ->type_name("DIR");
  AddLiveOptions(*command, a.live, true);
  command
      ->add_option("--scenario", a.scenario,
                   "Of an MCAP: whose mission sees it, by the scenario's camera and pad; a name or a file")
      ->type_name("SCENARIO");
  command->add_option("--topic", a.topic, "Of an MCAP: the images (default: the only ones)")
      ->type_name("NAME");
  command
      ->add_option(
          "--state-topic", a.state_topic,
          "Of an MCAP: nav_msgs/Odometry, or sensor_msgs/Imu with orientation (default: the only one)")
      ->type_name("NAME");
  command
      ->add_option("--csv", a.csv,
                   "Of an MCAP: a row for each image, with what the mission measured and asked for")
      ->type_name("FILE");
  AddBitsOption(*command, a.bits);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Exit status 1: something differs.\n\nExamples:\n"
      "  kestrel run landing --images --out results/runs/first && kestrel replay results/runs/first\n"
      "  kestrel replay results/runs/first --set pilot.servo.lambda_per_s=0.8 --video again.mp4\n"
      "  kestrel replay flight.mcap --scenario landing --set camera=my_calibration.yaml --csv seen.csv");
  return command;
}

std::optional<std::filesystem::path> OutOf(const ReplayArguments& a) {
  if (a.out.empty()) return std::nullopt;
  return a.out;
}

bool ReplayCommand(const ReplayArguments& a) {
  if (IsFile(a.folder)) {
    ReplayLog(a);
    return true;
  }
  const std::filesystem::path folder = a.folder;
  Mistakes mistakes;
  for (const auto& [option, given] : {std::pair{"--scenario", !a.scenario.empty()},
                                      {"--topic", !a.topic.empty()},
                                      {"--state-topic", !a.state_topic.empty()},
                                      {"--csv", !a.csv.empty()},
                                      {"--bits", a.bits.has_value()}})
    if (given) mistakes.Add(option, "", fmt::format("'{}' is no MCAP", a.folder), "valid: without it");
  if (!IsFile(folder / "scenario.yaml"))
    mistakes.Add("replay", "", fmt::format("'{}' holds no scenario.yaml: not a flight's folder", a.folder),
                 "valid: the folder of run or fly with --images, or an MCAP of ROS 2");
  CheckWritableFile(a.video, "--video", mistakes);
  const std::optional<flight::LiveOptions> of_live = ReadLive(a.live, mistakes);
  CheckWritableFolder(a.out, "--out", mistakes);
  if (!a.out.empty() && SameFile(a.out, folder))
    mistakes.Add("--out", "", fmt::format("'{}' holds the flight itself", a.out), "valid: another folder");
  if (!(a.tolerance >= 0 && std::isfinite(a.tolerance)))
    mistakes.Add("--tolerance", "", fmt::format("{:g} is no tolerance", a.tolerance), "valid: 0 or more");
  mistakes.ThrowIfAny();
  const flight::LoadedPlan loaded = flight::LoadPlan((folder / "scenario.yaml").string(), a.overrides);
  if (const mission::MissionType& flown = loaded.plan.flight.type(); flown.needs_ground_camera)
    throw InputError(
        "replay",
        fmt::format("the mission '{}' flies by a camera on the ground, whose images no recording has",
                    flown.name),
        "valid: a flight by the camera on board alone");
  const records::Recording recording(folder);
  const std::vector<records::RecordedFrame>& frames = recording.frames();
  const std::vector<std::filesystem::path> damaged = recording.Damaged();
  if (!damaged.empty())
    mistakes.Add("replay", "",
                 fmt::format("{} of {} images are missing or cut off, the first of them {}", damaged.size(),
                             frames.size(), damaged.front().string()));
  mistakes.ThrowIfAny();

  const std::unique_ptr<mission::Mission> mission = loaded.plan.flight->Make(loaded.parts);
  std::optional<records::Video> video;
  if (!a.video.empty()) video.emplace(a.video, loaded.plan.image.rate_hz);
  const std::unique_ptr<flight::Live> live = MakeLive(of_live);
  PrintLive(live.get());
  ReplayRecords records(OutOf(a), live.get(), loaded, loaded.plan.image.rate_hz);
  const mission::MissionType& type = loaded.plan.flight.type();
  Comparison comparison(a.tolerance, recording.numbers(), records::RecordedNumbers(type));
  const bool terminal = isatty(STDERR_FILENO) && !a.quiet;
  const auto begun = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const vision::Frame frame = recording.At(i);
    RequireSizeOf(loaded.parts.camera, frame, a.folder);
    const mission::Decision decision = mission->Step(frame, frames[i].state);
    comparison.Compare(i, frames[i].decision, records::Recorded(decision, type));
    if (video) {
      video->Write(records::DrawnView(frame, frame.t_s, *mission, records::kRecordingMode));
    }
    records.Write(frame, frames[i].state, decision, *mission);
    if (terminal && i % 20 == 0) fmt::print(stderr, "\r\033[K{} of {} frames", i, frames.size());
  }
  if (terminal) fmt::print(stderr, "\r\033[K");
  if (video) video->Close();
  const std::string report =
      records.Finish(comparison.same() ? "as it was recorded" : "other than it was recorded",
                     comparison.same(), SecondsSince(begun));
  if (!a.quiet) {
    fmt::print("{}: {} frames of {:.1f} s seen again in {:.1f} s\n", loaded.plan.name, frames.size(),
               frames.back().t_s - frames.front().t_s, SecondsSince(begun));
    if (comparison.same())
      fmt::print("measurements and setpoints are those of the recording{}\n",
                 a.tolerance > 0 ? fmt::format(", to {:g}", a.tolerance) : ", to the last bit");
    else
      comparison.Print(frames);
    if (!report.empty()) fmt::print("  {}\n", report);
  }
  Linger(live.get(), [] { return true; });
  return comparison.same();
}

}  // namespace kestrel::app
