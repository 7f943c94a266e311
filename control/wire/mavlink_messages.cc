// SPDX-License-Identifier: Apache-2.0
#include "control/wire/mavlink_messages.h"

#include <algorithm>
#include <utility>

namespace kestrel::control::wire::mavlink {
namespace {

// The visitors of Fields. A field is a number or an array of them, so that its size here is that on the wire.
class Measure {
 public:
  template <class... Field>
  constexpr void operator()(const Field&...) {
    base_ += (sizeof(Field) + ...), all_ = base_;
  }
  template <class... Field>
  constexpr void Extensions(const Field&...) {
    all_ += (sizeof(Field) + ...);
  }
  constexpr std::uint8_t base() const { return static_cast<std::uint8_t>(base_); }
  constexpr std::uint8_t all() const { return static_cast<std::uint8_t>(all_); }

 private:
  std::size_t base_ = 0, all_ = 0;
};

class Writer {
 public:
  explicit Writer(Bytes& bytes) : bytes_(bytes) {}
  void operator()(const auto&... field) { (Put(field), ...); }
  void Extensions(const auto&... field) { (Put(field), ...); }

 private:
  void Put(Number auto value) { Append(bytes_, value); }
  template <Number T, std::size_t n>
  void Put(const std::array<T, n>& values) {
    for (const T value : values) Append(bytes_, value);
  }
  Bytes& bytes_;
};

class Taker {
 public:
  explicit Taker(std::span<const std::uint8_t> bytes) : reader_(bytes) {}
  void operator()(auto&... field) { (Read(field), ...); }
  void Extensions(auto&... field) { (Read(field), ...); }

 private:
  template <Number T>
  void Read(T& value) {
    value = reader_.Read<T>();
  }
  template <Number T, std::size_t n>
  void Read(std::array<T, n>& values) {
    for (T& value : values) value = reader_.Read<T>();
  }
  Reader reader_;
};

template <class M>
constexpr Format FormatOf() {
  M message;
  Measure measure;
  Fields(measure, message);
  return {M::kId, M::kCrcExtra, measure.all(), measure.base()};
}

template <class M>
Message Read(const Frame& frame) {
  M message;
  Taker taker(frame.payload);
  Fields(taker, message);
  return message;
}

template <std::size_t... i>
constexpr auto MakeFormats(std::index_sequence<i...>) {
  return std::array{FormatOf<std::variant_alternative_t<i, Message>>()...};
}
template <std::size_t... i>
constexpr auto MakeReaders(std::index_sequence<i...>) {
  return std::array{&Read<std::variant_alternative_t<i, Message>>...};
}
using Indices = std::make_index_sequence<std::variant_size_v<Message>>;
constexpr auto kFormats = MakeFormats(Indices{});
constexpr auto kReaders = MakeReaders(Indices{});

}  // namespace

std::span<const Format> Formats() { return kFormats; }

std::optional<Message> Decode(const Frame& frame) {
  const auto format = std::ranges::find(kFormats, frame.id, &Format::id);
  if (format == kFormats.end()) return std::nullopt;
  return kReaders[static_cast<std::size_t>(format - kFormats.begin())](frame);
}

Bytes Sender::Encode(const Message& message) {
  return std::visit(
      [this]<class M>(const M& m) {
        Bytes payload;
        Writer writer(payload);
        Fields(writer, m);
        Frame frame{.sequence = sequence_++, .system = system_, .component = component_, .id = M::kId};
        frame.length = static_cast<std::uint8_t>(payload.size());
        std::ranges::copy(payload, frame.payload.begin());
        return EncodeFrame(frame, M::kCrcExtra);
      },
      message);
}

}  // namespace kestrel::control::wire::mavlink
