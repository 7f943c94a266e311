// SPDX-License-Identifier: Apache-2.0
#include "records/page/page_media.h"

#include <fmt/format.h>

#include <cstdint>

#include "base/file/files.h"
#include "base/html/html.h"

namespace kestrel::records {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxMediaBytes = std::uintmax_t{64} << 20;

std::uint32_t BigEndian(std::string_view bytes) {
  std::uint32_t number = 0;
  for (int i = 0; i < 4; ++i) number = number << 8 | static_cast<unsigned char>(bytes[i]);
  return number;
}
std::uint32_t LittleEndian(std::string_view bytes) {
  std::uint32_t number = 0;
  for (int i = 3; i >= 0; --i) number = number << 8 | static_cast<unsigned char>(bytes[i]);
  return number;
}

// ISO/IEC 14496-12: boxes one behind the other, each with its size and its type; "moov" is the index.
std::string WrongWithMp4(std::string_view bytes) {
  if (bytes.size() < 8 || bytes.substr(4, 4) != "ftyp") return "is no MP4";
  bool index = false;
  while (!bytes.empty()) {
    if (bytes.size() < 8) return "is cut off";
    std::uint64_t size = BigEndian(bytes);
    index = index || bytes.substr(4, 4) == "moov";
    if (size == 0) break;  // to the end of the file
    if (size == 1) {       // in the eight bytes behind the type
      if (bytes.size() < 16) return "is cut off";
      size = std::uint64_t{BigEndian(bytes.substr(8))} << 32 | BigEndian(bytes.substr(12));
    }
    if (size < 8) return "is damaged";
    if (size > bytes.size()) return "is cut off";
    bytes.remove_prefix(size);
  }
  return index ? "" : "is cut off";
}

// glTF 2.0, 4.4: a magic word, the version and the length of the whole.
std::string WrongWithGlb(std::string_view bytes) {
  if (bytes.size() < 12 || bytes.substr(0, 4) != "glTF") return "is no binary glTF";
  return LittleEndian(bytes.substr(8)) == bytes.size() ? "" : "is cut off";
}

struct Media {
  const char *id, *file;
  std::string (*wrong)(std::string_view bytes);
};
constexpr Media kMedia[] = {{"video", "video.mp4", WrongWithMp4},
                            {"view", "view.mp4", WrongWithMp4},
                            {"scene", "scene.glb", WrongWithGlb}};

struct ReadMedia {
  std::string bytes;  // empty: it cannot be shown, or is not there
  std::string wrong;  // why it cannot; empty: it can, or is not there
};

ReadMedia Read(const fs::path& folder, const Media& media) {
  const fs::path file = folder / media.file;
  if (!IsFile(file)) return {};
  std::error_code none;
  if (fs::file_size(file, none) > kMaxMediaBytes) return {{}, "is too large for a page"};
  ReadMedia read{ReadFile(file), {}};
  read.wrong = media.wrong(read.bytes);
  if (!read.wrong.empty()) read.bytes.clear();
  return read;
}

}  // namespace

std::string MediaElement(std::string_view id, std::string_view bytes) {
  if (bytes.empty()) return {};
  return fmt::format("<script type=\"text/plain\" id=\"{}\">{}</script>\n", id, Base64(bytes));
}

std::string MediaElements(const fs::path& folder, std::string_view suffix) {
  std::string elements;
  for (const Media& each : kMedia)
    elements += MediaElement(fmt::format("{}{}", each.id, suffix), Read(folder, each).bytes);
  return elements;
}

std::vector<std::string> LeftOutOfPage(const fs::path& folder) {
  std::vector<std::string> all;
  for (const Media& each : kMedia)
    if (const std::string wrong = Read(folder, each).wrong; !wrong.empty())
      all.push_back(fmt::format("{} {}", each.file, wrong));
  const fs::path table = folder / "telemetry.csv";
  if (!IsFile(table) && !IsFile(PartOf(table)))
    all.push_back("telemetry.csv is missing, and so are all plots and paths");
  return all;
}

}  // namespace kestrel::records
