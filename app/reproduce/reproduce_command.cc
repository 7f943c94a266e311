// SPDX-License-Identifier: Apache-2.0
#include "app/reproduce/reproduce_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <stdexcept>

#include "app/option/within.h"
#include "app/reproduce/image_drawings.h"
#include "app/reproduce/reproduce_page.h"
#include "app/reproduce/thesis_items.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/in_parallel.h"
#include "flight/simulated/runner.h"
#include "flight/simulated/scenario.h"
#include "records/video/video_reader.h"
#include "vision/camera/camera_mount.h"
#include "vision/image_file.h"
#include "vision/write_image.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

constexpr int kStillWidth_px = 320;

void List(const Thesis& thesis) {
  for (const ThesisItem& item : thesis.items)
    for (const std::string& name : item.names)
      fmt::print("{:<13} {}\n", name,
                 item.none.empty() ? fmt::format("{}  [{}]", item.shows, fmt::join(item.flights, ", "))
                                   : "no counterpart: " + item.none);
}

// Images of the flight's video, evenly spaced, in rows of four.
cv::Mat StillsOf(const fs::path& video, int count) {
  records::VideoReader first(video);
  std::size_t frames = 0;
  while (first.Next()) ++frames;
  if (frames == 0) throw std::runtime_error(fmt::format("{} has no images", video.string()));
  std::set<std::size_t> wanted;
  for (int k = 0; k < count; ++k)
    wanted.insert((frames - 1) * static_cast<std::size_t>(2 * k + 1) / static_cast<std::size_t>(2 * count));
  records::VideoReader second(video);
  std::vector<cv::Mat> stills;
  for (std::size_t k = 0; k < frames; ++k) {
    const auto frame = second.Next();
    if (!frame || !wanted.contains(k)) continue;
    cv::Mat small;
    cv::resize(*frame, small, {kStillWidth_px, kStillWidth_px * frame->rows / frame->cols}, 0, 0,
               cv::INTER_AREA);
    stills.push_back(small);
  }
  const int columns = std::min<int>(4, static_cast<int>(stills.size()));
  while (stills.size() % static_cast<std::size_t>(columns) != 0)
    stills.emplace_back(stills[0].size(), CV_8UC3, cv::Scalar::all(255));
  std::vector<cv::Mat> rows;
  for (std::size_t i = 0; i < stills.size(); i += static_cast<std::size_t>(columns)) {
    const auto begin = stills.begin() + static_cast<std::ptrdiff_t>(i);
    rows.emplace_back();
    cv::hconcat(std::vector<cv::Mat>(begin, begin + columns), rows.back());
  }
  cv::Mat sheet;
  cv::vconcat(rows, sheet);
  return sheet;
}

std::vector<cv::Mat> ImagesOf(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder / "recording"))
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<cv::Mat> images;
  for (const fs::path& file : files) {
    const vision::ImageFile image = vision::ReadImageFile(file, vision::ImageColours::kColour);
    if (image.pixels.empty()) throw std::runtime_error(fmt::format("{}: {}", file.string(), image.error));
    images.push_back(image.pixels);
  }
  return images;
}

ReproducedItem DrawItem(const ThesisItem& item, const Thesis& thesis,
                        const std::map<std::string, flight::LoadedScenario>& loaded,
                        const std::map<std::string, Reproduced>& flown) {
  ReproducedItem drawn{&item, {}, {}};
  for (const std::string& name : item.flights) {
    const Reproduced& is = flown.at(name);
    const std::string& label = thesis.flights.at(name).label;
    const auto add = [&](const std::string& what, const fs::path& file, bool wide, const auto& make) {
      try {
        make(file);
        if (!fs::exists(file)) throw std::runtime_error("the flight left none");
        drawn.pictures.push_back({label, file, wide});
      } catch (const std::exception& e) {
        drawn.missing.push_back(fmt::format("{}: {}: {}", name, what, e.what()));
      }
    };
    for (const std::string& picture : item.pictures)
      add(picture, is.folder / picture, false, [](const fs::path&) {});
    if (!item.drawing.empty())
      add(item.drawing, is.folder / (item.drawing + ".png"), item.drawing != "ellipse",
          [&](const fs::path& file) {
            const sim::SimulatorParameters& simulator = loaded.at(name).simulator;
            DrawFromImages(item.drawing, ImagesOf(is.folder), simulator.camera,
                           vision::MountPose(simulator.mount), file);
          });
    if (item.stills > 0)
      add("stills", is.folder / fmt::format("stills_{}.jpg", item.stills), true, [&](const fs::path& file) {
        vision::WriteImage(file, StillsOf(is.folder / "video.mp4", item.stills));
      });
  }
  return drawn;
}

}  // namespace

CLI::App* AddReproduceCommand(CLI::App& app, ReproduceArguments& a) {
  CLI::App* command = app.add_subcommand(
      "reproduce", "Fly and draw the thesis's tables and figures, beside its numbers, on one page");
  command->add_option("names", a.names, "Such as figure-4.14, 4.14 or table-6.3; none: all")
      ->type_name("TABLE|FIGURE");
  command->add_flag("--list", a.list, "List the tables and figures, with their flights, and end");
  command->add_option("--seed", a.seed, "Of every flight")->capture_default_str();
  command->add_option("--jobs", a.jobs, "Flights at the same time")
      ->check(WholeNumber(1, 256))
      ->capture_default_str();
  command->add_option("--out", a.out, "Folder of the page, index.html, and of the flights' records")
      ->type_name("DIR")
      ->capture_default_str();
  command->footer(
      "Examples:\n  kestrel reproduce --list\n  kestrel reproduce figure-3.8 table-6.3\n  kestrel reproduce "
      "--jobs 2");
  return command;
}

bool ReproduceCommand(const ReproduceArguments& a) {
  const Thesis thesis = LoadThesis(ThesisFile());
  if (a.list) {
    List(thesis);
    return true;
  }
  const std::vector<const ThesisItem*> items = Chosen(thesis, a.names);
  Mistakes mistakes;
  CheckWritableFolder(a.out, "--out", mistakes);
  mistakes.ThrowIfAny();

  // Each flight once, however many items it stands for; with its images where something is drawn from them.
  std::vector<std::string> names;
  std::set<std::string> with_images;
  for (const ThesisItem* item : items)
    for (const std::string& flight : item->flights) {
      if (std::find(names.begin(), names.end(), flight) == names.end()) names.push_back(flight);
      if (!item->drawing.empty()) with_images.insert(flight);
    }
  std::map<std::string, flight::LoadedScenario> loaded;
  std::map<std::string, Reproduced> flown;
  for (const std::string& name : names) {
    const ThesisFlight& is = thesis.flights.at(name);
    std::vector<std::string> overrides = is.set;
    overrides.push_back(fmt::format("seed={}", a.seed));
    loaded.emplace(name, flight::LoadScenario(is.scenario, overrides));
    flown[name].folder = fs::path(a.out) / "flights" / name;
  }
  InParallel(names.size(), a.jobs, "reproduce", "flights", [&](std::size_t i) {
    Reproduced& is = flown.at(names[i]);
    flight::RunOptions options;
    options.folder = is.folder;
    options.images = with_images.contains(names[i]);
    const flight::FlightResult result = flight::RunFlight(loaded.at(names[i]), options);
    is.metrics = result.summary.metrics, is.outcome = result.summary.outcome;
    is.error = result.summary.error;
  });

  std::vector<ReproducedItem> drawn;
  bool whole = true;
  for (const ThesisItem* item : items) {
    drawn.push_back(DrawItem(*item, thesis, loaded, flown));
    bool complete = drawn.back().missing.empty();
    for (const std::string& flight : item->flights) complete = complete && flown.at(flight).error.empty();
    whole = whole && complete;
    fmt::print("{}: {}\n", TitleOf(*item),
               !item->none.empty() ? "no counterpart: " + item->none
               : complete          ? fmt::format("{} pictures", drawn.back().pictures.size())
                                   : "NOT WHOLE");
    for (const std::string& missing : drawn.back().missing) fmt::print("  {}\n", missing);
  }
  const fs::path page = fs::path(a.out) / "index.html";
  WriteFile(page, ReproducePage(thesis, drawn, flown, a.seed));
  fmt::print("{}\n", page.string());
  return whole;
}

}  // namespace kestrel::app
