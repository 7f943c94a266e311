// SPDX-License-Identifier: Apache-2.0
#include "control/wire/mavlink.h"

#include <algorithm>

#include "control/wire/crc16.h"

namespace kestrel::wire::mavlink {
namespace {

constexpr std::uint8_t kStart2 = 0xFD, kStart1 = 0xFE;
constexpr std::uint8_t kSigned = 1;  // of the incompatible flags
constexpr std::size_t kHeader2 = 10, kHeader1 = 6, kChecksum = 2, kSignature = 13;

bool IsStart(std::uint8_t byte) { return byte == kStart2 || byte == kStart1; }

// Over all between the start byte and the check sum.
std::uint16_t Checksum(std::span<const std::uint8_t> frame, std::uint8_t crc_extra) {
  Crc16 crc(0xFFFF);
  crc.Add(frame.subspan(1));
  crc.Add(crc_extra);
  return crc.sum();
}

void Note(Traffic& traffic, std::uint8_t sequence) {
  if (++traffic.frames > 1) {
    const auto missing = static_cast<std::uint8_t>(sequence - traffic.last_sequence - 1);
    if (missing == 255) {
      ++traffic.repeated;
      return;
    }
    if (missing >= 128) {  // a later one overtook it, and it was taken for lost
      traffic.lost -= std::min<std::uint64_t>(traffic.lost, 1);
      return;
    }
    traffic.lost += missing;
  }
  traffic.last_sequence = sequence;
}

}  // namespace

Bytes EncodeFrame(const Frame& frame, std::uint8_t crc_extra) {
  std::size_t length = std::max<std::size_t>(frame.length, 1);
  while (length > 1 && frame.payload[length - 1] == 0) --length;
  Bytes bytes{kStart2,        static_cast<std::uint8_t>(length), 0, 0, frame.sequence, frame.system,
              frame.component};
  bytes.reserve(kHeader2 + length + kChecksum);
  for (int shift = 0; shift < 24; shift += 8) bytes.push_back(static_cast<std::uint8_t>(frame.id >> shift));
  bytes.insert(bytes.end(), frame.payload.begin(),
               frame.payload.begin() + static_cast<std::ptrdiff_t>(length));
  Append(bytes, Checksum(bytes, crc_extra));
  return bytes;
}

std::vector<Frame> Parser::Stream(std::span<const std::uint8_t> bytes) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  return Parse(pending_, false);
}

std::vector<Frame> Parser::Datagram(std::span<const std::uint8_t> bytes) {
  pending_.assign(bytes.begin(), bytes.end());
  return Parse(pending_, true);
}

std::vector<Frame> Parser::Parse(std::span<const std::uint8_t> bytes, bool ended) {
  std::vector<Frame> frames;
  std::size_t at = 0;
  while (at < bytes.size()) {
    const std::size_t taken = Step(bytes.subspan(at), ended, frames);
    if (taken == 0) break;
    at += taken;
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(at));
  return frames;
}

// How many bytes to go on by; 0: more are needed to tell.
std::size_t Parser::Step(std::span<const std::uint8_t> rest, bool ended, std::vector<Frame>& frames) {
  if (!IsStart(rest[0])) {
    const auto stray = static_cast<std::size_t>(std::ranges::find_if(rest, IsStart) - rest.begin());
    counts_.stray_bytes += stray;
    return stray;
  }
  Frame frame;
  frame.version = rest[0] == kStart2 ? 2 : 1;
  const std::size_t header = frame.version == 2 ? kHeader2 : kHeader1;
  const auto wait = [&]() -> std::size_t { return ended ? Refuse(counts_.cut_short) : 0; };
  if (rest.size() < header) return wait();
  if (frame.version == 2) {
    if ((rest[2] & ~kSigned) != 0) return Refuse(counts_.bad_flags);
    frame.is_signed = (rest[2] & kSigned) != 0;
  }
  // Version 1 is as version 2 without the flags and with an id of one byte.
  frame.length = rest[1];
  const auto ids = rest.subspan(frame.version == 2 ? 4 : 2);
  frame.sequence = ids[0], frame.system = ids[1], frame.component = ids[2], frame.id = ids[3];
  if (frame.version == 2) frame.id |= static_cast<std::uint32_t>(ids[4]) << 8 | std::uint32_t{ids[5]} << 16;

  const std::size_t checked = header + frame.length;
  const std::size_t size = checked + kChecksum + (frame.is_signed ? kSignature : 0);
  const auto format = std::ranges::find(known_, frame.id, &Format::id);
  if (format == known_.end()) {
    const auto source = traffic_.find({frame.system, frame.component});
    if (source == traffic_.end()) return Refuse(counts_.unconfirmed);
    if (rest.size() < size || (rest.size() == size && !ended)) return wait();
    if (rest.size() > size && !IsStart(rest[size])) return Refuse(counts_.unconfirmed);
    ++counts_.unknown;
    Note(source->second, frame.sequence);
    return size;
  }
  if (frame.version == 1 && frame.length != format->base_length) return Refuse(counts_.bad_length);
  if (rest.size() < size) return wait();
  if (Reader(rest.subspan(checked)).Take<std::uint16_t>() !=
      Checksum(rest.first(checked), format->crc_extra)) {
    return Refuse(counts_.bad_checksum);
  }
  std::ranges::copy(rest.subspan(header, frame.length), frame.payload.begin());
  ++counts_.frames;
  if (frame.version == 1) ++counts_.version1;
  if (frame.is_signed) ++counts_.signed_frames;
  Note(traffic_[{frame.system, frame.component}], frame.sequence);
  frames.push_back(frame);
  return size;
}

std::size_t Parser::Refuse(std::uint64_t& reason) {
  ++reason, ++counts_.stray_bytes;
  return 1;
}

}  // namespace kestrel::wire::mavlink
