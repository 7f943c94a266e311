// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <span>
#include <vector>

#include "control/wire/asctec.h"
#include "control/wire/crc16.h"

// The input makes a stream for both ends, of raw pieces and of whole messages whose sums are right, since no
// search finds those, damaged or not. Whatever it is: its cutting into blocks makes no difference, every
// byte is accounted for, and what is accepted is encoded back to bytes that are in the stream.
namespace {

using namespace kestrel::control::wire;  // NOLINT(google-build-using-namespace)

void Require(bool promise) {
  if (!promise) std::abort();
}

// The bytes that a message took of the stream, as they are encoded; RC_DATA may have come without its
// padding.
Bytes Shortest(const Telemetry& message) {
  Bytes bytes = Encode(message);
  if (std::holds_alternative<RcData>(message)) bytes.resize(bytes.size() - 6);  // padding, sum, end
  if (std::holds_alternative<RcData>(message)) bytes.erase(bytes.begin() + 3);  // the length
  return bytes;
}
Bytes Shortest(const Command& command) { return Encode(command); }

bool Contains(std::span<const std::uint8_t> stream, const Telemetry& message) {
  const Bytes bytes = Shortest(message);
  if (!std::holds_alternative<RcData>(message))
    return std::search(stream.begin(), stream.end(), bytes.begin(), bytes.end()) != stream.end();
  // All but the length, of which the low byte was taken out above.
  const std::span head = std::span(bytes).first(3), tail = std::span(bytes).subspan(3);
  for (auto at = stream.begin(); at != stream.end(); ++at) {
    at = std::search(at, stream.end(), head.begin(), head.end());
    if (static_cast<std::size_t>(stream.end() - at) < bytes.size() + 1) return false;
    if (std::equal(tail.begin(), tail.end(), at + 4)) return true;
  }
  return false;
}
bool Contains(std::span<const std::uint8_t> stream, const Command& command) {
  const Bytes bytes = Shortest(command);
  return std::search(stream.begin(), stream.end(), bytes.begin(), bytes.end()) != stream.end();
}

template <class Parser, class Message>
void Check(std::span<const std::uint8_t> stream, std::size_t block) {
  Parser whole, cut;
  std::vector<Message> messages = whole.Feed(stream), pieces;
  for (std::size_t at = 0; at < stream.size(); at += block)
    for (const Message& message : cut.Feed(stream.subspan(at, std::min(block, stream.size() - at))))
      pieces.push_back(message);
  for (const Message& message : whole.Idle()) messages.push_back(message);
  for (const Message& message : cut.Idle()) pieces.push_back(message);
  Require(messages == pieces);
  Require(whole.counts() == cut.counts());
  Require(whole.counts().messages == messages.size());
  std::uint64_t taken = whole.counts().skipped_bytes, slack = 0;
  for (const Message& message : messages) {
    Require(Contains(stream, message));
    taken += Encode(message).size();
    if constexpr (std::is_same_v<Message, Telemetry>)
      slack += std::holds_alternative<RcData>(message) ? 1 : 0;
  }
  Require(taken >= stream.size() && taken <= stream.size() + slack);
  Require(whole.Idle().empty());
}

// A frame, or ">*>di" with its sum, around some of the input.
struct Around {
  std::uint8_t descriptor;
  std::size_t bytes;
};
constexpr Around kArounds[] = {{0x02, 16}, {0x01, 28}, {0x03, 92}, {0x15, 34}, {0x15, 33},
                               {0x11, 16}, {0x23, 44}, {0x29, 60}, {0x17, 10}, {0x31, 8}};
void AppendMessage(Bytes& stream, const Around& around, std::span<const std::uint8_t> input) {
  Bytes data(input.begin(), input.end());
  data.resize(around.bytes);
  if (around.descriptor == CtrlInput::kDescriptor) {
    std::uint16_t sum = 0xAAAA;
    for (std::size_t i = 0; i < data.size(); i += 2)
      sum = static_cast<std::uint16_t>(sum + data[i] + 256 * data[i + 1]);
    for (const char c : {'>', '*', '>', 'd', 'i'}) Append(stream, c);
    stream.insert(stream.end(), data.begin(), data.end());
    return Append(stream, sum);
  }
  for (const char c : {'>', '*', '>'}) Append(stream, c);
  Append(stream, static_cast<std::uint16_t>(data.size()));
  Append(stream, around.descriptor);
  stream.insert(stream.end(), data.begin(), data.end());
  Crc16 crc(0x00FF);
  crc.Add(data);
  Append(stream, crc.sum());
  for (const char c : {'<', '#', '<'}) Append(stream, c);
}

Bytes StreamOf(std::span<const std::uint8_t> input) {
  Bytes stream;
  const auto take = [&input](std::size_t most) {
    const auto taken = input.first(std::min(most, input.size()));
    input = input.subspan(taken.size());
    return taken;
  };
  while (!input.empty()) {
    const std::uint8_t what = take(1)[0];
    if (what < 64) {
      const auto raw = take(what);
      stream.insert(stream.end(), raw.begin(), raw.end());
    } else if (what < 192) {
      const Around& around = kArounds[what % std::size(kArounds)];
      AppendMessage(stream, around, take(around.bytes));
    } else if (const auto damage = take(2); damage.size() == 2 && !stream.empty()) {
      stream[stream.size() - 1 - damage[0] % stream.size()] ^= damage[1];
    }
  }
  return stream;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const std::size_t block = 1 + data[0] % 32;
  const Bytes stream = StreamOf({data + 1, size - 1});
  Check<TelemetryParser, Telemetry>(stream, block);
  Check<CommandParser, Command>(stream, block);
  return 0;
}
