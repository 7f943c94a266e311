// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/board_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "base/file/data_folders.h"
#include "base/nearest_name.h"
#include "base/user_file.h"

namespace kestrel::vision {

namespace fs = std::filesystem;

Board LoadBoardNamed(const std::string& name, const Place& where, Mistakes& mistakes) {
  if (name.find('/') != std::string::npos || name.ends_with(".yaml") || name.ends_with(".yml")) {
    if (IsFile(name)) return LoadBoard(name, mistakes);
    mistakes.Add(where, "", NoSuchFile(name));
    return {};
  }
  const fs::path file = DataFile("models/boards/" + name + ".yaml");
  if (IsFile(file)) return LoadBoard(file, mistakes);
  const std::vector<std::string> names = DataNames("models/boards", ".yaml");
  const auto near = NearestName(name, names);
  mistakes.Add(where, "", fmt::format("there is no board '{}'", name),
               near ? fmt::format("did you mean '{}'?", *near)
                    : fmt::format("valid: {}, or a target file of Kalibr", fmt::join(names, ", ")));
  return {};
}

}  // namespace kestrel::vision
