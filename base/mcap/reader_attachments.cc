// SPDX-License-Identifier: Apache-2.0
// What a file holds beside its messages.
#include <fmt/format.h>

#include "base/mcap/reader.h"
#include "base/mcap/wire.h"

namespace kestrel::mcap {

std::vector<std::string> Reader::attachment_names() const {
  std::vector<std::string> names;
  for (const auto& [offset, record] : summary_.attachments) names.push_back(record.name);
  return names;
}

std::optional<Attachment> Reader::ReadAttachment(const std::string& name) {
  for (const auto& [offset, record] : summary_.attachments) {
    if (record.name != name) continue;
    try {
      if (record.length > kMostInMemory)
        throw Malformed(fmt::format("an attachment of {} bytes", record.length));
      const std::string bytes = file_.At(offset, record.length);
      Cursor head(bytes);
      if (head.Get<std::uint8_t>("opcode") != static_cast<std::uint8_t>(Op::kAttachment))
        throw Malformed("no attachment, where the summary has one");
      const std::string_view content = head.Bytes(head.Get<std::uint64_t>("length"), "attachment");
      Cursor fields(content);
      Attachment attachment;
      attachment.log_time_ns = fields.Get<std::uint64_t>("log_time");
      fields.Get<std::uint64_t>("create_time");
      attachment.name = fields.Text("name");
      attachment.media_type = fields.Text("media_type");
      attachment.data = fields.Bytes(fields.Get<std::uint64_t>("data"), "data");
      const std::string_view summed = content.substr(0, content.size() - fields.left());
      const auto crc = fields.Get<std::uint32_t>("crc");
      if (crc != 0 && crc != Crc32(summed)) throw Malformed("an attachment whose check sum is another");
      return attachment;
    } catch (const Malformed& e) {
      Note(offset, e.what());
    }
  }
  return std::nullopt;
}

std::map<std::string, std::string> Reader::ReadMetadata(const std::string& name) {
  std::map<std::string, std::string> entries;
  for (const auto& [offset, record] : summary_.metadata) {
    if (record.name != name) continue;
    try {
      if (record.length > kMostInMemory) throw Malformed(fmt::format("metadata of {} bytes", record.length));
      const std::string bytes = file_.At(offset, record.length);
      Cursor fields(bytes);
      fields.Bytes(kRecordHead, "head of metadata");
      fields.Text("name");
      entries.merge(fields.Map("metadata"));
    } catch (const Malformed& e) {
      Note(offset, e.what());
    }
  }
  return entries;
}

}  // namespace kestrel::mcap
