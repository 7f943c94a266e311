// SPDX-License-Identifier: Apache-2.0
#include "campaign/named_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "base/nearest_name.h"
#include "base/user_file.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;

std::string LastPart(const std::string& full_name) { return full_name.substr(full_name.find('/') + 1); }

// Of a name as it was meant, in full or not.
std::vector<std::string> NearestOf(const std::string& name, const std::vector<std::string>& full_names) {
  std::vector<std::string> near;
  if (const auto full = NearestName(name, full_names)) return {*full};
  std::vector<std::string> last_parts;
  std::transform(full_names.begin(), full_names.end(), std::back_inserter(last_parts), LastPart);
  if (const auto last = NearestName(name, last_parts))
    std::copy_if(full_names.begin(), full_names.end(), std::back_inserter(near),
                 [&](const std::string& each) { return LastPart(each) == *last; });
  return near;
}

}  // namespace

std::vector<std::string> NamesOfKind(const std::string& kind) {
  std::vector<std::string> names;
  for (const std::string& flight : DataNames("scenarios", ""))
    for (const std::string& name : DataNames(fs::path("scenarios") / flight / (kind + 's'), ".yaml"))
      names.push_back(flight + '/' + name);
  return names;
}

fs::path NamedFile(const std::string& kind, const std::string& name_or_file) {
  const fs::path file = name_or_file;
  if (file.has_extension() || IsFile(file)) return file;
  const std::vector<std::string> names = NamesOfKind(kind);
  std::vector<std::string> found;
  for (const std::string& name : names)
    if (name_or_file == name || name_or_file == LastPart(name)) found.push_back(name);
  if (found.size() == 1) {
    const std::size_t slash = found.front().find('/');
    return DataFile(fs::path("scenarios") / found.front().substr(0, slash) / (kind + 's') /
                    (LastPart(found.front()) + ".yaml"));
  }
  if (!found.empty())
    throw InputError(kind, fmt::format("'{}' is the name of {}", name_or_file, found.size()),
                     fmt::format("valid: {}", fmt::join(found, ", ")));
  const std::vector<std::string> near = NearestOf(name_or_file, names);
  if (near.empty() && file.has_parent_path()) return file;
  throw InputError(kind, fmt::format("there is no {} '{}'", kind, name_or_file),
                   near.empty() ? fmt::format("valid: {}", fmt::join(names, ", "))
                                : fmt::format("did you mean '{}'?", fmt::join(near, "' or '")));
}

}  // namespace kestrel::campaign
