// SPDX-License-Identifier: Apache-2.0
#include "control/wire/afcs.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <utility>

namespace kestrel::control::wire {
namespace {

constexpr std::size_t kMessages = std::variant_size_v<AfcsMessage>;
constexpr std::uint32_t kMaxType = 256;
constexpr std::uint32_t kMicroseconds = 1'000'000;

// The members by name. Their order is the slots' of a compiled layout and nothing on the wire.
template <class V>
void Members(V&, AfcsOpen&) {}
template <class V>
void Members(V& v, AfcsAck& m) {
  v("acknowledged", m.acknowledged);
}
template <class V>
void Members(V&, AfcsClose&) {}
template <class V>
void Members(V& v, AfcsState& m) {
  v("phi", m.phi), v("theta", m.theta), v("psi", m.psi);
  v("p", m.p), v("q", m.q), v("r", m.r);
  v("x", m.x), v("y", m.y), v("z", m.z);
  v("vx", m.vx), v("vy", m.vy), v("vz", m.vz);
  v("mx", m.mx), v("my", m.my), v("mz", m.mz);
  v("ax", m.ax), v("ay", m.ay), v("az", m.az);
  v("raw_p", m.raw_p), v("raw_q", m.raw_q), v("raw_r", m.raw_r);
  v("trace", m.trace), v("voltage", m.voltage);
  v("resets", m.resets), v("rpm0", m.rpm0), v("rpm1", m.rpm1), v("rpm2", m.rpm2);
}
template <class V>
void Members(V& v, AfcsGpsState& m) {
  v("numsv", m.numsv), v("sacc", m.sacc), v("pacc", m.pacc), v("fixtype", m.fixtype);
  v("vel_n", m.vel_n), v("vel_e", m.vel_e), v("vel_d", m.vel_d);
  v("pos_n", m.pos_n), v("pos_e", m.pos_e), v("pos_d", m.pos_d);
  v("lat", m.lat), v("lon", m.lon), v("alt", m.alt), v("trace", m.trace);
}
template <class V>
void Members(V& v, AfcsFlyTo& m) {
  v("pos_mode", m.pos_mode), v("hdg_mode", m.hdg_mode), v("transit_time", m.transit_time);
  v("x", m.x), v("y", m.y), v("z", m.z), v("hdg", m.hdg);
}
template <class V>
void Members(V& v, AfcsTeleop& m) {
  v("fore", m.fore), v("side", m.side), v("alt", m.alt), v("hdg", m.hdg);
}
template <class V>
void Members(V& v, AfcsDesiredPosition& m) {
  v("n", m.n), v("e", m.e), v("d", m.d), v("hdg", m.hdg);
}
template <class V>
void Members(V& v, AfcsPlatform& m) {
  v("mode", m.mode);
  v("relative_roll", m.relative_roll), v("relative_pitch", m.relative_pitch),
      v("relative_yaw", m.relative_yaw);
  v("absolute_roll", m.absolute_roll), v("absolute_pitch", m.absolute_pitch),
      v("absolute_yaw", m.absolute_yaw);
  v("camera_n", m.camera_n), v("camera_e", m.camera_e), v("camera_d", m.camera_d);
}

// Every type of the wire and of the members is exact in a double.
constexpr std::size_t kSlots = 32;  // more than any message has members
using Slots = std::array<double, kSlots>;

template <class T>
bool Holds(double value) {
  return value >= std::numeric_limits<T>::min() && value <= std::numeric_limits<T>::max();
}

template <Number T>
T Nearest(double value) {
  if constexpr (std::is_integral_v<T>) {
    if (std::isnan(value)) return 0;
    return static_cast<T>(
        std::clamp<double>(std::round(value), std::numeric_limits<T>::min(), std::numeric_limits<T>::max()));
  } else if constexpr (std::is_same_v<T, float>) {
    constexpr double kMost = std::numeric_limits<float>::max();
    if (std::abs(value) > kMost)
      return std::copysign(std::numeric_limits<float>::infinity(),
                           static_cast<float>(std::copysign(1.0, value)));
    return static_cast<float>(value);
  } else {
    return value;
  }
}

struct NameLister {
  std::vector<std::string_view>& names;
  void operator()(const char* name, auto&) { names.emplace_back(name); }
};
struct SlotWriter {
  Slots& slots;
  std::size_t at = 0;
  void operator()(const char*, auto& member) { slots.at(at++) = static_cast<double>(member); }
};
struct SlotReader {
  const Slots& slots;
  std::size_t at = 0;
  bool good = true;
  template <class T>
  void operator()(const char*, T& member) {
    const double value = slots.at(at++);
    if constexpr (std::is_integral_v<T>) good = good && Holds<T>(std::round(value));
    member = Nearest<T>(value);
  }
};

// The message of a place in the variant, with nothing in it.
template <std::size_t index = 0>
AfcsMessage Empty(std::size_t wanted) {
  if constexpr (index + 1 < kMessages)
    if (wanted != index) return Empty<index + 1>(wanted);
  return std::variant_alternative_t<index, AfcsMessage>{};
}

std::vector<std::string_view> MemberNames(std::size_t index) {
  std::vector<std::string_view> names;
  NameLister lister{names};
  AfcsMessage message = Empty(index);
  std::visit([&lister](auto& each) { Members(lister, each); }, message);
  return names;
}

struct WireType {
  std::string_view name;
  std::size_t bytes;
  void (*append)(Bytes&, double, std::endian);
  double (*take)(Reader&);
};
template <Number T>
constexpr WireType TypeOf(std::string_view name) {
  return {name, sizeof(T),
          [](Bytes& bytes, double v, std::endian order) { Append(bytes, Nearest<T>(v), order); },
          [](Reader& reader) { return static_cast<double>(reader.Read<T>()); }};
}
constexpr std::array kTypes = {TypeOf<std::int16_t>("i16"), TypeOf<std::uint16_t>("u16"),
                               TypeOf<std::int32_t>("i32"), TypeOf<std::uint32_t>("u32"),
                               TypeOf<float>("f32"),        TypeOf<double>("f64")};

template <class List>
std::optional<std::size_t> PlaceOf(std::string_view name, const List& list) {
  const auto found = std::find(list.begin(), list.end(), name);
  if (found == list.end()) return std::nullopt;
  return static_cast<std::size_t>(found - list.begin());
}
const WireType* FindType(std::string_view name) {
  const auto* found =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& t) { return t.name == name; });
  return found == kTypes.end() ? nullptr : found;
}
bool IsPad(std::string_view name) { return name.starts_with("pad"); }
bool IsByteOrder(std::string_view order) { return order == "little" || order == "big"; }
std::endian ByteOrder(std::string_view order) {
  return order == "big" ? std::endian::big : std::endian::little;
}

// Appends to a layout fields of one type.
AfcsLayout Layout(const char* name, int id) {
  return {.name = name, .id = id, .byte_order = "little", .fields = {}};
}
AfcsLayout& Add(AfcsLayout& layout, const char* type, std::initializer_list<const char*> names) {
  for (const char* name : names) layout.fields.push_back({name, type});
  return layout;
}

}  // namespace

AfcsTime After(const AfcsTime& last, const AfcsTime& now) {
  if (now > last) return now;
  if (last.microseconds + 1 < kMicroseconds) return {last.seconds, last.microseconds + 1};
  return {last.seconds + 1, 0};
}

AfcsTime AfcsTimeOf(double t_s) {
  constexpr double kMost_s = std::numeric_limits<std::uint32_t>::max();
  if (!(t_s > 0)) return {};
  const auto us = static_cast<std::uint64_t>(std::round(std::min(t_s, kMost_s) * kMicroseconds));
  return {static_cast<std::uint32_t>(us / kMicroseconds), static_cast<std::uint32_t>(us % kMicroseconds)};
}

double Seconds(const AfcsTime& time) { return time.seconds + time.microseconds * 1e-6; }

AfcsProfile ThesisAfcsProfile() {
  AfcsLayout ack = Layout("ack", 2);
  ack.byte_order = "big";
  Add(ack, "u32", {"acknowledged"});
  AfcsLayout state = Layout("state", 10);
  Add(state, "f64", {"phi", "theta", "psi", "p", "q", "r", "x", "y", "z", "vx", "vy", "vz"});
  Add(state, "f64", {"mx", "my", "mz", "ax", "ay", "az", "raw_p", "raw_q", "raw_r", "trace", "voltage"});
  Add(state, "u16", {"resets", "rpm0", "rpm1", "rpm2"});
  AfcsLayout gps = Layout("gps_state", 12);
  Add(gps, "i16", {"numsv", "sacc", "pacc", "fixtype"});
  Add(gps, "f64", {"vel_n", "vel_e", "vel_d", "pos_n", "pos_e", "pos_d", "lat", "lon", "alt", "trace"});
  AfcsLayout fly_to = Layout("fly_to", 16);
  Add(fly_to, "i16", {"pos_mode", "hdg_mode", "transit_time"});
  Add(fly_to, "u16", {"pad1"});
  Add(fly_to, "f64", {"x", "y", "z", "hdg"});
  AfcsLayout platform = Layout("platform", 19);
  Add(platform, "i16", {"mode", "pad0", "pad1", "pad2"});
  Add(platform, "f64", {"relative_roll", "relative_pitch", "relative_yaw"});
  Add(platform, "f64", {"absolute_roll", "absolute_pitch", "absolute_yaw"});
  Add(platform, "f64", {"camera_n", "camera_e", "camera_d"});
  AfcsLayout desired = Layout("desired_position", 20);
  Add(desired, "f64", {"n", "e", "d", "hdg"});
  AfcsLayout teleop = Layout("teleop", 21);
  Add(teleop, "f64", {"fore", "side", "alt", "hdg"});
  return {.name = "thesis",
          .header_byte_order = "big",
          .time_bytes = 4,
          .messages = {Layout("open", 1), ack, Layout("close", 3), state, gps, fly_to, platform, desired,
                       teleop}};
}

std::vector<std::string> MistakesOf(const AfcsProfile& profile) {
  std::vector<std::string> all;
  const auto wrong = [&](const std::string& where, const std::string& what) {
    all.push_back(profile.name + ": " + where + ": " + what);
  };
  if (!IsByteOrder(profile.header_byte_order)) wrong("header_byte_order", "neither little nor big");
  if (profile.time_bytes != 4 && profile.time_bytes != 8) wrong("time_bytes", "neither 4 nor 8");
  std::array<int, kMessages> seen{};
  std::vector<int> ids;
  for (const AfcsLayout& message : profile.messages) {
    const auto index = PlaceOf(message.name, kAfcsMessageNames);
    if (!index) {
      wrong(message.name, "no such message");
      continue;
    }
    if (++seen[*index] == 2) wrong(message.name, "given twice");
    if (message.id < 0 || message.id > static_cast<int>(kMaxType))
      wrong(message.name, "id not within 0..256");
    if (std::find(ids.begin(), ids.end(), message.id) != ids.end())
      wrong(message.name, "has the id of another");
    ids.push_back(message.id);
    if (!IsByteOrder(message.byte_order)) wrong(message.name, "byte_order is neither little nor big");
    const auto members = MemberNames(*index);
    std::vector<std::string_view> names;
    for (const AfcsField& field : message.fields) {
      const std::string where = message.name + "." + field.name;
      if (!FindType(field.type)) wrong(where, "no such type: " + field.type);
      if (IsPad(field.name)) continue;
      if (!PlaceOf(field.name, members)) wrong(where, "no such field");
      if (PlaceOf(field.name, names)) wrong(where, "given twice");
      names.push_back(field.name);
    }
  }
  for (std::size_t i = 0; i < kMessages; ++i)
    if (seen[i] == 0) wrong(kAfcsMessageNames[i], "missing");
  return all;
}

struct AfcsCodec::Compiled {
  struct Field {
    const WireType* type;
    std::optional<std::size_t> slot;  // none: padding
  };
  struct Message {
    std::uint32_t id = 0;
    std::endian order = std::endian::little;
    std::vector<Field> fields;
    std::size_t bytes = 0;  // of the payload
  };
  std::endian header_order = std::endian::big;
  bool wide = false;  // 8 bytes for each half of the time
  std::array<Message, kMessages> messages;

  std::size_t header_bytes() const { return wide ? 20 : 12; }
};

AfcsCodec::AfcsCodec(const AfcsProfile& profile) {
  std::string mistakes;
  for (const std::string& mistake : MistakesOf(profile)) mistakes += (mistakes.empty() ? "" : "\n") + mistake;
  if (!mistakes.empty()) throw std::invalid_argument(mistakes);
  auto compiled = std::make_shared<Compiled>();
  compiled->header_order = ByteOrder(profile.header_byte_order);
  compiled->wide = profile.time_bytes == 8;
  for (const AfcsLayout& layout : profile.messages) {
    const std::size_t index = *PlaceOf(layout.name, kAfcsMessageNames);
    auto& message = compiled->messages[index];
    message.id = static_cast<std::uint32_t>(layout.id);
    message.order = ByteOrder(layout.byte_order);
    const auto members = MemberNames(index);
    for (const AfcsField& field : layout.fields) {
      const WireType* type = FindType(field.type);
      message.fields.push_back({type, IsPad(field.name) ? std::nullopt : PlaceOf(field.name, members)});
      message.bytes += type->bytes;
    }
  }
  compiled_ = std::move(compiled);
}

std::size_t AfcsCodec::header_bytes() const { return compiled_->header_bytes(); }
std::size_t AfcsCodec::datagram_bytes(std::size_t index) const {
  return compiled_->header_bytes() + compiled_->messages.at(index).bytes;
}

Bytes AfcsCodec::Encode(const AfcsDatagram& datagram) const {
  const auto& message = compiled_->messages[datagram.message.index()];
  const std::endian order = compiled_->header_order;
  Bytes bytes;
  for (const std::uint32_t half : {datagram.time.seconds, datagram.time.microseconds}) {
    if (compiled_->wide)
      Append(bytes, std::uint64_t{half}, order);
    else
      Append(bytes, half, order);
  }
  Append(bytes, message.id, order);
  Slots slots{};
  AfcsMessage copy = datagram.message;
  std::visit([writer = SlotWriter{slots}](auto& each) mutable { Members(writer, each); }, copy);
  for (const auto& field : message.fields)
    field.type->append(bytes, field.slot ? slots[*field.slot] : 0, message.order);
  return bytes;
}

std::variant<AfcsDatagram, AfcsRefusal> AfcsCodec::Decode(std::span<const std::uint8_t> bytes) const {
  if (bytes.size() < compiled_->header_bytes()) return AfcsRefusal::kShort;
  Reader header(bytes, compiled_->header_order);
  const auto half = [&]() -> std::uint64_t {
    if (compiled_->wide) return header.Read<std::uint64_t>();
    return header.Read<std::uint32_t>();
  };
  const std::uint64_t seconds = half(), microseconds = half();
  const auto type = header.Read<std::uint32_t>();
  if (seconds > std::numeric_limits<std::uint32_t>::max() || microseconds >= kMicroseconds)
    return AfcsRefusal::kTime;
  if (type > kMaxType) return AfcsRefusal::kType;
  const auto& messages = compiled_->messages;
  const auto* const message =
      std::find_if(messages.begin(), messages.end(), [&](const auto& each) { return each.id == type; });
  if (message == messages.end()) return AfcsRefusal::kUnknown;
  const auto payload = bytes.subspan(compiled_->header_bytes());
  if (payload.size() != message->bytes) return AfcsRefusal::kLength;
  Reader reader(payload, message->order);
  Slots slots{};
  for (const auto& field : message->fields) {
    const double value = field.type->take(reader);
    if (field.slot) slots[*field.slot] = value;
  }
  AfcsDatagram datagram{
      .time = {static_cast<std::uint32_t>(seconds), static_cast<std::uint32_t>(microseconds)},
      .message = Empty(static_cast<std::size_t>(message - messages.begin()))};
  SlotReader assign{slots};
  std::visit([&assign](auto& each) { Members(assign, each); }, datagram.message);
  if (!assign.good) return AfcsRefusal::kRange;
  return datagram;
}

std::optional<AfcsDatagram> AfcsReceiver::Receive(std::span<const std::uint8_t> bytes) {
  const auto refuse = [this](AfcsRefusal why) {
    ++refused_[static_cast<std::size_t>(why)];
    return std::nullopt;
  };
  auto decoded = codec_.Decode(bytes);
  if (const auto* why = std::get_if<AfcsRefusal>(&decoded)) return refuse(*why);
  auto& datagram = std::get<AfcsDatagram>(decoded);
  auto& last_of_type = last_of_type_[datagram.message.index()];
  if (datagram.time == last_ || datagram.time == last_of_type) return refuse(AfcsRefusal::kDuplicate);
  if (last_of_type && datagram.time < *last_of_type) return refuse(AfcsRefusal::kOld);
  last_ = last_of_type = datagram.time;
  ++accepted_;
  return std::move(datagram);
}

void AfcsReceiver::Reset() {
  last_.reset();
  last_of_type_.fill(std::nullopt);
}

}  // namespace kestrel::control::wire
