// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

// The bytes of MCAP, version 0, by its published specification (https://mcap.dev/spec): records of an opcode,
// a length of 8 bytes and a content, all numbers little-endian.
namespace kestrel::mcap {

inline constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);

enum class Op : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

inline constexpr std::uint64_t kMostInMemory = 1u << 30;  // of what is read whole: a record, a chunk
inline constexpr std::size_t kRecordHead = 9;             // opcode and length
inline constexpr std::size_t kFooterContent = 20;         // of a fixed size for good
inline constexpr std::size_t kMessageHead = 22;           // of a message's content, before its data

template <std::unsigned_integral Number>
void Put(std::string& to, Number value) {
  for (std::size_t i = 0; i < sizeof(Number); ++i) to.push_back(static_cast<char>(value >> (8 * i) & 0xff));
}
void PutText(std::string& to, std::string_view text);  // its length in 4 bytes before it
void PutMap(std::string& to, const std::map<std::string, std::string>& map);
void PutRecord(std::string& to, Op op, std::string_view content);

std::uint32_t Crc32(std::string_view bytes);  // of zlib

// What is not as the specification has it.
struct Malformed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Takes one field after another from bytes of others; each is asked whether it is there before it is read.
// Throws Malformed with the name of the field.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : left_(bytes) {}
  std::size_t left() const { return left_.size(); }

  std::string_view Bytes(std::uint64_t count, const char* name);
  template <std::unsigned_integral Number>
  Number Get(const char* name) {
    const std::string_view bytes = Bytes(sizeof(Number), name);
    Number value = 0;
    for (std::size_t i = 0; i < sizeof(Number); ++i)
      value =
          static_cast<Number>(value | static_cast<Number>(static_cast<unsigned char>(bytes[i])) << (8 * i));
    return value;
  }
  std::string_view Text(const char* name) { return Bytes(Get<std::uint32_t>(name), name); }
  std::map<std::string, std::string> Map(const char* name);

 private:
  std::string_view left_;
};

}  // namespace kestrel::mcap
