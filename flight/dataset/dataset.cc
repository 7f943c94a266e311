// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/file/files.h"
#include "base/file/writer_lock.h"
#include "base/process/in_parallel.h"
#include "base/version.h"
#include "flight/dataset/along_trajectory.h"
#include "flight/dataset/journal.h"
#include "flight/dataset/mission_flight.h"
#include "flight/simulated/images/truth_images.h"
#include "sim/world/scene.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

std::string ManifestOf(const DatasetPlan& plan, const std::vector<WrittenFile>& files, std::size_t frames) {
  OrderedJson manifest{
      {"version", Version()}, {"format", plan.arguments.format}, {"source", plan.arguments.source}};
  manifest["scenario"] = plan.first.scenario.name;
  for (int i = 0; i < plan.arguments.count; ++i)
    manifest["seeds"].push_back(plan.first.scenario.seed + static_cast<std::uint64_t>(i));
  manifest["settings"] = "settings.txt";
  manifest["frames"] = frames;
  manifest["hash"] = "XXH128";
  for (const WrittenFile& f : files)
    manifest["files"].push_back({{"path", f.path}, {"bytes", f.size}, {"hash", f.hash}});
  return manifest.dump(1) + "\n";
}

// What the values of the segmentation mean.
std::string GeomTable(const LoadedScenario& loaded) {
  sim::SceneParameters scene = loaded.simulator.scene;
  scene.targets = loaded.simulator.targets;
  const sim::ModelPtr model = sim::MakeModel(scene, false);
  return GeomsCsv(model.get());
}

// Of a set that is complete; none: it is not, or a file of it is no longer there as it was.
std::optional<DatasetResult> CompleteSet(const DatasetPlan& plan) {
  const OrderedJson manifest =
      OrderedJson::parse(ReadFile(plan.arguments.out / "manifest.json"), nullptr, false);
  if (!manifest.is_object()) return std::nullopt;
  const std::size_t frames = manifest.at("frames");
  DatasetResult result{static_cast<std::size_t>(plan.arguments.count), frames, manifest.at("files").size(),
                       frames, 0};
  for (const OrderedJson& file : manifest.at("files")) {
    const auto size = file.at("bytes").get<std::uint64_t>();
    std::error_code error;
    if (fs::file_size(plan.arguments.out / file.at("path").get<std::string>(), error) != size || error)
      return std::nullopt;
    result.bytes += size;
  }
  return result;
}

// Whole, or what of it is still missing.
void MakeSequence(const DatasetPlan& plan, int number, int threads, Journal& journal) {
  const Journal::Key tables(number, Journal::kTables, 0);
  if (journal.Find(tables)) return;
  const LoadedScenario loaded = ScenarioOf(plan, number);
  Sequence sequence = BeginSequence(plan, loaded, number);
  if (plan.trajectory)
    FlyTrajectory(plan, loaded.simulator, journal, sequence);
  else
    FlyMission(plan, loaded.scenario.seed, threads, journal, sequence);
  std::vector<SetFile> files = plan.format->Tables(sequence);
  if (sequence.extras.segmentation) files.push_back({sequence.folder + "geoms.csv", GeomTable(loaded)});
  journal.Write(tables, files, {});
}

}  // namespace

DatasetResult MakeDataset(const DatasetPlan& plan) {
  const DatasetArguments& a = plan.arguments;
  const WriterLock alone = LockFolder(a.out);
  if (const auto complete = CompleteSet(plan)) return *complete;
  WriteFile(a.out / "settings.txt", plan.settings);
  Journal journal(a.out);
  if (plan.trajectory) {  // its frames share the jobs
    for (int i = 0; i < a.count; ++i) MakeSequence(plan, i, 0, journal);
  } else {
    const int flights = std::min(a.jobs, a.count), each = a.jobs / flights;
    InParallel(static_cast<std::size_t>(a.count), flights, "data set", "flights",
               [&](std::size_t i) { MakeSequence(plan, static_cast<int>(i), each > 1 ? each : 0, journal); });
  }
  const std::vector<WrittenFile> files = journal.Files();
  WriteFile(a.out / "manifest.json", ManifestOf(plan, files, journal.frames()));
  DatasetResult result{static_cast<std::size_t>(a.count), journal.frames(), files.size(), journal.found(), 0};
  for (const WrittenFile& f : files) result.bytes += f.size;
  journal.Remove();
  return result;
}

}  // namespace kestrel::flight
