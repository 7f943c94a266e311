// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "control/wire/bytes.h"

// Frames of MAVLink: start bytes, header, check sum, sequence numbers. Source:
// mavlink.io/en/guide/serialization.html. Frames of version 2 are written; of version 1 are read too, because
// an autopilot may speak it until it has heard version 2. Signed frames are read and their signature, which
// is beyond the check sum, is NOT checked: a frame's `is_signed` is no proof of who sent it.
namespace kestrel::control::wire::mavlink {

// What must be known of a message to check its frames.
struct Format {
  std::uint32_t id = 0;          // 24 bits
  std::uint8_t crc_extra = 0;    // stands for its fields' names and types, which both ends must agree on
  std::uint8_t length = 0;       // of the payload, bytes
  std::uint8_t base_length = 0;  // without the fields that version 2 added at its end
};

struct Frame {
  std::uint8_t version = 2;
  bool is_signed = false;
  std::uint8_t sequence = 0;
  std::uint8_t system = 0, component = 0;   // of the sender
  std::uint32_t id = 0;                     // of the message
  std::uint8_t length = 0;                  // of the payload as sent: zeros at its end may have been left out
  std::array<std::uint8_t, 255> payload{};  // zeros beyond length
};

// The frame as unsigned version 2, without the zeros at the payload's end (its first byte is always sent).
Bytes EncodeFrame(const Frame& frame, std::uint8_t crc_extra);

// What a parser made of its bytes. Every byte belongs to a frame, to an unknown message or to stray_bytes;
// the refusals say why start bytes were not taken for a frame, so that the bytes from them on were searched
// for another.
struct Counts {
  std::uint64_t frames = 0;         // given out
  std::uint64_t version1 = 0;       // of these
  std::uint64_t signed_frames = 0;  // of these
  std::uint64_t unknown = 0;        // passed over whole: a message of no known format
  std::uint64_t stray_bytes = 0;
  std::uint64_t bad_checksum = 0;
  std::uint64_t bad_flags = 0;    // incompatible ones other than "signed"
  std::uint64_t bad_length = 0;   // version 1, which leaves nothing out
  std::uint64_t unconfirmed = 0;  // an unknown message that does not stand between frames of known senders
  std::uint64_t cut_short = 0;    // by the end of its datagram
};

// What came from one system and component, by their sequence numbers. A sender that starts anew looks like up
// to 127 lost.
struct Traffic {
  std::uint64_t frames = 0;
  std::uint64_t lost = 0;
  std::uint64_t repeated = 0;
  std::uint8_t last_sequence = 0;
};
using Source = std::pair<std::uint8_t, std::uint8_t>;  // system, component

// Finds the frames among bytes. After noise or a damaged frame no good frame is lost: bytes that turn out to
// be no frame are searched again from the second one on. (A frame can be late: by the length that a damaged
// one claims, 280 bytes at most.) A message of unknown format cannot be checked: it is passed over whole, be
// there what may in it, if checked frames have come from its source and from that of the frame after it; if
// not, it is searched for frames.
class Parser {
 public:
  explicit Parser(std::span<const Format> known) : known_(known) {}  // which must outlive the parser

  // The frames that these bytes of an endless stream complete; it does not matter how a stream is divided.
  std::vector<Frame> Stream(std::span<const std::uint8_t> bytes);
  // The frames of a datagram: no frame goes on in the next one.
  std::vector<Frame> Datagram(std::span<const std::uint8_t> bytes);

  const Counts& counts() const { return counts_; }
  const std::map<Source, Traffic>& traffic() const { return traffic_; }

 private:
  std::vector<Frame> Parse(std::span<const std::uint8_t> bytes, bool ended);
  std::size_t Step(std::span<const std::uint8_t> rest, bool ended, std::vector<Frame>& frames);
  std::optional<bool> Confirm(std::span<const std::uint8_t> rest, std::size_t size, bool ended) const;
  std::size_t Refuse(std::uint64_t& reason);

  std::span<const Format> known_;
  Bytes pending_;  // the beginning of a frame
  Counts counts_;
  std::map<Source, Traffic> traffic_;
};

}  // namespace kestrel::control::wire::mavlink
