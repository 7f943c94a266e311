// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/file/files.h"
#include "base/mcap/compression.h"
#include "base/mcap/log_file.h"
#include "base/mcap/wire.h"

namespace kestrel::mcap {

struct WriterOptions {
  std::string profile = "";  // "ros2": channels are of CDR with schemas of ros2msg
  Compression compression = Compression::kZstd;
  std::size_t chunk_bytes = 1u << 20;  // from which on a chunk is closed
};

// Writes an MCAP file: messages in chunks with a check sum and an index each, and behind them the summary by
// which a reader finds a time and a topic. Until it is closed the file has ".part" behind its name; each
// chunk is with the system when it is closed, so that what a dying program leaves is a file that was cut
// after its last whole chunk.
//
// Throws std::runtime_error with the file and the reason.
class Writer {
 public:
  explicit Writer(const std::filesystem::path& file, WriterOptions options = {});

  // The number to write its messages by.
  std::uint16_t Add(const Channel& channel);
  // sequence: counted by channel. Times in any order; in their order a file is read with the least memory.
  void Write(std::uint16_t channel, std::uint64_t log_time_ns, std::string_view data);
  void Write(std::uint16_t channel, std::uint64_t log_time_ns, std::uint64_t publish_time_ns,
             std::string_view data);
  void Attach(const Attachment& attachment);
  void AddMetadata(const std::string& name, const std::map<std::string, std::string>& entries);

  void Close();  // writes what is left and the summary

 private:
  struct ToldSchema {
    Schema is;
    std::string record;  // its content
    bool written = false;
  };
  struct Told {
    Channel is;
    std::string record;      // its content
    std::size_t schema = 0;  // from 1; 0: none
    bool written = false;
    std::uint32_t messages = 0;
    std::string index;  // of the open chunk
  };

  std::size_t Add(const Schema& schema);
  void WriteBytes(std::string_view bytes);
  void EndChunk();
  std::string Summary() const;

  PartFile file_;
  WriterOptions options_;
  std::uint64_t offset_ = 0;  // written so far
  std::vector<ToldSchema> schemas_;
  std::vector<Told> channels_;

  std::string chunk_;  // its records, uncompressed
  struct Span {
    std::uint64_t messages = 0, first_ns = 0, last_ns = 0;
    void Add(std::uint64_t time_ns);
  } in_chunk_, in_all_;
  std::vector<std::string> chunk_index_, attachment_index_, metadata_index_;  // contents of records
};

}  // namespace kestrel::mcap
