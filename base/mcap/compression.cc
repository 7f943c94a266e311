// SPDX-License-Identifier: Apache-2.0
#include "base/mcap/compression.h"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace kestrel::mcap {
namespace {

constexpr std::size_t kFirstPiece = 1u << 20;

// The decoder's next piece: whether it came to an end, by the bytes that it took and gave; throws what it
// says.
struct Progress {
  std::size_t taken = 0, given = 0;
  bool ended = false;
};

// next(from, to, to_size) for as long as it goes on.
template <class Next>
Decompressed InPieces(std::string_view bytes, std::uint64_t size, Next next) {
  Decompressed out;
  std::size_t filled = 0;
  try {
    for (bool ended = false; !ended;) {
      if (filled == out.bytes.size() && filled < size)
        out.bytes.resize(std::min<std::uint64_t>(size, std::max(kFirstPiece, 2 * filled)));
      // One more byte than it may have tells whether it would give more.
      char beyond = 0;
      const bool full = filled == size;
      const Progress step =
          full ? next(bytes, &beyond, 1) : next(bytes, &out.bytes[filled], out.bytes.size() - filled);
      if (full && step.given > 0) throw std::runtime_error("more than it is said to hold");
      if (!full) filled += step.given;
      bytes.remove_prefix(step.taken);
      ended = step.ended;
      if (!ended && step.taken == 0 && step.given == 0) throw std::runtime_error("it was cut");
    }
    if (filled < size)
      throw std::runtime_error(fmt::format("{} bytes where it is said to hold {}", filled, size));
  } catch (const std::runtime_error& e) {
    out.error = e.what();
  }
  out.bytes.resize(filled);
  return out;
}

Decompressed FromZstd(std::string_view bytes, std::uint64_t size) {
  const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                          ZSTD_freeDStream);
  return InPieces(bytes, size, [&](std::string_view from, char* to, std::size_t to_size) {
    ZSTD_inBuffer in{from.data(), from.size(), 0};
    ZSTD_outBuffer out{to, to_size, 0};
    const std::size_t rc = ZSTD_decompressStream(stream.get(), &out, &in);
    if (ZSTD_isError(rc)) throw std::runtime_error(ZSTD_getErrorName(rc));
    return Progress{in.pos, out.pos, rc == 0};
  });
}

Decompressed FromLz4(std::string_view bytes, std::uint64_t size) {
  LZ4F_dctx* context = nullptr;
  LZ4F_createDecompressionContext(&context, LZ4F_VERSION);
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> owner(
      context, LZ4F_freeDecompressionContext);
  return InPieces(bytes, size, [&](std::string_view from, char* to, std::size_t to_size) {
    std::size_t taken = from.size(), given = to_size;
    const std::size_t rc = LZ4F_decompress(context, to, &given, from.data(), &taken, nullptr);
    if (LZ4F_isError(rc)) throw std::runtime_error(LZ4F_getErrorName(rc));
    return Progress{taken, given, rc == 0};
  });
}

std::string ToZstd(std::string_view bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1);
  if (ZSTD_isError(size)) throw std::runtime_error(ZSTD_getErrorName(size));
  out.resize(size);
  return out;
}

std::string ToLz4(std::string_view bytes) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.contentSize = bytes.size();
  std::string out(LZ4F_compressFrameBound(bytes.size(), &preferences), '\0');
  const std::size_t size =
      LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), &preferences);
  if (LZ4F_isError(size)) throw std::runtime_error(LZ4F_getErrorName(size));
  out.resize(size);
  return out;
}

}  // namespace

std::string_view NameOf(Compression compression) {
  return compression == Compression::kLz4 ? "lz4" : compression == Compression::kZstd ? "zstd" : "";
}

std::string Compress(Compression compression, std::string_view bytes) {
  if (compression == Compression::kZstd) return ToZstd(bytes);
  if (compression == Compression::kLz4) return ToLz4(bytes);
  return std::string(bytes);
}

Decompressed Decompress(std::string_view name, std::string_view bytes, std::uint64_t size) {
  if (name == "zstd") return FromZstd(bytes, size);
  if (name == "lz4") return FromLz4(bytes, size);
  if (!name.empty()) return {"", fmt::format("compression '{}' is not known; valid: lz4, zstd, none", name)};
  return {
      std::string(bytes.substr(0, size)),
      bytes.size() == size ? "" : fmt::format("{} bytes where it is said to hold {}", bytes.size(), size)};
}

}  // namespace kestrel::mcap
