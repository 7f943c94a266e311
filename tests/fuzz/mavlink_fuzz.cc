// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>

#include "control/wire/mavlink_dialects.h"

// The parser on any bytes, as a stream in two pieces, and as frames whose check sums are made right, so that
// the readers of all messages get any payload; and the telemetry on what they read.
using namespace kestrel::control::wire;
using namespace kestrel::control::wire::mavlink;

namespace {

void Require(bool holds) {
  if (!holds) std::abort();
}

void Use(const std::vector<Frame>& frames, Telemetry& telemetry) {
  for (const Frame& frame : frames) {
    const std::optional<Message> message = Decode(frame);
    Require(message.has_value());
    telemetry.Handle(*message);
    // What is written of it reads as the same again.
    Sender sender(frame.system, frame.component);
    Parser parser(Formats());
    const std::vector<Frame> again = parser.Datagram(sender.Encode(*message));
    Require(again.size() == 1 && again[0].id == frame.id);
    const std::size_t length = std::ranges::find(Formats(), frame.id, &Format::id)->length;
    Require(std::equal(frame.payload.begin(), frame.payload.begin() + static_cast<std::ptrdiff_t>(length),
                       again[0].payload.begin()));
    for (const Dialect* dialect : {&kPx4, &kArduPilot}) {
      const auto state = telemetry.State(*dialect);
      if (state) Require(state->R_NB.coeffs().allFinite() && state->p_NB.allFinite());
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  if (bytes.size() < 2) return 0;
  Telemetry telemetry;
  Parser whole(Formats()), pieces(Formats()), datagrams(Formats());
  const std::vector<Frame> frames = whole.Stream(bytes);
  const std::size_t cut = bytes[0] % bytes.size();
  const std::size_t found = pieces.Stream(bytes.first(cut)).size() + pieces.Stream(bytes.subspan(cut)).size();
  Require(found == frames.size() && pieces.counts().stray_bytes == whole.counts().stray_bytes);
  Use(frames, telemetry);
  Use(datagrams.Datagram(bytes), telemetry);

  // [which message, length, payload...]...
  for (std::size_t at = 0; at + 2 < bytes.size();) {
    const Format& format = Formats()[bytes[at] % Formats().size()];
    Frame frame{.system = 1, .component = 1, .id = format.id};
    const std::size_t length = std::min<std::size_t>(bytes[at + 1], bytes.size() - at - 2);
    frame.length = static_cast<std::uint8_t>(length);
    std::ranges::copy(bytes.subspan(at + 2, length), frame.payload.begin());
    const std::vector<Frame> read = datagrams.Datagram(EncodeFrame(frame, format.crc_extra));
    Require(read.size() == 1);
    Use(read, telemetry);
    at += 2 + length;
  }
  return 0;
}
