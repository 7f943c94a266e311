// SPDX-License-Identifier: Apache-2.0
#include "control/wire/mavlink.h"

#include <algorithm>
#include <optional>

#include "control/wire/crc16.h"

namespace kestrel::control::wire::mavlink {
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

// What the first bytes of a frame say.
struct Head {
  Frame frame;  // without its payload
  bool good_flags = true;
  std::size_t checked = 0;  // bytes until the check sum
  std::size_t size = 0;     // bytes in all
};

// None: too few bytes to tell, which begin with a start byte.
std::optional<Head> ReadHead(std::span<const std::uint8_t> bytes) {
  Head head;
  Frame& frame = head.frame;
  frame.version = bytes[0] == kStart2 ? 2 : 1;
  const std::size_t header = frame.version == 2 ? kHeader2 : kHeader1;
  if (bytes.size() < header) return std::nullopt;
  if (frame.version == 2) {
    head.good_flags = (bytes[2] & ~kSigned) == 0;
    frame.is_signed = (bytes[2] & kSigned) != 0;
  }
  // Version 1 is as version 2 without the flags and with an id of one byte.
  frame.length = bytes[1];
  const auto ids = bytes.subspan(frame.version == 2 ? 4 : 2);
  frame.sequence = ids[0], frame.system = ids[1], frame.component = ids[2], frame.id = ids[3];
  if (frame.version == 2) frame.id |= static_cast<std::uint32_t>(ids[4]) << 8 | std::uint32_t{ids[5]} << 16;
  head.checked = header + frame.length;
  head.size = head.checked + kChecksum + (frame.is_signed ? kSignature : 0);
  return head;
}

const Format* Find(std::span<const Format> known, const Head& head) {
  const auto format = std::ranges::find(known, head.frame.id, &Format::id);
  return format == known.end() ? nullptr : &*format;
}

bool ChecksumHolds(std::span<const std::uint8_t> bytes, const Head& head, const Format& format) {
  return Reader(bytes.subspan(head.checked)).Read<std::uint16_t>() ==
         Checksum(bytes.first(head.checked), format.crc_extra);
}

// Whether the last of these bytes are those of a good frame that begins after the first.
bool EndsInFrame(std::span<const std::uint8_t> bytes, std::span<const Format> known) {
  for (std::size_t at = 1; at < bytes.size(); ++at) {
    const auto rest = bytes.subspan(at);
    if (!IsStart(rest[0])) continue;
    const auto head = ReadHead(rest);
    if (!head || !head->good_flags || head->size != rest.size()) continue;
    const Format* format = Find(known, *head);
    if (format != nullptr && ChecksumHolds(rest, *head, *format)) return true;
  }
  return false;
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
  const auto wait = [&]() -> std::size_t { return ended ? Refuse(counts_.cut_short) : 0; };
  // The flags are seen before the rest, so that noise need not be waited for.
  if (rest[0] == kStart2 && rest.size() > 2 && (rest[2] & ~kSigned) != 0) return Refuse(counts_.bad_flags);
  const std::optional<Head> head = ReadHead(rest);
  if (!head) return wait();
  const Source source{head->frame.system, head->frame.component};
  const Format* format = Find(known_, *head);
  if (format == nullptr) {
    if (!traffic_.contains(source)) return Refuse(counts_.unconfirmed);
    if (rest.size() < head->size) return wait();
    const std::optional<bool> confirmed = Confirm(rest, head->size, ended);
    if (!confirmed) return 0;
    if (!*confirmed) return Refuse(counts_.unconfirmed);
    ++counts_.unknown;
    Note(traffic_[source], head->frame.sequence);
    return head->size;
  }
  if (head->frame.version == 1 && head->frame.length != format->base_length)
    return Refuse(counts_.bad_length);
  if (rest.size() < head->size) return wait();
  if (!ChecksumHolds(rest, *head, *format)) return Refuse(counts_.bad_checksum);
  Frame frame = head->frame;
  std::ranges::copy(rest.subspan(head->checked - frame.length, frame.length), frame.payload.begin());
  ++counts_.frames;
  if (frame.version == 1) ++counts_.version1;
  if (frame.is_signed) ++counts_.signed_frames;
  Note(traffic_[source], frame.sequence);
  frames.push_back(frame);
  return head->size;
}

// Whether an unknown message is of this size; none: more bytes are needed to tell.
std::optional<bool> Parser::Confirm(std::span<const std::uint8_t> rest, std::size_t size, bool ended) const {
  // Cut within its header, it would take in whole frames, the last of which has what seems its check sum.
  if (EndsInFrame(rest.first(size), known_)) return false;
  const auto next = rest.subspan(size);
  if (next.empty()) return ended ? std::optional(true) : std::nullopt;
  if (!IsStart(next[0])) return false;
  const std::optional<Head> head = ReadHead(next);
  if (!head) return ended ? std::optional(false) : std::nullopt;
  return head->good_flags && traffic_.contains({head->frame.system, head->frame.component});
}

std::size_t Parser::Refuse(std::uint64_t& reason) {
  ++reason, ++counts_.stray_bytes;
  return 1;
}

}  // namespace kestrel::control::wire::mavlink
