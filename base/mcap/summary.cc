// SPDX-License-Identifier: Apache-2.0
#include "base/mcap/summary.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/mcap/wire.h"

namespace kestrel::mcap {
namespace {

constexpr std::uint64_t kTail = kRecordHead + kFooterContent + kMagic.size();
constexpr std::uint64_t kMostBytes = 1u << 28;  // of a summary

Summary::Chunk ChunkOf(std::string_view content, std::uint64_t summary_begin) {
  Cursor fields(content);
  Summary::Chunk chunk;
  chunk.from_ns = fields.Get<std::uint64_t>("message_start_time");
  chunk.until_ns = fields.Get<std::uint64_t>("message_end_time");
  chunk.offset = fields.Get<std::uint64_t>("chunk_start_offset");
  chunk.length = fields.Get<std::uint64_t>("chunk_length");
  if (chunk.offset > summary_begin || chunk.length > summary_begin - chunk.offset ||
      chunk.length < kRecordHead)
    throw Malformed(fmt::format("an index of a chunk of {} bytes from {} on, where the data end at {}",
                                chunk.length, chunk.offset, summary_begin));
  for (Cursor offsets(fields.Text("message_index_offsets")); offsets.left() > 0;) {
    chunk.channels.push_back(offsets.Get<std::uint16_t>("message_index_offsets"));
    offsets.Get<std::uint64_t>("message_index_offsets");
  }
  return chunk;
}

std::pair<std::uint64_t, Summary::Record> PlaceOf(std::string_view content, bool attachment) {
  Cursor fields(content);
  const auto offset = fields.Get<std::uint64_t>("offset");
  Summary::Record record{fields.Get<std::uint64_t>("length"), ""};
  if (attachment) fields.Bytes(24, "log_time, create_time, data_size");
  record.name = fields.Text("name");
  return {offset, record};
}

}  // namespace

void Summary::TakeSchema(std::string_view content) {
  Cursor fields(content);
  const auto id = fields.Get<std::uint16_t>("id of a schema");
  Schema schema;
  for (std::string* text : {&schema.name, &schema.encoding, &schema.data}) *text = fields.Text("schema");
  if (id == 0) return;  // "should be ignored by readers"
  if (!(schemas.emplace(id, schema).first->second == schema))
    throw Malformed(fmt::format("schema {} is told twice, and differently", id));
}

void Summary::TakeChannel(std::string_view content) {
  Cursor fields(content);
  const auto id = fields.Get<std::uint16_t>("id of a channel");
  const auto schema_id = fields.Get<std::uint16_t>("schema_id");
  Channel channel;
  channel.topic = fields.Text("topic");
  channel.message_encoding = fields.Text("message_encoding");
  channel.metadata = fields.Map("metadata");
  if (schema_id != 0) {
    const auto schema = schemas.find(schema_id);
    if (schema == schemas.end())
      throw Malformed(fmt::format("channel {} is of schema {}, which is not told before", id, schema_id));
    channel.schema = schema->second;
  }
  if (!(channels.emplace(id, channel).first->second == channel))
    throw Malformed(fmt::format("channel {} is told twice, and differently", id));
}

void Summary::TakeAttachment(std::uint64_t offset, std::string_view content) {
  Cursor fields(content);
  fields.Bytes(16, "log_time, create_time");
  attachments[offset] = {kRecordHead + content.size(), std::string(fields.Text("name"))};
}

void Summary::TakeMetadata(std::uint64_t offset, std::string_view content) {
  Cursor fields(content);
  metadata[offset] = {kRecordHead + content.size(), std::string(fields.Text("name"))};
}

void Summary::CountMessage(std::uint64_t log_time_ns) {
  first_ns = messages == 0 ? log_time_ns : std::min(first_ns, log_time_ns);
  last_ns = messages == 0 ? log_time_ns : std::max(last_ns, log_time_ns);
  ++messages;
}

std::optional<Summary> ReadSummary(const FileBytes& file) {
  if (file.size() < kMagic.size() + kTail) throw Malformed("no footer");
  const std::uint64_t footer = file.size() - kTail;
  const std::string tail = file.At(footer, kTail);
  Cursor fields(tail);
  if (fields.Get<std::uint8_t>("footer") != static_cast<std::uint8_t>(Op::kFooter) ||
      fields.Get<std::uint64_t>("footer") != kFooterContent || !tail.ends_with(kMagic))
    throw Malformed("no footer");
  const auto begin = fields.Get<std::uint64_t>("summary_start");
  const auto offsets = fields.Get<std::uint64_t>("summary_offset_start");
  const auto crc = fields.Get<std::uint32_t>("summary_crc");
  if (begin == 0) return std::nullopt;
  const std::uint64_t end = offsets == 0 ? footer : offsets;
  if (begin < kMagic.size() || begin > end || end > footer || footer - begin > kMostBytes)
    throw Malformed(
        fmt::format("the footer has the summary from {} to {}, itself at {}", begin, end, footer));
  const std::string bytes = file.At(begin, footer + kRecordHead + 16 - begin);
  if (crc != 0 && crc != Crc32(bytes)) throw Malformed("the summary's check sum is another");

  Summary summary;
  std::optional<std::uint32_t> chunks;
  for (Cursor records(std::string_view(bytes).substr(0, end - begin)); records.left() > 0;) {
    const auto op = static_cast<Op>(records.Get<std::uint8_t>("opcode"));
    const std::string_view content =
        records.Bytes(records.Get<std::uint64_t>("length"), "record of the summary");
    if (op == Op::kSchema) summary.TakeSchema(content);
    if (op == Op::kChannel) summary.TakeChannel(content);
    if (op == Op::kChunkIndex) summary.chunks.push_back(ChunkOf(content, begin));
    if (op == Op::kAttachmentIndex) summary.attachments.insert(PlaceOf(content, true));
    if (op == Op::kMetadataIndex) summary.metadata.insert(PlaceOf(content, false));
    if (op == Op::kStatistics) {
      Cursor of(content);
      summary.messages = of.Get<std::uint64_t>("message_count");
      of.Bytes(14, "schema_count, channel_count, attachment_count, metadata_count");
      chunks = of.Get<std::uint32_t>("chunk_count");
      const auto first = of.Get<std::uint64_t>("message_start_time");
      const auto last = of.Get<std::uint64_t>("message_end_time");
      if (summary.messages > 0) summary.first_ns = first, summary.last_ns = last;
    }
  }
  // Without statistics, without chunks, or with more of them than are indexed, the file itself is asked.
  if (!chunks || *chunks != summary.chunks.size() || (summary.chunks.empty() && summary.messages > 0))
    return std::nullopt;
  std::stable_sort(summary.chunks.begin(), summary.chunks.end(),
                   [](const auto& a, const auto& b) { return a.from_ns < b.from_ns; });
  summary.indexed = true;
  return summary;
}

}  // namespace kestrel::mcap
