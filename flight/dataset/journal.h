// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <vector>

#include "flight/dataset/format/format.h"

namespace kestrel::flight {

// A file that is whole.
struct WrittenFile {
  std::string path;
  std::uint64_t size = 0;
  std::string hash;  // XXH128, as xxh128sum prints it
};

// Which frames of a data set are written, kept in a file beside it, a line to each once all its files are
// whole: what was broken off, however, goes on from there. May be used by several threads.
class Journal {
 public:
  struct Entry {
    std::vector<WrittenFile> files;
    std::vector<Box> boxes;
  };
  using Key = std::tuple<int, int, std::size_t>;  // sequence, frame, camera;
                                                  // frame kTables: its tables
  static constexpr int kTables = -1;

  // folder: of the set. What an earlier run has written is taken over where it is still there.
  explicit Journal(std::filesystem::path folder);

  // None: it is still to be written.
  const Entry* Find(const Key& key) const;
  std::size_t found() const { return found_; }  // frames, at the beginning
  std::size_t frames() const;                   // until now

  // Writes the files, and then the line. Throws std::runtime_error.
  void Write(const Key& key, const std::vector<SetFile>& files, std::vector<Box> boxes);

  std::vector<WrittenFile> Files() const;  // all, by their paths
  void Remove();                           // the set is complete

 private:
  WrittenFile WriteOne(const SetFile& file);

  std::filesystem::path folder_;
  mutable std::mutex mutex_;
  std::map<Key, Entry> entries_;
  std::size_t found_ = 0;
  std::ofstream lines_;
};

}  // namespace kestrel::flight
