// SPDX-License-Identifier: Apache-2.0
#include "flight/lockstep/lockstep_session.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "base/stopwatch.h"
#include "base/version.h"
#include "flight/lockstep/lockstep_reply.h"
#include "records/summary.h"
#include "vision/camera/camera_model.h"

namespace kestrel::flight {
namespace {

using Json = nlohmann::ordered_json;

// Numbers that are not finite are null, bytes that are no UTF-8 are replaced.
std::string Text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

const char* TypeOf(const cv::Mat& picture) {
  return picture.depth() == CV_8U ? "uint8" : picture.depth() == CV_32S ? "int32" : "float32";
}

Json Layout(const cv::Mat& picture, std::size_t offset) {
  const std::size_t row = static_cast<std::size_t>(picture.cols) * picture.elemSize();
  Json shape = {picture.rows, picture.cols}, strides = {row, picture.elemSize()};
  if (picture.channels() > 1) {
    shape.push_back(picture.channels());
    strides.push_back(picture.elemSize1());
  }
  return {{"type", TypeOf(picture)}, {"shape", shape}, {"strides", strides}, {"offset", offset}};
}

// What the work gives; how long it took, s, is added.
template <class Work>
auto Timed(double& took_s, Work work) {
  const auto began = std::chrono::steady_clock::now();
  auto result = work();
  took_s += SecondsSince(began);
  return result;
}

}  // namespace

LockstepSession::LockstepSession(const LockstepOptions& options, const LoadedScenario& loaded)
    : options_(options), loaded_(loaded), sim_options_(options.sim) {}
LockstepSession::~LockstepSession() = default;

LockstepSession::Reply LockstepSession::Answer(std::string_view text) {
  std::optional<std::uint64_t> answers;
  pictures_.clear();
  simulator_s_ = 0;
  try {
    const LockstepRequest request = ParseLockstepRequest(text);
    answers = request.token;
    RequireToken(request);
    Json json = {{"ok", true}, {"answers", nullptr}, {"token", token_ + 1}};
    if (answers) json["answers"] = *answers;
    json.update(std::visit([this](const auto& body) { return Do(body); }, request.body));
    json["simulator_s"] = simulator_s_;
    if (!pictures_.empty()) json["bytes"] = PictureBytes(pictures_);
    ++token_;
    return {Text(json), std::move(pictures_), farewell_};
  } catch (const LockstepError& e) {
    return Refuse(e.kind, e.what(), answers ? answers : e.token);
  } catch (const SimError& e) {
    return Refuse("state", e.what(), answers);
  } catch (
      const std::exception& e) {  // of the physics, of the records, of a scenario that is no longer there
    std::string what = e.what();
    try {
      if (under_way_) End(what);
    } catch (const std::exception& also) {
      what = also.what();
    }
    return Refuse("broke off", what, answers);
  }
}

LockstepSession::Reply LockstepSession::Refuse(const char* kind, const std::string& what,
                                               std::optional<std::uint64_t> answers) const {
  Json json = {{"ok", false}, {"answers", nullptr}, {"token", token_}};
  if (answers) json["answers"] = *answers;
  json["error"] = {{"kind", kind}, {"message", what}};
  return {Text(json), {}, false};
}

void LockstepSession::RequireToken(const LockstepRequest& request) const {
  const bool hello = std::holds_alternative<HelloRequest>(request.body);
  if (token_ == 0 && !hello) throw LockstepError("state", "the first request is hello");
  if (hello && token_ > 0) throw LockstepError("state", "hello is the first request, and comes once");
  if (hello) return;
  if (!request.token)
    throw LockstepError("token", fmt::format("the request has no token: the last reply gave {}", token_));
  if (*request.token != token_)
    throw LockstepError("token",
                        fmt::format("token {} {}: the last reply gave {}", *request.token,
                                    *request.token < token_ ? "was used before" : "was never given", token_));
}

Sim& LockstepSession::Flight() {
  if (!sim_) throw LockstepError("state", "no flight has begun: send reset first");
  return *sim_;
}

Json LockstepSession::Do(const HelloRequest& request) {
  client_ = request.client;
  inline_images_ = request.inline_images;
  const vision::CameraModel& camera = loaded_.simulator.camera;
  const Scenario& scenario = loaded_.scenario;
  options_.say(fmt::format("client{}{}", client_.empty() ? "" : " ", client_));
  return {{"version", kLockstepVersion},
          {"kestrel", Version()},
          {"scenario", scenario.name},
          {"seed", scenario.seed},
          {"duration_s", scenario.duration_s},
          {"camera",
           {{"width_px", vision::WidthPx(camera)},
            {"height_px", vision::HeightPx(camera)},
            {"channels", loaded_.simulator.image.colour ? 3 : 1},
            {"rate_hz", scenario.image.rate_hz},
            {"latency_s", scenario.image.latency_s}}}};
}

Json LockstepSession::Do(const ResetRequest& request) {
  if (under_way_) {
    sim_->Finish("reset");
    End("");
  }
  if (request.seed) sim_options_.seed = request.seed;
  if (!sim_ || sim_options_.images != request.images || sim_options_.surfaces != request.surfaces) {
    sim_options_.images = request.images;
    sim_options_.surfaces = request.surfaces;
    sim_.reset();
    sim_ = std::make_unique<Sim>(options_.scenario, sim_options_);
  }
  summary_.reset();
  folder_.clear();
  const Observation first = Timed(simulator_s_, [&] { return sim_->Reset(sim_options_.seed); });
  under_way_ = true;
  if (request.records) BeginRecords(first);
  Json json = {{"dt_s", sim_->dt_s()}, {"seed", sim_->scenario().scenario.seed}, {"folder", nullptr}};
  if (!folder_.empty()) json["folder"] = folder_.string();
  if (sim_->done()) End("");
  json.update(Observed(first));
  return json;
}

void LockstepSession::BeginRecords(const Observation& first) {
  const std::filesystem::path folder = options_.folder(sim_->scenario().scenario.seed);
  recorded_.emplace(*sim_, first, folder, options_.video && sim_options_.images);
  folder_ = folder;
  recorded_->Note("client", client_.empty() ? "lockstep" : client_);
}

Json LockstepSession::Do(const StepRequest& request) {
  Sim& sim = Flight();
  return Observed(Timed(simulator_s_, [&] { return sim.Step(request.setpoint, request.aid); }));
}

Json LockstepSession::Do(const AdvanceRequest& request) {
  Sim& sim = Flight();
  return Observed(Timed(simulator_s_, [&] { return sim.Advance(request.duration_s, request.setpoint); }));
}

Json LockstepSession::Observed(const Observation& observation) {
  if (under_way_) {
    if (recorded_) recorded_->Write(observation);
    if (sim_->done()) End("");
  }
  Json json = {{"t_s", sim_->t_s()},
               {"done", sim_->done()},
               {"outcome", sim_->outcome()},
               {"frame", nullptr},
               {"state", LockstepJson(observation.state)}};
  if (observation.frame)
    json["frame"] = FrameJson(*observation.frame, observation.surfaces, observation.flow);
  for (const sim::CameraFrame& other : sim_->camera_frames()) {
    Json frame = FrameJson(other.frame, other.surfaces, other.flow);
    frame["camera"] = other.name;
    json["frames"].push_back(frame);
  }
  if (Json readings = LockstepJson(sim_->readings()); !readings.empty())
    json["readings"] = std::move(readings);
  if (!inline_images_ && !pictures_.empty()) {
    memory_.Store(pictures_);
    pictures_.clear();
    json["memory"] = memory_.name();
    json["memory_bytes"] = memory_.size();
  }
  return json;
}

Json LockstepSession::FrameJson(const vision::Frame& frame, const sim::Surfaces& surfaces,
                                const cv::Mat& flow) {
  Json json = {{"sequence", frame.sequence}, {"t_s", frame.t_s}};
  const auto add = [&](const char* name, const cv::Mat& picture) {
    if (picture.empty()) return;
    json[name] = Layout(picture, PictureBytes(pictures_));
    pictures_.push_back(picture);
  };
  add("image", frame.image);
  add("depth", surfaces.depth_m);
  add("geom", surfaces.geom);
  add("flow", flow);
  return json;
}

Json LockstepSession::Do(const DecideRequest&) { return {{"decision", LockstepJson(Flight().Decide())}}; }

Json LockstepSession::Do(const TruthRequest&) {
  const Sim& sim = Flight();
  return {{"now", LockstepJson(sim.truth())},
          {"exposure", LockstepJson(sim.exposure())},
          {"imu", LockstepJson(sim.readings().truth)}};
}

Json LockstepSession::Do(const SummaryRequest&) {
  const Sim& sim = Flight();
  return {{"summary", Json::parse(records::ToJson(summary_ ? *summary_ : SummaryOf(sim, "")))}};
}

Json LockstepSession::Do(const FinishRequest& request) {
  Flight().Finish(request.outcome);
  End("");
  return Do(SummaryRequest{});
}

Json LockstepSession::Do(const ByeRequest&) {
  if (under_way_) {
    sim_->Finish("client left");
    End("");
  }
  farewell_ = true;
  return Json::object();
}

void LockstepSession::End(const std::string& error) {
  under_way_ = false;
  if (!sim_->done()) sim_->Finish("broke off");
  summary_ = SummaryOf(*sim_, error);
  if (!recorded_) return;
  try {
    summary_ = recorded_->Finish(error);
  } catch (const std::exception& e) {
    summary_->error = e.what();
    summary_->complete = summary_->passed = false;
    recorded_.reset();
    options_.say(e.what());
    throw;
  }
  recorded_.reset();
  options_.say(fmt::format("flight {}, seed {}: {}, {:.1f} s in {:.1f} s{}; {}", loaded_.scenario.name,
                           summary_->seed, summary_->outcome, summary_->sim_s, summary_->wall_s,
                           summary_->error.empty() ? "" : ": " + summary_->error, folder_.string()));
}

void LockstepSession::Leave(const std::string& why) {
  options_.say(why);
  if (!under_way_) return;
  try {
    End(why);
  } catch (const std::exception& e) {
    options_.say(e.what());
  }
}

}  // namespace kestrel::flight
