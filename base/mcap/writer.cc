// SPDX-License-Identifier: Apache-2.0
#include "base/mcap/writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "base/version.h"

namespace kestrel::mcap {
namespace {

constexpr std::size_t kMostNumbers =
    std::numeric_limits<std::uint16_t>::max();  // of channels, and of schemas

}  // namespace

void Writer::Span::Add(std::uint64_t time_ns) {
  first_ns = messages == 0 ? time_ns : std::min(first_ns, time_ns);
  last_ns = messages == 0 ? time_ns : std::max(last_ns, time_ns);
  ++messages;
}

Writer::Writer(const std::filesystem::path& file, WriterOptions options)
    : file_(file), options_(std::move(options)) {
  std::string begin(kMagic), header;
  PutText(header, options_.profile);
  PutText(header, fmt::format("kestrel {}", Version()));
  PutRecord(begin, Op::kHeader, header);
  WriteBytes(begin);
}

void Writer::WriteBytes(std::string_view bytes) {
  file_.Write(bytes);
  offset_ += bytes.size();
}

std::size_t Writer::Add(const Schema& schema) {
  if (schema.encoding.empty()) return 0;
  const auto same = std::find_if(schemas_.begin(), schemas_.end(),
                                 [&](const ToldSchema& each) { return each.is == schema; });
  if (same != schemas_.end()) return static_cast<std::size_t>(same - schemas_.begin()) + 1;
  if (schemas_.size() == kMostNumbers)
    throw std::runtime_error("an MCAP file has no room for another schema");
  ToldSchema told{schema, "", false};
  Put(told.record, static_cast<std::uint16_t>(schemas_.size() + 1));
  for (const std::string* text : {&schema.name, &schema.encoding, &schema.data}) PutText(told.record, *text);
  schemas_.push_back(std::move(told));
  return schemas_.size();
}

std::uint16_t Writer::Add(const Channel& channel) {
  if (channels_.size() == kMostNumbers)
    throw std::runtime_error("an MCAP file has no room for another channel");
  const auto id = static_cast<std::uint16_t>(channels_.size());
  Told told;
  told.is = channel;
  told.schema = Add(channel.schema);
  Put(told.record, id);
  Put(told.record, static_cast<std::uint16_t>(told.schema));
  PutText(told.record, channel.topic);
  PutText(told.record, channel.message_encoding);
  PutMap(told.record, channel.metadata);
  channels_.push_back(std::move(told));
  return id;
}

void Writer::Write(std::uint16_t channel, std::uint64_t log_time_ns, std::string_view data) {
  Write(channel, log_time_ns, log_time_ns, data);
}

void Writer::Write(std::uint16_t channel, std::uint64_t log_time_ns, std::uint64_t publish_time_ns,
                   std::string_view data) {
  Told& to = channels_.at(channel);
  if (!to.written) {
    if (to.schema > 0 && !std::exchange(schemas_[to.schema - 1].written, true))
      PutRecord(chunk_, Op::kSchema, schemas_[to.schema - 1].record);
    PutRecord(chunk_, Op::kChannel, to.record);
    to.written = true;
  }
  Put(to.index, log_time_ns);
  Put(to.index, static_cast<std::uint64_t>(chunk_.size()));
  Put(chunk_, static_cast<std::uint8_t>(Op::kMessage));
  Put(chunk_, static_cast<std::uint64_t>(kMessageHead + data.size()));
  Put(chunk_, channel);
  Put(chunk_, to.messages++);
  Put(chunk_, log_time_ns);
  Put(chunk_, publish_time_ns);
  chunk_ += data;
  in_chunk_.Add(log_time_ns);
  in_all_.Add(log_time_ns);
  if (chunk_.size() >= options_.chunk_bytes) EndChunk();
}

// The chunk, then the index of each channel that is in it.
void Writer::EndChunk() {
  if (in_chunk_.messages == 0) return;
  const std::string records = Compress(options_.compression, chunk_);
  const std::string_view name = NameOf(options_.compression);
  std::string head;
  Put(head, in_chunk_.first_ns);
  Put(head, in_chunk_.last_ns);
  Put(head, static_cast<std::uint64_t>(chunk_.size()));
  Put(head, Crc32(chunk_));
  PutText(head, name);
  Put(head, static_cast<std::uint64_t>(records.size()));
  const std::uint64_t begin = offset_, length = kRecordHead + head.size() + records.size();
  std::string record;
  Put(record, static_cast<std::uint8_t>(Op::kChunk));
  Put(record, static_cast<std::uint64_t>(head.size() + records.size()));
  WriteBytes(record + head);
  WriteBytes(records);

  std::string indexes, offsets;
  for (std::size_t id = 0; id < channels_.size(); ++id) {
    if (channels_[id].index.empty()) continue;
    std::string index;
    Put(index, static_cast<std::uint16_t>(id));
    PutText(index, std::exchange(channels_[id].index, {}));
    Put(offsets, static_cast<std::uint16_t>(id));
    Put(offsets, static_cast<std::uint64_t>(offset_ + indexes.size()));
    PutRecord(indexes, Op::kMessageIndex, index);
  }
  WriteBytes(indexes);
  file_.Flush();

  std::string& at = chunk_index_.emplace_back();
  for (const std::uint64_t number : {in_chunk_.first_ns, in_chunk_.last_ns, begin, length}) Put(at, number);
  PutText(at, offsets);
  Put(at, static_cast<std::uint64_t>(indexes.size()));
  PutText(at, name);
  Put(at, static_cast<std::uint64_t>(records.size()));
  Put(at, static_cast<std::uint64_t>(chunk_.size()));
  chunk_.clear();
  in_chunk_ = {};
}

void Writer::Attach(const Attachment& attachment) {
  EndChunk();
  std::string content, record, index;
  Put(content, attachment.log_time_ns);
  Put(content, std::uint64_t{0});  // when it was made: not told
  PutText(content, attachment.name);
  PutText(content, attachment.media_type);
  Put(content, static_cast<std::uint64_t>(attachment.data.size()));
  content += attachment.data;
  Put(content, Crc32(content));
  PutRecord(record, Op::kAttachment, content);
  for (const std::uint64_t number :
       {offset_, static_cast<std::uint64_t>(record.size()), attachment.log_time_ns, std::uint64_t{0},
        static_cast<std::uint64_t>(attachment.data.size())})
    Put(index, number);
  PutText(index, attachment.name);
  PutText(index, attachment.media_type);
  attachment_index_.push_back(std::move(index));
  WriteBytes(record);
}

void Writer::AddMetadata(const std::string& name, const std::map<std::string, std::string>& entries) {
  EndChunk();
  std::string content, record, index;
  PutText(content, name);
  PutMap(content, entries);
  PutRecord(record, Op::kMetadata, content);
  Put(index, offset_);
  Put(index, static_cast<std::uint64_t>(record.size()));
  PutText(index, name);
  metadata_index_.push_back(std::move(index));
  WriteBytes(record);
}

// From behind DataEnd to the footer, and that without its check sum.
std::string Writer::Summary() const {
  std::string statistics, counts;
  Put(statistics, in_all_.messages);
  std::uint16_t schemas = 0;
  std::uint32_t channels = 0;
  for (const ToldSchema& each : schemas_) schemas = static_cast<std::uint16_t>(schemas + each.written);
  for (std::size_t id = 0; id < channels_.size(); ++id) {
    if (!channels_[id].written) continue;
    ++channels;
    Put(counts, static_cast<std::uint16_t>(id));
    Put(counts, std::uint64_t{channels_[id].messages});
  }
  Put(statistics, schemas);
  Put(statistics, channels);
  for (const auto* index : {&attachment_index_, &metadata_index_, &chunk_index_})
    Put(statistics, static_cast<std::uint32_t>(index->size()));
  Put(statistics, in_all_.first_ns);
  Put(statistics, in_all_.last_ns);
  PutText(statistics, counts);

  std::string summary, offsets;
  const auto group = [&](Op op, const auto& all, auto content) {
    const std::size_t begin = summary.size();
    for (const auto& each : all)
      if (const std::string* record = content(each)) PutRecord(summary, op, *record);
    if (summary.size() == begin) return;
    std::string offset;
    Put(offset, static_cast<std::uint8_t>(op));
    Put(offset, offset_ + begin);
    Put(offset, static_cast<std::uint64_t>(summary.size() - begin));
    PutRecord(offsets, Op::kSummaryOffset, offset);
  };
  const auto told = [](const auto& each) { return each.written ? &each.record : nullptr; };
  const auto whole = [](const std::string& each) { return &each; };
  group(Op::kSchema, schemas_, told);
  group(Op::kChannel, channels_, told);
  group(Op::kStatistics, std::vector<std::string>{statistics}, whole);
  group(Op::kChunkIndex, chunk_index_, whole);
  group(Op::kAttachmentIndex, attachment_index_, whole);
  group(Op::kMetadataIndex, metadata_index_, whole);

  const std::uint64_t offsets_begin = offset_ + summary.size();
  summary += offsets;
  Put(summary, static_cast<std::uint8_t>(Op::kFooter));
  Put(summary, static_cast<std::uint64_t>(kFooterContent));
  Put(summary, offset_);
  Put(summary, offsets_begin);
  return summary;
}

void Writer::Close() {
  EndChunk();
  std::string end, crc;
  Put(crc, std::uint32_t{0});  // none: each chunk has its own
  PutRecord(end, Op::kDataEnd, crc);
  WriteBytes(end);
  std::string summary = Summary();
  Put(summary, Crc32(summary));
  WriteBytes(summary + std::string(kMagic));
  file_.Close();
}

}  // namespace kestrel::mcap
