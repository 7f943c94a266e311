// SPDX-License-Identifier: Apache-2.0
#include "flight/load_plugins.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "base/diagnostics.h"
#include "base/user_file.h"
#include "base/version.h"
#include "mission/plugin.h"
#include "scenarios/flights.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVariable = "KESTREL_PLUGINS";
constexpr const char* kRemedy = "build it with this one's kestrel::plugin (docs/extend/plugin.md)";

std::vector<std::string>& Loaded() {
  static std::vector<std::string> files;
  return files;
}

std::vector<std::string> WithThoseOfTheEnvironment(std::vector<std::string> files) {
  const char* const named = std::getenv(kVariable);
  std::istringstream all(named ? named : "");
  for (std::string each; std::getline(all, each, ':');)
    if (!each.empty()) files.push_back(each);
  return files;
}

// What a plug-in says that it was built with; empty: it is none.
std::string BuiltWith(const std::string& bytes) {
  const std::string mark = KESTREL_PLUGIN_MARK_;
  const std::size_t at = bytes.find(mark);
  return at == std::string::npos ? "" : std::string(bytes.c_str() + at + mark.size());
}

// A file that was found, or what is wrong with it.
void Load(const fs::path& file, const std::string& named, Mistakes& mistakes) {
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty()) return mistakes.Add(named, "", content.error);
  const std::string with = BuiltWith(content.bytes);
  const std::string here = fmt::format("{}, " KESTREL_COMPILER_, Version());
  if (with.empty())
    return mistakes.Add(named, "", "is no plug-in of Kestrel", "valid: a shared object with KESTREL_PLUGIN");
  if (with != here)
    return mistakes.Add(named, "", fmt::format("was built for Kestrel {}, and this is {}", with, here),
                        kRemedy);
  void* const object = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!object) return mistakes.Add(named, "", fmt::format("cannot be loaded: {}", dlerror()), kRemedy);
  const auto add = reinterpret_cast<void (*)()>(dlsym(object, "kestrel_add_plugin"));
  if (!add) return mistakes.Add(named, "", "has no function of KESTREL_PLUGIN", kRemedy);
  try {
    add();
  } catch (const std::logic_error& e) {
    return mistakes.Add(named, "", e.what(), "valid: a name that no other has");
  }
  Loaded().push_back(file);
}

}  // namespace

void LoadPlugins(const std::vector<std::string>& files) {
  scenarios::AddFlights();  // first, so that a name that both have is the plug-in's mistake
  Mistakes mistakes;
  const std::vector<std::string>& loaded = LoadedPlugins();
  for (const std::string& named : WithThoseOfTheEnvironment(files)) {
    std::error_code none;
    const fs::path file = fs::weakly_canonical(fs::absolute(named, none), none);
    if (std::find(loaded.begin(), loaded.end(), file) != loaded.end()) continue;
    if (!IsFile(file))
      mistakes.Add("--plugin or " + std::string(kVariable), "", NoSuchFile(named));
    else if (file.string().find(':') != std::string::npos)
      mistakes.Add(named, "", fmt::format("has a colon in '{}'", file.string()), "valid: a path without");
    else
      Load(file, named, mistakes);
  }
  mistakes.ThrowIfAny();
  if (loaded.empty()) return;
  setenv(kVariable, fmt::format("{}", fmt::join(loaded, ":")).c_str(), 1);
}

const std::vector<std::string>& LoadedPlugins() { return Loaded(); }

}  // namespace kestrel::flight
