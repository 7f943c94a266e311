// SPDX-License-Identifier: Apache-2.0
#include "control/wire/asctec.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "control/wire/crc16.h"

namespace kestrel::control::wire {
namespace {

constexpr std::uint16_t kCrcBegin = 0x00FF;
constexpr std::string_view kBegin = ">*>", kEnd = "<#<", kAckBegin = ">a", kAckEnd = "a<";
constexpr std::size_t kHeaderBytes = 6;
constexpr std::size_t kRcDataUnpadded = 33;

// The order of the fields on the wire, once for both directions.
template <class V>
void Layout(V& v, LlStatus& s) {
  v(s.battery_voltage_1, s.battery_voltage_2, s.status, s.cpu_load);
  v(s.compass_enabled, s.chksum_error, s.flying, s.motors_on, s.flightMode, s.up_time);
}
template <class V>
void Layout(V& v, ImuRawData& s) {
  v(s.pressure, s.gyro_x, s.gyro_y, s.gyro_z, s.mag_x, s.mag_y, s.mag_z, s.acc_x, s.acc_y, s.acc_z);
  v(s.temp_gyro, s.temp_ADC);
}
template <class V>
void Layout(V& v, ImuCalcData& s) {
  v(s.angle_nick, s.angle_roll, s.angle_yaw, s.angvel_nick, s.angvel_roll, s.angvel_yaw);
  v(s.acc_x_calib, s.acc_y_calib, s.acc_z_calib, s.acc_x, s.acc_y, s.acc_z);
  v(s.acc_angle_nick, s.acc_angle_roll, s.acc_absolute_value, s.Hx, s.Hy, s.Hz, s.mag_heading);
  v(s.speed_x, s.speed_y, s.speed_z, s.height, s.dheight, s.dheight_reference, s.height_reference);
}
template <class V>
void Layout(V& v, RcData& s) {
  for (auto& channel : s.channels_in) v(channel);
  for (auto& channel : s.channels_out) v(channel);
  v(s.lock);
}
template <class V>
void Layout(V& v, CtrlOut& s) {
  v(s.nick, s.roll, s.yaw, s.thrust);
}
template <class V>
void Layout(V& v, GpsData& s) {
  v(s.latitude, s.longitude, s.height, s.speed_x, s.speed_y, s.heading);
  v(s.horizontal_accuracy, s.vertical_accuracy, s.speed_accuracy, s.numSV, s.status);
}
template <class V>
void Layout(V& v, GpsDataAdvanced& s) {
  Layout(v, s.gps);
  v(s.latitude_best_estimate, s.longitude_best_estimate, s.speed_x_best_estimate, s.speed_y_best_estimate);
}
template <class V>
void Layout(V& v, CtrlInput& s) {
  v(s.pitch, s.roll, s.yaw, s.thrust, s.ctrl);
}

struct Writer {
  Bytes& bytes;
  void operator()(const auto&... fields) { (Append(bytes, fields), ...); }
};
struct Filler {
  Reader& reader;
  void operator()(auto&... fields) {
    ((fields = reader.Read<std::remove_reference_t<decltype(fields)>>()), ...);
  }
};

void AppendText(Bytes& bytes, std::string_view text) {
  for (const char c : text) bytes.push_back(static_cast<std::uint8_t>(c));
}

std::uint16_t CrcOf(std::span<const std::uint8_t> data) {
  Crc16 crc(kCrcBegin);
  crc.Add(data);
  return crc.sum();
}

template <class S>
Bytes Frame(S message) {
  Bytes data;
  Writer write{data};
  Layout(write, message);
  data.resize(S::kBytes);
  Bytes frame;
  frame.reserve(S::kBytes + kTelemetryOverhead);
  AppendText(frame, kBegin);
  Append(frame, static_cast<std::uint16_t>(S::kBytes));
  Append(frame, S::kDescriptor);
  for (const std::uint8_t byte : data) frame.push_back(byte);
  Append(frame, CrcOf(data));
  AppendText(frame, kEnd);
  return frame;
}
Bytes Frame(Acknowledgement message) {
  Bytes frame;
  AppendText(frame, kAckBegin);
  Append(frame, message.descriptor);
  AppendText(frame, kAckEnd);
  return frame;
}

// What the first of the unread bytes begins.
template <class Message>
struct Judgement {
  enum class Kind { kMore, kNothing, kRefused, kMessage };
  Kind kind;
  LinkRefusal why{};                 // of kRefused
  bool begun = false;                // of kMore: the mark that something begins with is there in full
  std::size_t bytes = 0;             // of kMessage
  std::optional<Message> message{};  // of kMessage

  static Judgement More(bool begun) { return {.kind = Kind::kMore, .begun = begun}; }
  static Judgement Nothing() { return {.kind = Kind::kNothing}; }
  static Judgement Refused(LinkRefusal why) { return {.kind = Kind::kRefused, .why = why}; }
  static Judgement Of(std::size_t bytes, Message message) {
    return {.kind = Kind::kMessage, .bytes = bytes, .message = std::move(message)};
  }
};

// Whether the bytes, so far as they go, are those of the text.
bool Agrees(std::span<const std::uint8_t> bytes, std::string_view text) {
  for (std::size_t i = 0; i < std::min(bytes.size(), text.size()); ++i)
    if (bytes[i] != static_cast<std::uint8_t>(text[i])) return false;
  return true;
}

template <class S>
Telemetry Read(std::span<const std::uint8_t> data) {
  Reader reader(data);
  Filler fill{reader};
  S message;
  Layout(fill, message);
  return message;
}

struct FrameKind {
  std::uint8_t descriptor;
  std::size_t shortest, longest;
  Telemetry (*read)(std::span<const std::uint8_t>);
};
template <class S>
constexpr FrameKind KindOf(std::size_t shortest = S::kBytes) {
  return {S::kDescriptor, shortest, S::kBytes, &Read<S>};
}
constexpr std::array kKinds = {
    KindOf<LlStatus>(), KindOf<ImuRawData>(), KindOf<ImuCalcData>(),    KindOf<RcData>(kRcDataUnpadded),
    KindOf<CtrlOut>(),  KindOf<GpsData>(),    KindOf<GpsDataAdvanced>()};

Judgement<Telemetry> JudgeFrame(std::span<const std::uint8_t> bytes) {
  using J = Judgement<Telemetry>;
  if (bytes.size() < kHeaderBytes) return J::More(bytes.size() >= kBegin.size());
  Reader header(bytes.subspan(kBegin.size()));
  const std::size_t length = header.Read<std::uint16_t>();
  const auto descriptor = header.Read<std::uint8_t>();
  for (const FrameKind& kind : kKinds) {
    if (kind.descriptor != descriptor) continue;
    if (length < kind.shortest || length > kind.longest) return J::Refused(LinkRefusal::kLength);
    if (bytes.size() < length + kTelemetryOverhead) return J::More(true);
    const auto data = bytes.subspan(kHeaderBytes, length);
    const auto behind = bytes.subspan(kHeaderBytes + length);
    if (Reader(behind).Read<std::uint16_t>() != CrcOf(data)) return J::Refused(LinkRefusal::kCheckSum);
    if (!Agrees(behind.subspan(sizeof(std::uint16_t)), kEnd)) return J::Refused(LinkRefusal::kTrailer);
    return J::Of(length + kTelemetryOverhead, kind.read(data));
  }
  return J::Refused(LinkRefusal::kUnknown);
}

Judgement<Telemetry> Judge(std::span<const std::uint8_t> bytes, Telemetry*) {
  using J = Judgement<Telemetry>;
  if (Agrees(bytes, kBegin)) return JudgeFrame(bytes);
  if (!Agrees(bytes, kAckBegin)) return J::Nothing();
  if (bytes.size() < kAcknowledgementBytes) return J::More(bytes.size() >= kAckBegin.size());
  if (!Agrees(bytes.subspan(kAckBegin.size() + 1), kAckEnd)) return J::Refused(LinkRefusal::kTrailer);
  return J::Of(kAcknowledgementBytes, Acknowledgement{bytes[kAckBegin.size()]});
}

Judgement<Command> Judge(std::span<const std::uint8_t> bytes, Command*) {
  using J = Judgement<Command>;
  constexpr std::string_view kRequest = "p", kCtrlInput = "di", kStop = "me";
  if (!Agrees(bytes, kBegin)) return J::Nothing();
  if (bytes.size() <= kBegin.size()) return J::More(bytes.size() == kBegin.size());
  const auto rest = bytes.subspan(kBegin.size());
  if (Agrees(rest, kRequest)) {
    if (bytes.size() < kRequestBytes) return J::More(true);
    const auto mask = Reader(rest.subspan(kRequest.size())).Read<std::uint16_t>();
    if (mask & ~kRequestBits) return J::Refused(LinkRefusal::kRange);
    return J::Of(kRequestBytes, Request{mask});
  }
  if (Agrees(rest, kStop)) {
    if (rest.size() < kStop.size()) return J::More(true);
    return J::Of(kBegin.size() + kStop.size(), EmergencyStop{});
  }
  if (!Agrees(rest, kCtrlInput)) return J::Refused(LinkRefusal::kUnknown);
  if (bytes.size() < kCtrlInputBytes) return J::More(true);
  Reader reader(rest.subspan(kCtrlInput.size()));
  Filler fill{reader};
  CtrlInput input;
  Layout(fill, input);
  if (reader.Read<std::uint16_t>() != CheckSum(input)) return J::Refused(LinkRefusal::kCheckSum);
  if (!InRange(input)) return J::Refused(LinkRefusal::kRange);
  return J::Of(kCtrlInputBytes, input);
}

// Takes from the front of the unread bytes all that can be judged.
template <class Message>
std::vector<Message> Parse(Bytes& unread, LinkCounts& counts, bool silent) {
  using Kind = typename Judgement<Message>::Kind;
  std::vector<Message> messages;
  std::size_t at = 0;
  while (at < unread.size()) {
    auto judged = Judge(std::span(unread).subspan(at), static_cast<Message*>(nullptr));
    if (judged.kind == Kind::kMore && !silent) break;
    if (judged.kind == Kind::kMessage) {
      messages.push_back(*std::move(judged.message));
      ++counts.messages;
      at += judged.bytes;
      continue;
    }
    if (judged.kind == Kind::kMore && judged.begun) judged = Judgement<Message>::Refused(LinkRefusal::kCut);
    if (judged.kind == Kind::kRefused) ++counts.refused[static_cast<std::size_t>(judged.why)];
    ++at, ++counts.skipped_bytes;
  }
  unread.erase(unread.begin(), unread.begin() + static_cast<std::ptrdiff_t>(at));
  return messages;
}

}  // namespace

bool InRange(const CtrlInput& input) {
  const auto stick = [](std::int16_t counts) { return counts >= -kStickCounts && counts <= kStickCounts; };
  return stick(input.pitch) && stick(input.roll) && stick(input.yaw) && input.thrust >= 0 &&
         input.thrust <= kThrustCounts;
}

std::uint16_t CheckSum(const CtrlInput& input) {
  return static_cast<std::uint16_t>(input.pitch + input.roll + input.yaw + input.thrust + input.ctrl +
                                    0xAAAA);
}

Bytes Encode(const Telemetry& message) {
  return std::visit([](const auto& each) { return Frame(each); }, message);
}

Bytes Encode(const Command& command) {
  Bytes bytes;
  AppendText(bytes, kBegin);
  if (const auto* request = std::get_if<Request>(&command)) {
    AppendText(bytes, "p");
    Append(bytes, request->mask);
  } else if (const auto* input = std::get_if<CtrlInput>(&command)) {
    AppendText(bytes, "di");
    CtrlInput fields = *input;
    Writer write{bytes};
    Layout(write, fields);
    Append(bytes, CheckSum(fields));
  } else {
    AppendText(bytes, "me");
  }
  return bytes;
}

std::vector<Telemetry> TelemetryParser::Feed(std::span<const std::uint8_t> bytes) {
  unread_.insert(unread_.end(), bytes.begin(), bytes.end());
  return Parse<Telemetry>(unread_, counts_, false);
}
std::vector<Telemetry> TelemetryParser::Idle() { return Parse<Telemetry>(unread_, counts_, true); }

std::vector<Command> CommandParser::Feed(std::span<const std::uint8_t> bytes) {
  unread_.insert(unread_.end(), bytes.begin(), bytes.end());
  return Parse<Command>(unread_, counts_, false);
}
std::vector<Command> CommandParser::Idle() { return Parse<Command>(unread_, counts_, true); }

}  // namespace kestrel::control::wire
