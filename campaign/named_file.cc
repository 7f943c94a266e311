// SPDX-License-Identifier: Apache-2.0
#include "campaign/named_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "base/user_file.h"

namespace kestrel::campaign {

namespace fs = std::filesystem;

fs::path NamedFile(const std::string& kind, const std::string& name_or_file) {
  const fs::path file = name_or_file;
  if (file.has_extension() || IsFile(file)) return file;
  std::vector<std::string> names, of_flights;
  std::vector<fs::path> found;
  for (const std::string& flight : NamesIn(Root() / "scenarios", "")) {
    const fs::path folder = Root() / "scenarios" / flight / (kind + 's');
    for (const std::string& name : NamesIn(folder, ".yaml")) {
      names.push_back(name);
      const std::string of_flight = flight + '/' + name;
      if (name_or_file != name && name_or_file != of_flight) continue;
      of_flights.push_back(of_flight);
      found.push_back(folder / (name + ".yaml"));
    }
  }
  if (found.size() == 1) return found.front();
  if (found.empty() && file.has_parent_path()) return file;
  Mistakes mistakes;
  if (found.empty())
    Known(kind.c_str(), name_or_file, names, "kestrel", mistakes);
  else
    mistakes.Add("kestrel", kind, fmt::format("'{}' is the name of {}", name_or_file, found.size()),
                 fmt::format("valid: {}", fmt::join(of_flights, ", ")));
  throw InputError(mistakes.all());
}

}  // namespace kestrel::campaign
