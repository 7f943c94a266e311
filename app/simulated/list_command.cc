// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/list_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <vector>

#include "app/option/one_of.h"
#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "base/printable.h"
#include "base/user_file.h"
#include "base/yaml/config.h"
#include "campaign/named_file.h"
#include "flight/simulated/scenario.h"
#include "mission/mission_type.h"
#include "records/telemetry/metrics.h"
#include "scenarios/flights.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Item {
  std::string name, description;
  std::string error = {};      // why it is not valid
  Json more = Json::object();  // what programs may want of it
};
using Items = std::vector<Item>;

struct Kind {
  const char* name;
  std::vector<std::string> (*names)();
  Item (*item)(const std::string& name);
};

fs::path FileOf(Model model, std::string name) {
  Mistakes none;
  return ModelFile(model, name, "", "", none).value_or("");
}

// Of a YAML file of ours, or a calibration file of others, which may have none.
Item ItemOf(const std::string& name, const fs::path& file) {
  Mistakes mistakes;
  const Config config = LoadConfig(file, {}, mistakes);
  Item item{name, config.description};
  if (!mistakes.empty()) item.error = InputError(mistakes.all()).what();
  item.more["file"] = file.string();
  return item;
}

Item ScenarioItem(const std::string& name) {
  Item item = ItemOf(name, ScenarioFile(name));
  try {
    const flight::Scenario s = flight::LoadScenario(name, {}, false).scenario;
    item.more.update({{"mission", s.mission},
                      {"duration_s", s.duration_s},
                      {"vehicle", s.vehicle},
                      {"camera", s.camera},
                      {"world", s.world}});
  } catch (const InputError& e) {
    item.error = e.what();
  }
  return item;
}

// Of a world in MJCF: <custom><text name="description" data="..."/></custom>.
Item WorldItem(const std::string& name) {
  const fs::path file = FileOf(Model::kWorld, name);
  if (file.extension() != ".xml") return ItemOf(name, file);
  const FileContent content = ReadUserFile(file, kMaxTextBytes);
  Item item{name, "", content.error.empty() ? "" : fmt::format("{}: {}", file.string(), content.error)};
  item.more["file"] = file.string();
  pugi::xml_document document;
  if (!document.load_buffer(content.bytes.data(), content.bytes.size())) return item;
  const pugi::xml_node custom = document.document_element().child("custom");
  item.description = custom.find_child_by_attribute("text", "name", "description").attribute("data").value();
  return item;
}

Item MetricItem(const std::string& name) {
  const std::vector<mission::Metric> all = records::AllMetrics();
  const auto metric = std::find_if(all.begin(), all.end(), [&](const auto& m) { return m.name == name; });
  Item item{name, metric->description};
  item.more["unit"] = metric->unit;
  return item;
}

Item MissionItem(const std::string& name) {
  mission::Flight flight;
  mission::SelectMission(name, flight);
  Item item{name, flight.type().summary};
  item.more["metrics"] = NamesOf(flight.type().metrics);
  return item;
}

template <const char* kind>
Item CampaignItem(const std::string& name) {
  return ItemOf(name, campaign::NamedFile(kind, name));
}

constexpr char kCampaign[] = "campaign", kTuning[] = "tuning";

const std::vector<Kind>& Kinds() {
  static const std::vector<Kind> kKinds = {
      {"scenarios", ScenarioNames, ScenarioItem},
      {"missions", mission::MissionNames, MissionItem},
      {"metrics", [] { return NamesOf(records::AllMetrics()); }, MetricItem},
      {"vehicles", [] { return ModelNames(Model::kVehicle); },
       [](const std::string& name) { return ItemOf(name, FileOf(Model::kVehicle, name)); }},
      {"worlds", [] { return ModelNames(Model::kWorld); }, WorldItem},
      {"cameras", [] { return ModelNames(Model::kCamera); },
       [](const std::string& name) { return ItemOf(name, FileOf(Model::kCamera, name)); }},
      {"pads", [] { return ModelNames(Model::kPad); },
       [](const std::string& name) { return ItemOf(name, FileOf(Model::kPad, name)); }},
      {"campaigns", [] { return campaign::NamesOfKind(kCampaign); }, CampaignItem<kCampaign>},
      {"tunings", [] { return campaign::NamesOfKind(kTuning); }, CampaignItem<kTuning>}};
  return kKinds;
}

const Kind& KindNamed(const std::string& name) {
  scenarios::AddFlights();
  return *std::find_if(Kinds().begin(), Kinds().end(), [&](const Kind& kind) { return kind.name == name; });
}

Items ItemsOf(const Kind& kind) {
  Items items;
  for (const std::string& name : kind.names()) items.push_back(kind.item(name));
  return items;
}

std::string ToJson(const Items& items) {
  Json all = Json::array();
  for (const Item& item : items) {
    Json each = {{"name", item.name}, {"description", item.description}};
    each.update(item.more);
    if (!item.error.empty()) each["error"] = item.error;
    all.push_back(std::move(each));
  }
  return all.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace

CLI::App* AddListCommand(CLI::App& app, ListArguments& a) {
  CLI::App* command = app.add_subcommand("list", "Show what there is, with a sentence each");
  std::vector<std::string> kinds;
  for (const Kind& kind : Kinds()) kinds.push_back(kind.name);
  command->add_option("kind", a.kind, "What of")->check(OneOf(kinds))->capture_default_str();
  CLI::Option* json = command->add_flag("--json", a.json, "As JSON, with what programs may want");
  command->add_flag("--names", a.names, "The names alone")->excludes(json);
  command->footer("Examples:\n  kestrel list\n  kestrel list metrics\n  kestrel list scenarios --json");
  return command;
}

std::string ListText(const std::string& kind) {
  const Items items = ItemsOf(KindNamed(kind));
  std::size_t widest = 0, widest_unit = 0;
  const auto unit = [](const Item& item) { return item.more.value("unit", ""); };
  for (const Item& item : items)
    widest = std::max(widest, item.name.size()), widest_unit = std::max(widest_unit, unit(item).size());
  std::string text;
  for (const Item& item : items) {
    const std::string column = widest_unit > 0 ? fmt::format("  {:<{}}", unit(item), widest_unit) : "";
    text += fmt::format("{:<{}}{}  {}\n", item.name, widest, column,
                        item.error.empty() ? Printable(item.description) : "not valid: " + item.error);
  }
  return text;
}

void ListCommand(const ListArguments& a) {
  const Kind& kind = KindNamed(a.kind);
  const std::vector<std::string> names = kind.names();
  if (names.empty())
    throw InputError("KESTREL_ROOT", fmt::format("'{}' holds no {}", Root().string(), a.kind));
  if (a.names)
    for (const std::string& name : names) fmt::print("{}\n", name);
  else
    fmt::print("{}", a.json ? ToJson(ItemsOf(kind)) : ListText(a.kind));
}

}  // namespace kestrel::app
