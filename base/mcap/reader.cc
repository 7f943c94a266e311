// SPDX-License-Identifier: Apache-2.0
#include "base/mcap/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/diagnostics.h"
#include "base/mcap/compression.h"
#include "base/mcap/wire.h"
#include "base/printable.h"
#include "base/user_file.h"

namespace kestrel::mcap {
namespace {

InputError NoMcap(const FileBytes& file, const std::string& what) {
  return InputError(file.name().string(), what, "valid: an MCAP file, which begins with its header");
}

const char* NameOf(Op op) {
  switch (op) {
    case Op::kSchema:
      return "schema";
    case Op::kChannel:
      return "channel";
    case Op::kMessage:
      return "message";
    case Op::kChunk:
      return "chunk";
    case Op::kMessageIndex:
      return "index of messages";
    case Op::kAttachment:
      return "attachment";
    case Op::kMetadata:
      return "record of metadata";
    default:
      return "record";
  }
}

}  // namespace

struct Reader::Open {
  struct Place {
    std::uint64_t log_time_ns = 0;
    std::size_t offset = 0, size = 0;  // of the message's content in the bytes
  };

  // A message's content, if it is wanted.
  void Take(std::string_view content, const Reader& reader) {
    Cursor fields(content);
    const auto channel = fields.Get<std::uint16_t>("channel_id of a message");
    fields.Get<std::uint32_t>("sequence of a message");
    const auto time_ns = fields.Get<std::uint64_t>("log_time of a message");
    fields.Get<std::uint64_t>("publish_time of a message");
    if (!reader.summary_.channels.contains(channel))
      throw Malformed(fmt::format("a message of channel {}, which is not told before", channel));
    if (reader.selected_ && !reader.selected_->contains(channel)) return;
    if (time_ns < reader.select_from_ns_ || time_ns > reader.select_until_ns_) return;
    messages.push_back({time_ns, static_cast<std::size_t>(content.data() - bytes.data()), content.size()});
  }

  bool ended() const { return next == messages.size(); }
  std::uint64_t time_ns() const { return messages[next].log_time_ns; }
  Message Next(const Reader& reader) {
    const Place& at = messages[next++];
    Cursor fields(std::string_view(bytes).substr(at.offset, at.size));
    Message message;
    message.channel = &reader.summary_.channels.at(fields.Get<std::uint16_t>("channel_id"));
    message.sequence = fields.Get<std::uint32_t>("sequence");
    message.log_time_ns = fields.Get<std::uint64_t>("log_time");
    message.publish_time_ns = fields.Get<std::uint64_t>("publish_time");
    message.data = fields.Bytes(fields.left(), "data");
    return message;
  }

  std::string bytes;
  std::vector<Place> messages;
  std::size_t next = 0;
};

Reader::Reader(const std::filesystem::path& file) : file_(file) {
  try {
    const std::string begin = file_.At(0, std::min<std::uint64_t>(file_.size(), kMagic.size() + kRecordHead));
    if (!begin.starts_with(kMagic.substr(0, begin.size())) || begin.empty())
      throw NoMcap(file_, begin.starts_with(kMagic.substr(0, 5))
                              ? fmt::format("is of MCAP's version '{}'; this one reads version '0'",
                                            Printable(begin.substr(5, 1)))
                              : "is no MCAP file: it begins otherwise");
    Cursor fields(begin);
    fields.Bytes(kMagic.size(), "the beginning");
    if (fields.Get<std::uint8_t>("opcode") != static_cast<std::uint8_t>(Op::kHeader))
      throw NoMcap(file_, "its first record is no header");
    const auto length = fields.Get<std::uint64_t>("length of the header");
    if (length > kMaxTextBytes) throw Malformed(fmt::format("{} bytes are too many", length));
    data_begin_ = kMagic.size() + kRecordHead + length;
    const std::string header = file_.At(begin.size(), length);
    profile_ = Cursor(header).Text("profile");
  } catch (const Malformed& e) {
    throw NoMcap(file_, fmt::format("has no whole header: {}", e.what()));
  }

  std::string without_summary;
  try {
    if (std::optional<Summary> summary = ReadSummary(file_)) summary_ = std::move(*summary);
  } catch (const Malformed& e) {
    without_summary = e.what();
  }
  Select({});
  if (summary_.indexed) return;
  while (const std::optional<Message> message = NextInFile()) summary_.CountMessage(message->log_time_ns);
  if (!without_summary.empty())
    Note(file_.size(), fmt::format("{}: read from the beginning", without_summary));
  Select({});
}

Reader::~Reader() = default;
Reader::Reader(Reader&&) noexcept = default;
Reader& Reader::operator=(Reader&&) noexcept = default;

void Reader::Note(std::uint64_t offset, const std::string& what) {
  if (damage_.empty()) damage_ = fmt::format("byte {}: {}", offset, what);
}

void Reader::Select(const std::vector<std::string>& topics, std::uint64_t from_ns, std::uint64_t until_ns) {
  selected_.reset();
  if (!topics.empty()) {
    selected_.emplace();
    for (const auto& [id, channel] : summary_.channels)
      if (std::find(topics.begin(), topics.end(), channel.topic) != topics.end()) selected_->insert(id);
  }
  select_from_ns_ = from_ns;
  select_until_ns_ = until_ns;
  next_chunk_ = 0;
  next_record_ = data_begin_;
  open_.clear();
  given_.reset();
}

std::optional<Message> Reader::Next() { return summary_.indexed ? NextByIndex() : NextInFile(); }

// content: of a chunk's record, as far as the file has it.
std::unique_ptr<Reader::Open> Reader::OpenChunk(std::uint64_t offset, std::string_view content) {
  Cursor fields(content);
  fields.Bytes(16, "message_start_time, message_end_time");
  const auto size = fields.Get<std::uint64_t>("uncompressed_size");
  const auto crc = fields.Get<std::uint32_t>("uncompressed_crc");
  const std::string compression(fields.Text("compression"));
  const auto compressed = fields.Get<std::uint64_t>("length of a chunk's records");
  const bool cut = compressed > fields.left();
  if (size > kMostInMemory)
    throw Malformed(fmt::format("a chunk of {} bytes, more than {}", size, kMostInMemory));
  Decompressed records = Decompress(
      compression, fields.Bytes(std::min<std::uint64_t>(compressed, fields.left()), "records"), size);
  if (!records.error.empty()) {
    if (!cut) throw Malformed(fmt::format("a chunk that does not decompress: {}", records.error));
    Note(offset, "the file ends within a chunk: it was cut");
  } else if (crc != 0 && crc != Crc32(records.bytes)) {
    throw Malformed("a chunk whose check sum is another");
  }

  auto open = std::make_unique<Open>();
  open->bytes = std::move(records.bytes);
  for (Cursor each(open->bytes); each.left() > 0;) {
    if (each.left() < kRecordHead && cut) break;
    const auto op = static_cast<Op>(each.Get<std::uint8_t>("opcode"));
    const auto length = each.Get<std::uint64_t>("length");
    if (length > each.left() && cut) break;
    const std::string_view record = each.Bytes(length, "record in a chunk");
    try {
      if (op == Op::kSchema) summary_.TakeSchema(record);
      if (op == Op::kChannel) summary_.TakeChannel(record);
      if (op == Op::kMessage) open->Take(record, *this);
    } catch (const Malformed& e) {
      Note(offset, e.what());
    }
  }
  return open;
}

std::optional<Message> Reader::NextByIndex() {
  const auto earliest = [&] {
    return std::min_element(open_.begin(), open_.end(),
                            [](const auto& a, const auto& b) { return a->time_ns() < b->time_ns(); });
  };
  std::uint64_t in_memory = 0;
  for (const auto& each : open_) in_memory += each->bytes.size();
  for (; next_chunk_ < summary_.chunks.size(); ++next_chunk_) {
    const Summary::Chunk& chunk = summary_.chunks[next_chunk_];
    if (!open_.empty() && ((*earliest())->time_ns() < chunk.from_ns || in_memory > kMostInMemory)) break;
    if (chunk.until_ns < select_from_ns_ || chunk.from_ns > select_until_ns_) continue;
    if (selected_ && !chunk.channels.empty() &&
        std::none_of(chunk.channels.begin(), chunk.channels.end(),
                     [&](std::uint16_t id) { return selected_->contains(id); }))
      continue;
    try {
      if (chunk.length > kMostInMemory) throw Malformed(fmt::format("a chunk of {} bytes", chunk.length));
      const std::string record = file_.At(chunk.offset, chunk.length);
      Cursor fields(record);
      if (fields.Get<std::uint8_t>("opcode") != static_cast<std::uint8_t>(Op::kChunk))
        throw Malformed("no chunk, where the summary has one");
      auto open =
          OpenChunk(chunk.offset, fields.Bytes(fields.Get<std::uint64_t>("length of a chunk"), "chunk"));
      std::stable_sort(open->messages.begin(), open->messages.end(),
                       [](const auto& a, const auto& b) { return a.log_time_ns < b.log_time_ns; });
      if (open->ended()) continue;
      in_memory += open->bytes.size();
      open_.push_back(std::move(open));
    } catch (const Malformed& e) {
      Note(chunk.offset, e.what());
    }
  }
  if (open_.empty()) return std::nullopt;
  const auto from = earliest();
  const Message message = (*from)->Next(*this);
  if ((*from)->ended()) {
    given_ = std::move(*from);
    open_.erase(from);
  }
  return message;
}

std::optional<Message> Reader::NextInFile() {
  for (;;) {
    if (given_ && !given_->ended()) return given_->Next(*this);
    if (next_record_ == kEnded) return std::nullopt;
    const std::uint64_t offset = next_record_, left = file_.size() - offset;
    next_record_ = kEnded;
    if (left < kRecordHead) {
      Note(offset, "the file ends without its end: it was cut");
      continue;
    }
    try {
      const std::string head = file_.At(offset, kRecordHead);
      Cursor fields(head);
      const auto op = static_cast<Op>(fields.Get<std::uint8_t>("opcode"));
      const auto length = fields.Get<std::uint64_t>("length");
      if (op == Op::kDataEnd || op == Op::kFooter) continue;
      const std::uint64_t there = std::min(length, left - kRecordHead);
      const bool whole = there == length;
      if (whole) next_record_ = offset + kRecordHead + length;
      if (op == Op{0}) throw Malformed("0 is no record");
      TakeRecord(op, offset, there, whole);
      if (!whole) Note(offset, fmt::format("the file ends within a {}: it was cut", NameOf(op)));
    } catch (const Malformed& e) {
      Note(offset, e.what());
    }
  }
}

// Of the data section. there: bytes of its content; all of them, if it is whole.
void Reader::TakeRecord(Op op, std::uint64_t offset, std::uint64_t there, bool whole) {
  const bool taken =
      op == Op::kChunk || (whole && (op == Op::kSchema || op == Op::kChannel || op == Op::kMessage ||
                                     op == Op::kAttachment || op == Op::kMetadata));
  if (!taken) {
    if (whole && op != Op::kMessageIndex && static_cast<std::uint8_t>(op) < 0x80)
      Note(offset, fmt::format("a record of kind {:#04x}, which is not known here, is passed over",
                               static_cast<int>(op)));
    return;
  }
  if (there > kMostInMemory) throw Malformed(fmt::format("a {} of {} bytes", NameOf(op), there));
  std::string content = file_.At(offset + kRecordHead, there);
  switch (op) {
    case Op::kChunk:
      given_ = OpenChunk(offset, content);
      break;
    case Op::kSchema:
      summary_.TakeSchema(content);
      break;
    case Op::kChannel:
      summary_.TakeChannel(content);
      break;
    case Op::kAttachment:
      summary_.TakeAttachment(offset, content);
      break;
    case Op::kMetadata:
      summary_.TakeMetadata(offset, content);
      break;
    default:
      given_ = std::make_unique<Open>();
      given_->bytes = std::move(content);
      given_->Take(given_->bytes, *this);
  }
}

}  // namespace kestrel::mcap
