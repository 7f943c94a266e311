// SPDX-License-Identifier: Apache-2.0
#include "app/reproduce/thesis_items.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <regex>
#include <set>

#include "base/diagnostics.h"
#include "base/file/data_folders.h"
#include "base/nearest_name.h"
#include "base/yaml/config.h"
#include "base/yaml/yaml_fields.h"
#include "flight/simulated/possible_metrics.h"

namespace kestrel::app {
namespace {

void CheckItem(const Thesis& thesis, const ThesisItem& item, const std::string& key, const Place& where,
               const std::vector<std::string>& metrics, Mistakes& mistakes) {
  if (item.flights.empty() == item.none.empty())
    mistakes.Add(where, key, "has neither flights nor a reason why there are none, or both",
                 "valid: flights, or none: with the reason");
  static const std::regex kName("(figure|table)-[0-9a-z]\\.[0-9]{1,3}");
  for (const std::string& name : item.names)
    if (!std::regex_match(name, kName))
      mistakes.Add(where, key + ".names", fmt::format("'{}' is no name", name),
                   "valid: figure or table with its number, such as figure-3.7");
  for (const std::string& flight : item.flights)
    if (!thesis.flights.contains(flight))
      mistakes.Add(where, key + ".flights", fmt::format("'{}' is none of the flights above", flight), "");
  for (const ThesisValue& value : item.values) {
    if (std::find(metrics.begin(), metrics.end(), value.metric) == metrics.end())
      mistakes.Add(where, key + ".values", fmt::format("'{}' is no metric", value.metric),
                   "valid: one that kestrel list metrics has");
    if (value.thesis.size() > item.flights.size())
      mistakes.Add(
          where, key + ".values",
          fmt::format("{} numbers of the thesis for {} flights", value.thesis.size(), item.flights.size()),
          "valid: one for each");
  }
}

}  // namespace

std::filesystem::path ThesisFile() { return DataFile("app/reproduce/thesis.yaml"); }

Thesis LoadThesis(const std::filesystem::path& file) {
  Mistakes mistakes;
  Thesis thesis;
  const Config config = LoadConfig(file, {}, mistakes);
  Read(config, thesis, mistakes);
  mistakes.ThrowIfAny();
  const std::vector<std::string> metrics = flight::KnownMetrics();
  std::set<std::string> names;
  for (std::size_t i = 0; i < thesis.items.size(); ++i) {
    const Place where{file.string(), 0};
    CheckItem(thesis, thesis.items[i], fmt::format("items.{}", i), where, metrics, mistakes);
    for (const std::string& name : thesis.items[i].names)
      if (!names.insert(name).second)
        mistakes.Add(where, fmt::format("items.{}.names", i), fmt::format("'{}' a second time", name), "");
  }
  mistakes.ThrowIfAny();
  return thesis;
}

std::vector<const ThesisItem*> Chosen(const Thesis& thesis, const std::vector<std::string>& names) {
  std::vector<std::string> all;
  for (const ThesisItem& item : thesis.items) all.insert(all.end(), item.names.begin(), item.names.end());
  std::set<std::string> wanted;
  Mistakes mistakes;
  for (std::string name : names) {
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    std::replace(name.begin(), name.end(), ' ', '-');
    if (!name.starts_with("figure-") && !name.starts_with("table-")) name = "figure-" + name;
    if (std::find(all.begin(), all.end(), name) != all.end()) {
      wanted.insert(name);
      continue;
    }
    mistakes.Add("kestrel reproduce", "",
                 fmt::format("'{}' is none of the thesis's figures and tables", name),
                 RemedyForName(name, all));
  }
  mistakes.ThrowIfAny();
  std::vector<const ThesisItem*> chosen;
  for (const ThesisItem& item : thesis.items)
    if (names.empty() || std::any_of(item.names.begin(), item.names.end(),
                                     [&](const std::string& name) { return wanted.contains(name); }))
      chosen.push_back(&item);
  return chosen;
}

std::string TitleOf(const ThesisItem& item) {
  struct Run {
    std::string kind, chapter;
    int first = 0, last = 0;
  };
  std::vector<Run> runs;
  for (const std::string& name : item.names) {
    const std::size_t dash = name.find('-'), dot = name.find('.');
    std::string chapter = name.substr(dash + 1, dot - dash - 1);
    chapter[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(chapter[0])));
    const int number = std::stoi(name.substr(dot + 1));
    const std::string kind = name.substr(0, dash);
    if (!runs.empty() && runs.back().kind == kind && runs.back().chapter == chapter &&
        runs.back().last + 1 == number)
      runs.back().last = number;
    else
      runs.push_back({kind, chapter, number, number});
  }
  std::string title;
  for (const Run& run : runs) {
    title += fmt::format("{}{} {}.{}", title.empty() ? "" : ", ",
                         run.kind + (run.last > run.first ? "s" : ""), run.chapter, run.first);
    if (run.last > run.first)
      title += fmt::format(" {} {}.{}", run.last > run.first + 1 ? "to" : "and", run.chapter, run.last);
  }
  title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
  return title;
}

std::string CommandOf(const ThesisFlight& flight, std::uint64_t seed) {
  std::string command = fmt::format("kestrel run {} --seed {}", flight.scenario, seed);
  for (const std::string& set : flight.set) {
    const bool plain = set.find_first_of(" []{}'\"") == std::string::npos;
    command += plain ? " --set " + set : fmt::format(" --set '{}'", set);
  }
  return command;
}

}  // namespace kestrel::app
