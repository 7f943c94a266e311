// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

// Of the records of a chunk.
namespace kestrel::mcap {

enum class Compression { kNone, kLz4, kZstd };  // LZ4's frame format, Zstandard

std::string_view NameOf(Compression compression);  // as a chunk has it: "", "lz4", "zstd"

// At the fastest level: what a log is made of is images that are compressed already, and numbers.
std::string Compress(Compression compression, std::string_view bytes);

struct Decompressed {
  std::string bytes;
  std::string error;  // why these are not all; empty: they are
};

// As far as it goes: of bytes that were cut or are damaged those that came before. Never more than `size`,
// what it is said to be; memory grows by what comes, not by what is said. name: as a chunk has it.
Decompressed Decompress(std::string_view name, std::string_view bytes, std::uint64_t size);

}  // namespace kestrel::mcap
