// SPDX-License-Identifier: Apache-2.0
#include "scenarios/board_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "config/user_file.h"
#include "scenarios/model_files.h"

namespace kestrel {

namespace fs = std::filesystem;

Board LoadBoardNamed(const std::string& name, const std::string& where, Mistakes& mistakes) {
  if (name.find('/') != std::string::npos || name.ends_with(".yaml") || name.ends_with(".yml")) {
    if (IsFile(name)) return LoadBoard(name, mistakes);
    mistakes.Add(where, "", NoSuchFile(name));
    return {};
  }
  const fs::path folder = Root() / "models" / "boards";
  if (IsFile(folder / (name + ".yaml"))) return LoadBoard(folder / (name + ".yaml"), mistakes);
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  const auto near = NearestName(name, names);
  mistakes.Add(
      where, "",
      fmt::format("there is no board '{}'; {}", name,
                  near ? fmt::format("did you mean '{}'?", *near)
                       : fmt::format("valid: {}, or a target file of Kalibr", fmt::join(names, ", "))));
  return {};
}

}  // namespace kestrel
