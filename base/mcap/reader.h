// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/mcap/file_bytes.h"
#include "base/mcap/log_file.h"
#include "base/mcap/summary.h"
#include "base/mcap/wire.h"

namespace kestrel::mcap {

// Reads an MCAP file of whoever: our Writer's, ROS 2's. One that was cut, or is damaged, gives the messages
// that are whole, as far as the bytes before the cut decompress; damage() says what is wrong and where. Every
// length is held against what is left before it is used, and of chunks so many are in memory as overlap in
// time, up to 1 GiB and one more of at most that.
//
//   mcap::Reader reader("flight.mcap");
//   reader.Select({"/imu"});
//   while (const std::optional<mcap::Message> message = reader.Next()) ...
class Reader {
 public:
  // Reads the summary. Without one, or where it is damaged, it goes through the whole file once. Throws
  // InputError: no file, or no MCAP of version 0.
  explicit Reader(const std::filesystem::path& file);
  ~Reader();
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;

  // By their numbers in the file. All that messages refer to.
  const std::map<std::uint16_t, Channel>& channels() const { return summary_.channels; }
  const std::string& profile() const { return profile_; }
  // Of the log times; until < from: there is no message.
  std::uint64_t from_ns() const { return summary_.first_ns; }
  std::uint64_t until_ns() const { return summary_.last_ns; }
  std::uint64_t message_count() const { return summary_.messages; }
  bool indexed() const { return summary_.indexed; }
  // What is wrong and where, the first of it: "byte 4711: ..."; empty: nothing so far. Of what a summary
  // speaks of, the chunks are looked at only when Next() comes to them.
  const std::string& damage() const { return damage_; }

  // From now on Next() gives these topics from the beginning, of log times from `from_ns` to `until_ns`, both
  // included. None: all topics.
  void Select(const std::vector<std::string>& topics, std::uint64_t from_ns = 0,
              std::uint64_t until_ns = std::numeric_limits<std::uint64_t>::max());

  // The next message; none: that was the last. With an index in the order of the log times, and of the file
  // where these are the same; without one in the order of the file. Its data last until the next call, its
  // channel as long as the reader.
  std::optional<Message> Next();

  std::vector<std::string> attachment_names() const;
  std::optional<Attachment> ReadAttachment(const std::string& name);  // none: there is none, or it is damaged
  // The entries of all metadata of that name.
  std::map<std::string, std::string> ReadMetadata(const std::string& name);

 private:
  static constexpr std::uint64_t kEnded = std::numeric_limits<std::uint64_t>::max();
  struct Open;  // a chunk in memory, or a message outside of any

  std::optional<Message> NextByIndex();
  std::optional<Message> NextInFile();
  void TakeRecord(Op op, std::uint64_t offset, std::uint64_t there, bool whole);
  std::unique_ptr<Open> OpenChunk(std::uint64_t offset, std::string_view content);
  void Note(std::uint64_t offset, const std::string& what);

  FileBytes file_;
  std::string profile_;
  std::uint64_t data_begin_ = 0;  // behind the header
  Summary summary_;
  std::string damage_;

  std::optional<std::set<std::uint16_t>> selected_;  // numbers of channels; none: all
  std::uint64_t select_from_ns_ = 0, select_until_ns_ = std::numeric_limits<std::uint64_t>::max();
  std::size_t next_chunk_ = 0;               // of the summary's
  std::uint64_t next_record_ = 0;            // without an index: its offset
  std::vector<std::unique_ptr<Open>> open_;  // with an index: that have messages left
  std::unique_ptr<Open> given_;              // what the last message is of
};

}  // namespace kestrel::mcap
