// SPDX-License-Identifier: Apache-2.0
// The source against its design: what each room may include, held against what it does include.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace kestrel {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;
using Names = std::set<std::string>;

const fs::path kRoot = KESTREL_SOURCE_DIR;

// The design: whose rooms those of each layer may include, beside its own.
const std::map<std::string, Names> kLayers = {
    {"base", {}},
    {"geometry", {"base"}},
    {"vision", {"base", "geometry"}},
    {"control", {"base", "geometry"}},
    {"sim", {"base", "geometry", "vision", "control"}},
    {"mission", {"base", "geometry", "vision", "control"}},
    {"records", {"base", "geometry", "vision", "control", "mission"}},
    {"scenarios", {"base", "geometry", "vision", "control", "mission", "records"}},
    {"flight", {"base", "geometry", "vision", "control", "sim", "mission", "records", "scenarios"}},
    {"campaign", {"base", "geometry", "vision", "control", "sim", "mission", "records", "flight"}},
    {"bench", {"base", "geometry", "vision", "control", "sim", "mission", "records", "flight", "campaign"}},
    {"app",
     {"base", "geometry", "vision", "control", "sim", "mission", "records", "scenarios", "flight", "campaign",
      "bench"}},
    {"python", {"base", "geometry", "vision", "control", "sim", "mission", "records", "scenarios", "flight"}},
};

std::string LayerOf(const std::string& room) { return room.substr(0, room.find('/')); }

struct Room {
  Names by_headers, by_sources;  // rooms that they may include, or do
};
using Rooms = std::map<std::string, Room>;

// As CMake has them: "ROOM PUBLIC ... PRIVATE ..." to a line, libraries among the rooms.
Rooms Declared() {
  Rooms rooms;
  std::ifstream file(KESTREL_ROOMS);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string room, word;
    words >> room;
    Room& declared = rooms[room];
    Names* to = &declared.by_sources;
    while (words >> word) {
      if (word == "PUBLIC" || word == "PRIVATE")
        to = word == "PUBLIC" ? &declared.by_headers : &declared.by_sources;
      else if (fs::is_directory(kRoot / word))
        to->insert(word);
    }
  }
  return rooms;
}

bool IsSource(const fs::path& file) { return file.extension() == ".h" || file.extension() == ".cc"; }

std::vector<fs::path> Sources() {
  std::vector<fs::path> all;
  for (const auto& [layer, allowed] : kLayers)
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / layer))
      if (IsSource(entry.path())) all.push_back(fs::relative(entry.path(), kRoot));
  return all;
}

// The files of ours that a file includes.
Names IncludedBy(const fs::path& file) {
  Names all;
  std::ifstream text(kRoot / file);
  const std::string include = "#include \"";
  for (std::string line; std::getline(text, line);)
    if (line.starts_with(include)) {
      const std::string name = line.substr(include.size(), line.find('"', include.size()) - include.size());
      if (kLayers.contains(LayerOf(name))) all.insert(name);
    }
  return all;
}

Rooms Included() {
  Rooms rooms;
  for (const fs::path& file : Sources()) {
    const std::string room = file.parent_path();
    for (const std::string& name : IncludedBy(file)) {
      const std::string other = fs::path(name).parent_path();
      if (other == room) continue;
      (file.extension() == ".h" ? rooms[room].by_headers : rooms[room].by_sources).insert(other);
    }
  }
  for (auto& [name, room] : rooms)
    for (const std::string& other : room.by_headers) room.by_sources.erase(other);
  return rooms;
}

std::vector<std::string> Difference(const Names& a, const Names& b) {
  std::vector<std::string> only;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(only));
  return only;
}

TEST(Rooms, IncludeWhatTheyDeclareAndDeclareWhatTheyInclude) {
  const Rooms declared = Declared();
  Rooms included = Included();
  ASSERT_GT(declared.size(), 30u);
  for (const auto& [name, room] : declared) {
    const Room& seen = included[name];
    EXPECT_THAT(Difference(seen.by_headers, room.by_headers), IsEmpty())
        << name << ": headers include, PUBLIC lacks";
    EXPECT_THAT(Difference(seen.by_sources, room.by_sources), IsEmpty())
        << name << ": sources include, PRIVATE lacks";
    EXPECT_THAT(Difference(room.by_headers, seen.by_headers), IsEmpty())
        << name << ": PUBLIC, but no header includes";
    EXPECT_THAT(Difference(room.by_sources, seen.by_sources), IsEmpty())
        << name << ": PRIVATE, but no source includes";
  }
  for (const auto& [name, room] : included)
    EXPECT_TRUE(declared.contains(name)) << name << " is no declared room";
}

TEST(Rooms, ArrowsGoTheWayOfTheDesign) {
  for (const fs::path& file : Sources())
    for (const std::string& name : IncludedBy(file)) {
      const std::string from = LayerOf(file), to = LayerOf(name);
      EXPECT_TRUE(from == to || kLayers.at(from).contains(to)) << file << " includes " << name;
    }
}

TEST(Rooms, NoneIncludesItselfByWayOfOthers) {
  const Rooms included = Included();
  Names finished, open;
  std::vector<std::string> way;
  const std::function<void(const std::string&)> visit = [&](const std::string& room) {
    if (finished.contains(room)) return;
    way.push_back(room);
    if (!open.insert(room).second) {
      ADD_FAILURE() << "a cycle: " << testing::PrintToString(way);
    } else if (const auto found = included.find(room); found != included.end()) {
      for (const Names* others : {&found->second.by_headers, &found->second.by_sources})
        for (const std::string& other : *others) visit(other);
    }
    way.pop_back();
    open.erase(room);
    finished.insert(room);
  };
  for (const auto& [name, room] : included) visit(name);
}

TEST(Rooms, HaveNoMoreThan25FilesOfTheirOwn) {
  std::map<std::string, int> files;
  for (const fs::path& file : Sources()) ++files[file.parent_path()];
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "tests"))
    if (IsSource(entry.path())) ++files[fs::relative(entry.path().parent_path(), kRoot)];
  for (const auto& [room, count] : files) EXPECT_LE(count, 25) << room;
}

TEST(Rooms, HaveANamespaceForEachLayer) {
  for (const fs::path& file : Sources()) {
    const std::string layer = LayerOf(file);
    const std::string expected = layer == "base" || layer == "geometry" ? "kestrel" : "kestrel::" + layer;
    std::ifstream text(kRoot / file);
    bool any = false, found = false;
    for (std::string line; std::getline(text, line);) {
      any = any || line.starts_with("namespace kestrel");
      found = found || line.starts_with("namespace " + expected + " {") ||
              line.starts_with("namespace " + expected + "::");
    }
    EXPECT_EQ(found, any) << file << " has nothing in " << expected;
  }
}

}  // namespace
}  // namespace kestrel
