// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/journal.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/file/files.h"
#include "base/user_file.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kName = "journal.jsonl";

std::string HashOf(std::string_view bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::string LineOf(const Journal::Key& key, const Journal::Entry& entry) {
  Json line{{"sequence", std::get<0>(key)}, {"frame", std::get<1>(key)}, {"camera", std::get<2>(key)}};
  line["files"] = Json::array();
  for (const WrittenFile& f : entry.files) line["files"].push_back({f.path, f.size, f.hash});
  line["boxes"] = Json::array();
  for (const Box& b : entry.boxes)
    line["boxes"].push_back({b.label, b.u_min, b.v_min, b.u_max, b.v_max, b.pixels});
  return line.dump() + "\n";
}

// None: it was cut off, or one of its files is not there as it was.
std::optional<std::pair<Journal::Key, Journal::Entry>> EntryOf(const std::string& text,
                                                               const fs::path& folder) {
  const Json line = Json::parse(text, nullptr, false);
  if (!line.is_object()) return std::nullopt;
  try {
    Journal::Entry entry;
    for (const Json& f : line.at("files")) {
      entry.files.push_back({f.at(0), f.at(1), f.at(2)});
      std::error_code error;
      if (fs::file_size(folder / entry.files.back().path, error) != entry.files.back().size || error)
        return std::nullopt;
    }
    for (const Json& b : line.at("boxes"))
      entry.boxes.push_back({b.at(0), b.at(1), b.at(2), b.at(3), b.at(4), b.at(5)});
    return std::pair(Journal::Key(line.at("sequence"), line.at("frame"), line.at("camera")), entry);
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

Journal::Journal(fs::path folder) : folder_(std::move(folder)) {
  std::ifstream before(folder_ / kName);
  for (std::string line; std::getline(before, line);)
    if (auto entry = EntryOf(line, folder_)) entries_.insert(std::move(*entry));
  found_ = frames();
  std::string whole;  // without a line that was cut off
  for (const auto& [key, entry] : entries_) whole += LineOf(key, entry);
  WriteFile(folder_ / kName, whole);
  lines_.open(folder_ / kName, std::ios::app | std::ios::binary);
}

std::size_t Journal::frames() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(std::count_if(
      entries_.begin(), entries_.end(), [](const auto& each) { return std::get<1>(each.first) != kTables; }));
}

const Journal::Entry* Journal::Find(const Key& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  return found == entries_.end() ? nullptr : &found->second;
}

void Journal::Write(const Key& key, const std::vector<SetFile>& files, std::vector<Box> boxes) {
  Entry entry{{}, std::move(boxes)};
  try {
    for (const SetFile& file : files) entry.files.push_back(WriteOne(file));
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(
        fmt::format("{}; what is written stays, and the same command goes on with it", e.what()));
  }
  const std::lock_guard lock(mutex_);
  lines_ << LineOf(key, entry) << std::flush;
  if (!lines_)
    throw std::runtime_error(
        fmt::format("cannot write {}: the disk may be full; the same command goes on when there is room",
                    (folder_ / kName).string()));
  entries_[key] = std::move(entry);
}

WrittenFile Journal::WriteOne(const SetFile& file) {
  const fs::path path = folder_ / file.path;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) throw std::runtime_error(fmt::format("cannot write {}: {}", path.string(), error.message()));
  WriteFile(path, file.bytes);
  return {file.path, file.bytes.size(), HashOf(file.bytes)};
}

std::vector<WrittenFile> Journal::Files() const {
  const std::lock_guard lock(mutex_);
  std::vector<WrittenFile> all;
  for (const auto& [key, entry] : entries_) all.insert(all.end(), entry.files.begin(), entry.files.end());
  std::sort(all.begin(), all.end(), [](const auto& x, const auto& y) { return x.path < y.path; });
  return all;
}

void Journal::Remove() {
  lines_.close();
  fs::remove(folder_ / kName);
}

}  // namespace kestrel::flight
