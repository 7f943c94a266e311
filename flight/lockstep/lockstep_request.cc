// SPDX-License-Identifier: Apache-2.0
#include "flight/lockstep/lockstep_request.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/nearest_name.h"
#include "base/printable.h"

namespace kestrel::flight {
namespace {

using ReceivedJson = nlohmann::json;
using Keys = std::vector<std::string>;

constexpr std::size_t kLongestText = 100;
constexpr double kWholeUntil = 9007199254740992;  // 2^53: to there a double has every whole number

// Of texts that others sent: short, and without commands to a terminal.
std::string Shown(const std::string& text) { return Printable(text.substr(0, kLongestText)); }

[[noreturn]] void Refuse(const std::string& what) { throw LockstepError("value", what); }

// An object whose keys are read by name; what it holds beside them is refused.
class Object {
 public:
  Object(const ReceivedJson& json, std::string name, const Keys& keys) : json_(json), name_(std::move(name)) {
    if (!json.is_object()) Refuse(fmt::format("{} is no object", name_));
    for (const auto& [key, value] : json.items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end())
        Refuse(fmt::format("{} has no key '{}'; {}", name_, Shown(key), RemedyForName(key, keys)));
  }

  // An absent key and null are the same.
  bool Has(const char* key) const { return json_.contains(key) && !json_.at(key).is_null(); }
  const ReceivedJson& At(const char* key) const {
    if (!Has(key)) Refuse(fmt::format("{} is missing", Of(key)));
    return json_.at(key);
  }
  double Number(const char* key) const { return Number(At(key), Of(key)); }
  Eigen::VectorXd Numbers(const char* key, int count) const {
    const ReceivedJson& list = At(key);
    if (!list.is_array() || list.size() != static_cast<std::size_t>(count))
      Refuse(fmt::format("{} is no list of {} numbers", Of(key), count));
    Eigen::VectorXd numbers(count);
    for (int i = 0; i < count; ++i)
      numbers[i] = Number(list.at(static_cast<std::size_t>(i)), fmt::format("{}[{}]", Of(key), i));
    return numbers;
  }
  std::uint64_t Whole(const char* key) const {
    const ReceivedJson& value = At(key);
    if (value.is_number_unsigned()) return value.get<std::uint64_t>();
    // Languages of one kind of number write 3.0.
    if (value.is_number_float()) {
      const double number = value.get<double>();
      if (number >= 0 && number <= kWholeUntil && number == std::floor(number))
        return static_cast<std::uint64_t>(number);
    }
    Refuse(fmt::format("{} is no whole number from 0 to 2^64 - 1", Of(key)));
  }
  bool Flag(const char* key, bool absent) const {
    if (!Has(key)) return absent;
    if (!At(key).is_boolean()) Refuse(fmt::format("{} is neither true nor false", Of(key)));
    return At(key).get<bool>();
  }
  std::string Text(const char* key) const {
    if (!At(key).is_string()) Refuse(fmt::format("{} is no text", Of(key)));
    const auto text = At(key).get<std::string>();
    if (text.size() > kLongestText || HasControl(text))
      Refuse(fmt::format("{} is longer than {} bytes, or has characters that cannot be shown", Of(key),
                         kLongestText));
    return text;
  }

 private:
  std::string Of(const char* key) const { return name_ + "." + key; }
  static double Number(const ReceivedJson& value, const std::string& of) {
    if (!value.is_number()) Refuse(fmt::format("{} is no number", of));
    const double number = value.get<double>();
    if (!std::isfinite(number)) Refuse(fmt::format("{} is not finite", of));
    return number;
  }

  const ReceivedJson& json_;
  std::string name_;
};

control::Setpoint SetpointOf(const ReceivedJson& json) {
  if (!json.is_object() || !json.contains("kind") || !json.at("kind").is_string())
    Refuse("setpoint.kind is missing; valid: velocity, position, attitude, rates");
  const auto kind = json.at("kind").get<std::string>();
  if (kind == "velocity") {
    const Object o(json, "setpoint", {"kind", "v_H_m_s", "yaw_rate_rad_s"});
    return control::VelocitySetpoint{o.Numbers("v_H_m_s", 3), o.Number("yaw_rate_rad_s")};
  }
  if (kind == "position") {
    const Object o(json, "setpoint", {"kind", "p_N_m", "yaw_rad"});
    return control::PositionSetpoint{o.Numbers("p_N_m", 3), o.Number("yaw_rad")};
  }
  if (kind == "attitude") {
    const Object o(json, "setpoint", {"kind", "roll_rad", "pitch_rad", "yaw_rate_rad_s", "thrust"});
    return control::AttitudeSetpoint{o.Number("roll_rad"), o.Number("pitch_rad"), o.Number("yaw_rate_rad_s"),
                                     o.Number("thrust")};
  }
  if (kind == "rates") {
    const Object o(json, "setpoint", {"kind", "w_B_rad_s", "thrust"});
    return control::RateSetpoint{o.Numbers("w_B_rad_s", 3), o.Number("thrust")};
  }
  Refuse(fmt::format("setpoint.kind is '{}'; valid: velocity, position, attitude, rates", Shown(kind)));
}

std::optional<control::Setpoint> SetpointIn(const Object& o) {
  if (!o.Has("setpoint")) return std::nullopt;
  return SetpointOf(o.At("setpoint"));
}

control::AttitudeAid AidOf(const ReceivedJson& json) {
  const Object o(json, "aid", {"q_NB", "sigma_rad"});
  const Eigen::VectorXd q = o.Numbers("q_NB", 4);
  if (std::abs(q.norm() - 1) > 1e-6)
    Refuse(fmt::format("aid.q_NB has the length {:.6g}: a rotation's is 1", q.norm()));
  const double sigma = o.Number("sigma_rad");
  if (!(sigma >= 0)) Refuse("aid.sigma_rad is negative");
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), sigma};
}

HelloRequest HelloOf(const ReceivedJson& json) {
  // Before its keys: another version may have others.
  if (!json.contains("version") || json.at("version") != kLockstepVersion)
    throw LockstepError(
        "version",
        fmt::format("hello.version is {}: this server speaks version {}",
                    json.contains("version") ? Shown(json.at("version").dump(
                                                   -1, ' ', true, ReceivedJson::error_handler_t::replace))
                                             : "missing",
                    kLockstepVersion));
  const Object o(json, "hello", {"request", "version", "client", "inline", "token"});
  return {o.Has("client") ? o.Text("client") : "", o.Flag("inline", false)};
}

ResetRequest ResetOf(const ReceivedJson& json) {
  const Object o(json, "reset", {"request", "token", "seed", "images", "surfaces", "records"});
  ResetRequest reset;
  if (o.Has("seed")) reset.seed = o.Whole("seed");
  reset.images = o.Flag("images", true);
  reset.surfaces = o.Flag("surfaces", false);
  reset.records = o.Flag("records", true);
  if (reset.surfaces && !reset.images) Refuse("reset.surfaces are of images: reset.images is false");
  return reset;
}

StepRequest StepOf(const ReceivedJson& json) {
  const Object o(json, "step", {"request", "token", "setpoint", "aid"});
  StepRequest step{SetpointIn(o), {}};
  if (o.Has("aid")) step.aid = AidOf(o.At("aid"));
  return step;
}

AdvanceRequest AdvanceOf(const ReceivedJson& json) {
  const Object o(json, "advance", {"request", "token", "duration_s", "setpoint"});
  return {o.Number("duration_s"), SetpointIn(o)};
}

FinishRequest FinishOf(const ReceivedJson& json) {
  const Object o(json, "finish", {"request", "token", "outcome"});
  FinishRequest finish{o.Text("outcome")};
  if (finish.outcome.empty()) Refuse("finish.outcome is empty");
  return finish;
}

template <class Request>
Request Bare(const ReceivedJson& json, const char* name) {
  Object(json, name, {"request", "token"});
  return {};
}

decltype(LockstepRequest::body) BodyOf(const std::string& name, const ReceivedJson& json) {
  if (name == "hello") return HelloOf(json);
  if (name == "reset") return ResetOf(json);
  if (name == "step") return StepOf(json);
  if (name == "advance") return AdvanceOf(json);
  if (name == "decide") return Bare<DecideRequest>(json, "decide");
  if (name == "truth") return Bare<TruthRequest>(json, "truth");
  if (name == "summary") return Bare<SummaryRequest>(json, "summary");
  if (name == "finish") return FinishOf(json);
  if (name == "bye") return Bare<ByeRequest>(json, "bye");
  const Keys names = {"hello", "reset", "step", "advance", "decide", "truth", "summary", "finish", "bye"};
  throw LockstepError("request",
                      fmt::format("there is no request '{}'; {}", Shown(name), RemedyForName(name, names)));
}

}  // namespace

LockstepRequest ParseLockstepRequest(std::string_view text) {
  ReceivedJson json;
  try {
    json = ReceivedJson::parse(text);
  } catch (const ReceivedJson::exception& e) {
    throw LockstepError("message", fmt::format("the message is no JSON: {}", Printable(e.what())));
  }
  if (!json.is_object() || !json.contains("request") || !json.at("request").is_string())
    throw LockstepError("message", "the message is no object with the text 'request'");
  LockstepRequest request;
  const auto name = json.at("request").get<std::string>();
  if (json.contains("token") && name != "hello") {
    Keys all;
    for (const auto& [key, value] : json.items()) all.push_back(key);
    request.token = Object(json, name.substr(0, kLongestText), all).Whole("token");
  }
  try {
    request.body = BodyOf(name, json);
  } catch (LockstepError& e) {
    e.token = request.token;
    throw;
  }
  return request;
}

}  // namespace kestrel::flight
