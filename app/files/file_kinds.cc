// SPDX-License-Identifier: Apache-2.0
#include "app/files/file_kinds.h"

#include <algorithm>
#include <variant>

#include "base/yaml/config.h"
#include "campaign/table/campaign_plan.h"
#include "campaign/tuning/tune_plan.h"
#include "flight/hardware/aircraft.h"
#include "flight/simulated/scenario.h"
#include "mission/mission_type.h"
#include "scenarios/flights.h"
#include "sim/landscape/landscape.h"
#include "sim/vehicle_file.h"
#include "sim/world/world_file.h"
#include "vision/camera/camera_model.h"
#include "vision/landmark/pad_file.h"

namespace kestrel::app {
namespace {

using Descriptions = std::vector<FieldDescription>;

FieldDescription Text(const char* key, const char* meaning, const char* value = "\"\"") {
  return {.key = key, .meaning = meaning, .kind = FieldKind::kText, .value = value};
}

// Which every file may have.
Descriptions WithDescription(Descriptions fields) {
  fields.insert(fields.begin(), Text(kDescriptionKey, "what the file is, in one sentence, for lists"));
  return fields;
}

// Of what is as the model has it that the file names.
void ForgetValues(Descriptions& fields) {
  for (FieldDescription& each : fields) {
    each.value.clear();
    ForgetValues(each.fields);
  }
}

FileKind Scenarios() {
  FileKind kind{.name = "scenario",
                .summary = "a flight: its mission, world, aircraft, camera, and what it must keep to",
                .selector = "mission"};
  scenarios::AddFlights();
  for (const mission::Flight& each : mission::Missions()) {
    flight::Scenario scenario;
    scenario.mission = each.type().name;
    Descriptions fields = WithDescription(Describe(scenario));
    for (FieldDescription& field : fields)
      if (field.key == "autopilot" || field.key == "platform" || field.key == "landscape")
        ForgetValues(field.fields);
    fields.push_back(Text(
        "gains", "a file of lines key.path: value, such as a tuning writes, which stand over the keys here"));
    kind.variants.push_back({scenario.mission, std::move(fields)});
  }
  return kind;
}

FileKind Vehicles() {
  FileKind kind{.name = "vehicle",
                .summary = "the numbers of an aircraft, beside the MJCF file of its shape",
                .selector = "kind"};
  for (const char* name : {"multirotor", "helicopter"}) {
    sim::VehicleFile vehicle;
    vehicle.kind = name;
    kind.variants.push_back({name, WithDescription(Describe(vehicle))});
  }
  return kind;
}

FileKind Cameras() {
  FileKind kind{.name = "camera", .summary = "a camera model with its parameters", .selector = "model"};
  const std::vector<vision::CameraModel> models = vision::CameraModels();
  FieldDescription model = Text("model", "how the lens projects", vision::NameOf(models.front()));
  for (const vision::CameraModel& each : models) model.valid.emplace_back(vision::NameOf(each));
  for (const vision::CameraModel& each : models) {
    Descriptions fields = std::visit([](const auto& camera) { return Describe(camera); }, each);
    fields.insert(fields.begin(), model);
    kind.variants.push_back({vision::NameOf(each), WithDescription(std::move(fields))});
  }
  return kind;
}

FileKind Plain(const char* name, const char* summary, Descriptions fields,
               std::map<std::string, std::string> examples = {}) {
  return {.name = name,
          .summary = summary,
          .selector = "",
          .variants = {{"", WithDescription(std::move(fields))}},
          .examples = std::move(examples)};
}

}  // namespace

const std::vector<FileKind>& FileKinds() {
  static const std::vector<FileKind> kinds = {
      Scenarios(),
      Plain("campaign", "a Monte-Carlo study: what varies from run to run of a scenario",
            campaign::DescribeCampaignFile(), {{"scenario", "landing"}}),
      Plain("tuning", "a search for gains that fly a scenario at the lowest cost",
            campaign::DescribeTuneFile(),
            {{"scenario", "landing"},
             {"gains", "{pilot.servo.lambda_per_s: {low: 1, high: 4}}"},
             {"cost", "{touchdown_error_m: {scale: 0.05}}"}}),
      Vehicles(),
      Cameras(),
      Plain("world", "a landscape that is made from numbers, or a model; and what is put into it",
            Describe(sim::WorldFile{})),
      Plain("pad", "a landing pad, beside its picture", Describe(vision::PadParameters{})),
      Plain("aircraft", "a real aircraft: its limits, its camera and its links, for `fly`",
            Describe(flight::Aircraft{}))};
  return kinds;
}

std::vector<std::string> FileKindNames() {
  return {"scenario", "campaign", "tuning", "vehicle", "camera", "world", "pad", "aircraft"};
}

const FileKind& FileKindNamed(const std::string& name) {
  return *std::find_if(FileKinds().begin(), FileKinds().end(),
                       [&](const FileKind& each) { return each.name == name; });
}

Descriptions CommonFields(const FileKind& kind) {
  Descriptions common;
  for (const FieldDescription& field : kind.variants.front().fields) {
    const bool everywhere = std::all_of(kind.variants.begin(), kind.variants.end(), [&](const auto& variant) {
      return std::find(variant.fields.begin(), variant.fields.end(), field) != variant.fields.end();
    });
    if (everywhere || field.key == kind.selector) common.push_back(field);
  }
  return common;
}

Descriptions OwnFields(const FileKind& kind, const FileKind::Variant& variant) {
  const Descriptions common = CommonFields(kind);
  Descriptions own;
  for (const FieldDescription& field : variant.fields)
    if (std::none_of(common.begin(), common.end(), [&](const auto& each) { return each.key == field.key; }))
      own.push_back(field);
  return own;
}

}  // namespace kestrel::app
