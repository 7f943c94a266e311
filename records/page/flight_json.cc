// SPDX-License-Identifier: Apache-2.0
#include "records/page/flight_json.h"

#include <nlohmann/json.hpp>

#include "records/summary.h"

namespace kestrel::records {
namespace {

using Json = nlohmann::ordered_json;

Json JsonOf(const Pose& X) {
  return {{"p", {X.p.x(), X.p.y(), X.p.z()}}, {"q", {X.R.w(), X.R.x(), X.R.y(), X.R.z()}}};
}

Json JsonOf(const std::optional<FlightSubject::Camera>& camera, const char* pose) {
  if (!camera) return {};
  return {{"name", camera->name},
          {"projection", camera->projection},
          {"size_px", {camera->width_px, camera->height_px}},
          {"fov_deg", {camera->h_deg, camera->v_deg}},
          {pose, JsonOf(camera->X)}};
}

Json JsonOf(const std::optional<FlightSubject::Pad>& pad) {
  if (!pad) return {};
  return {{"size_m", {pad->size_m.x(), pad->size_m.y()}},
          {"X_NT", pad->X_NT ? JsonOf(*pad->X_NT) : Json()},
          {"picture", pad->picture}};
}

}  // namespace

Json SubjectJson(const FlightSubject& s) {
  Json changeable = Json::array();
  for (const ChangeableKey& c : s.changeable) {
    Json choices = Json::array();
    for (const std::string& each : c.choices) choices.push_back(Json::parse(each));
    changeable.push_back({{"key", c.key},
                          {"meaning", c.meaning},
                          {"value", Json::parse(c.value)},
                          {"min", c.min ? Json(*c.min) : Json()},
                          {"max", c.max ? Json(*c.max) : Json()},
                          {"choices", choices}});
  }
  return {{"scenario", s.scenario},
          {"seed", s.seed},
          {"mode", s.mode},
          {"mission", s.mission},
          {"title", s.title},
          {"wanted", s.wanted},
          {"again", s.again},
          {"version", s.version},
          {"rate_hz", s.rate_hz},
          {"camera", JsonOf(s.camera, "X_BC")},
          {"ground_camera", JsonOf(s.ground_camera, "X_TC")},
          {"pad", JsonOf(s.pad)},
          {"changeable", changeable}};
}

Json OutcomeJson(const Summary& summary) {
  const Json all = Json::parse(ToJson(summary));
  Json outcome;
  for (const char* key : {"complete", "passed", "outcome", "error", "criteria", "metrics", "renderer",
                          "machine", "plugins", "state_hash", "image_hash"})
    outcome[key] = all.at(key);
  for (const char* key : {"sim_s", "wall_s", "stages"}) outcome[key] = all.at("timing").at(key);
  return outcome;
}

Json LiveJson(const FlightSubject& subject) {
  Json flight = SubjectJson(subject);
  flight.update(OutcomeJson({}));
  flight["events"] = Json::array();
  flight["columns"] = Json::object();
  flight["live"] = true;
  return flight;
}

}  // namespace kestrel::records
