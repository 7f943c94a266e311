// SPDX-License-Identifier: Apache-2.0
#include "app/run/picture_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>

#include "app/run/view_option.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/print_note.h"
#include "flight/simulated/runner.h"
#include "sim/view/view_camera.h"
#include "sim/view/view_renderer.h"
#include "vision/write_image.h"

namespace kestrel::app {
namespace {

constexpr int kSamples = 3;  // along each side of a pixel
constexpr char kOnBoard[] = "camera";

// One line on a terminal, once it takes longer than one likes to wait without a word.
class Waiting {
 public:
  explicit Waiting(bool wanted) : wanted_(wanted && isatty(STDERR_FILENO)) {}
  ~Waiting() {
    if (shown_) PrintNote("\r\033[K");
  }
  void Show(const std::string& text) {
    const auto now = std::chrono::steady_clock::now();
    if (!wanted_ || now - start_ < std::chrono::seconds(2) || now - last_ < std::chrono::milliseconds(200))
      return;
    last_ = now;
    shown_ = true;
    PrintNote("\r\033[K{}", text);
    std::fflush(stderr);
  }

 private:
  bool wanted_, shown_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_ = start_;
};

// The view at the instant asked for, between the two frames around it.
class Photographer {
 public:
  Photographer(const sim::ViewParameters& view, double at_s) : view_(view), at_s_(at_s) {}

  // After each frame; true: the picture is taken.
  bool Watch(const sim::Simulator& simulator, int threads) {
    if (!camera_) camera_.emplace(simulator.model(), view_);
    const sim::ViewAim aim = camera_->At(simulator.truth());
    sim::Snapshot now = simulator.snapshot();
    now.X_NC = aim.X_NC;
    const double t_s = now.t_s;
    worlds_.push_back(std::move(now));
    if (worlds_.size() > 2) worlds_.erase(worlds_.begin());
    const double fov_before = std::exchange(fov_rad_, aim.fov_rad);
    if (t_s < at_s_) return false;
    const double gap_s = t_s - worlds_.front().t_s;
    const double share = gap_s > 0 ? std::clamp((at_s_ - worlds_.front().t_s) / gap_s, 0.0, 1.0) : 1;
    picture_ = sim::ViewRenderer(simulator.model(), view_, threads, kSamples)
                   .Draw(worlds_, at_s_,
                         worlds_.size() > 1 ? fov_before + share * (aim.fov_rad - fov_before) : aim.fov_rad);
    return true;
  }
  const cv::Mat& picture() const { return picture_; }

 private:
  sim::ViewParameters view_;
  double at_s_;
  std::optional<sim::ViewCamera> camera_;
  std::vector<sim::Snapshot> worlds_;  // the last two
  double fov_rad_ = 0;
  cv::Mat picture_;
};

}  // namespace

CLI::App* AddPictureCommand(CLI::App& app, PictureArguments& a) {
  CLI::App* command = app.add_subcommand("picture", "Draw an instant of a flight from outside, for papers");
  command->add_option("scenario", a.scenario, "A name that `list` shows, or a YAML file")
      ->type_name("SCENARIO")
      ->required();
  command->add_option("--at", a.at_s, "The instant, s from the beginning of the flight")->required();
  command
      ->add_option(
          "--view", a.view,
          "chase, tower, orbit, top or free, as the scenario's key view says more closely; or camera: "
          "the image of the camera on board")
      ->type_name("VIEW")
      ->capture_default_str();
  command->add_option("--size", a.size, "WIDTHxHEIGHT in pixels, 1920x1080 if not given; camera has its own");
  command->add_option("--seed", a.seed, "Of everything random, instead of the scenario's");
  command->add_option("--set", a.overrides, "key.path=value, instead of the scenario's; may be repeated")
      ->type_name("KEY=VALUE");
  command
      ->add_option("--out", a.out,
                   "The file to write, .png or .jpg (default results/pictures/NAME-SEED-VIEW-TIME.png)")
      ->type_name("FILE");
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Examples:\n  kestrel picture landing --at 12.5 --view tower --size 3840x2160\n"
      "  kestrel picture follow --at 10 --set view.distance_m=4 --out follow.jpg");
  return command;
}

void PictureCommand(const PictureArguments& a) {
  std::vector<std::string> overrides = a.overrides;
  if (!a.seed.empty()) overrides.push_back("seed=" + a.seed);
  const flight::LoadedScenario loaded = flight::LoadScenario(a.scenario, overrides);
  const flight::Scenario& scenario = loaded.scenario;
  Mistakes mistakes;
  const bool on_board = a.view == kOnBoard;
  sim::ViewParameters view = scenario.view;
  view.kind = a.view;
  if (!on_board && std::ranges::find(sim::KindsOfView(), a.view) == sim::KindsOfView().end())
    mistakes.Add("--view", "", fmt::format("'{}' is no view", a.view),
                 fmt::format("valid: {}, {}", fmt::join(sim::KindsOfView(), ", "), kOnBoard));
  if (on_board && a.size)
    mistakes.Add("--size", "", "the image of the camera on board has the size of that camera",
                 "valid: another view, or no --size");
  if (const auto size = ReadViewSize("--size", a.size.value_or("1920x1080"), mistakes))
    view.width_px = size->width, view.height_px = size->height;
  if (!(a.at_s >= 0 && a.at_s <= scenario.duration_s))
    mistakes.Add("--at", "", fmt::format("{:g} is not within the flight", a.at_s),
                 fmt::format("valid: 0 to {:g} s, the scenario's duration_s", scenario.duration_s));
  const std::string out = a.out.empty() ? fmt::format("results/pictures/{}-{}-{}-{:g}.png", scenario.name,
                                                      scenario.seed, a.view, a.at_s)
                                        : a.out;
  if (!HasEnding(out, {".png", ".jpg", ".jpeg"}))
    mistakes.Add("--out", "", fmt::format("'{}' does not name an image", out),
                 "valid: an ending .png or .jpg");
  if (a.out.empty()) std::filesystem::create_directories("results/pictures");
  CheckWritableFile(out, "--out", mistakes);
  mistakes.ThrowIfAny();

  Waiting waiting(!a.quiet);
  Photographer photographer(view, a.at_s);
  cv::Mat picture;
  flight::RunOptions options;
  options.watch = [&](const sim::Simulator& simulator, const vision::Frame& frame) {
    const double t_s = simulator.truth().t_s;
    waiting.Show(t_s < a.at_s ? fmt::format("{:.1f} of {:g} s flown", t_s, a.at_s)
                              : fmt::format("drawing {} x {}", view.width_px, view.height_px));
    if (on_board) {
      if (t_s >= a.at_s && picture.empty()) picture = frame.image.clone();
    } else if (picture.empty() && photographer.Watch(simulator, 0)) {
      picture = photographer.picture();
    }
  };
  options.progress = [&](const records::LogRow&) { return picture.empty(); };
  const flight::FlightResult result = flight::RunFlight(loaded, options);
  if (picture.empty()) {
    const double end_s = result.rows.empty() ? 0 : result.rows.back().now.t_s;
    if (!result.summary.error.empty()) throw std::runtime_error(result.summary.error);
    throw InputError("--at", fmt::format("the flight ended at {:.3g} s: {}", end_s, result.summary.outcome),
                     fmt::format("valid: 0 to {:.3g}", end_s));
  }
  vision::WriteImage(out, picture);
  if (!a.quiet) fmt::print("{}\n", out);
}

}  // namespace kestrel::app
