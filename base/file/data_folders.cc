// SPDX-License-Identifier: Apache-2.0
#include "base/file/data_folders.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>

#include "base/diagnostics.h"
#include "base/process/own_program.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

std::string FromEnvironment(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

bool IsFolder(const fs::path& path) {
  std::error_code none;
  return fs::is_directory(path, none);
}

// The file that this code is in: the program, or a module that Python has loaded.
fs::path OwnCode() {
  Dl_info info;
  void* found = nullptr;
  static const char here = 0;
  if (dladdr1(&here, &info, &found, RTLD_DL_LINKMAP) == 0) return OwnProgram();
  const char* const name = static_cast<const link_map*>(found)->l_name;
  std::error_code none;
  return name && *name ? fs::weakly_canonical(name, none) : OwnProgram();
}

fs::path InstalledData() { return OwnProgram().parent_path().parent_path() / "share" / "kestrel"; }

// What is installed beside it, or the source of its build folder: a program lies in PREFIX/bin or the build folder or in
// a folder of that, the module of Python at most in PREFIX/lib/python3/dist-packages/kestrel.
std::optional<fs::path> Own() {
  if (const std::string root = FromEnvironment("KESTREL_ROOT"); !root.empty()) return root;
  const fs::path code = OwnCode();
  const int up = code.extension() == ".so" ? 5 : 2;
  fs::path folder = code.parent_path();
  for (int i = 0; i < up; ++i, folder = folder.parent_path()) {
    if (const fs::path installed = folder / "share" / "kestrel"; IsFolder(installed)) return installed;
    std::ifstream file(folder / "kestrel-source.txt");  // as CMake writes it
    if (std::string source; std::getline(file, source) && IsFolder(source)) return source;
  }
  return std::nullopt;
}

[[noreturn]] void RefuseWithoutData() {
  throw InputError(
      "kestrel",
      fmt::format("there is no folder '{}' with its models and scenarios", InstalledData().string()),
      "install Kestrel anew, or name the folder that holds them by KESTREL_ROOT");
}

}  // namespace

fs::path Root() {
  const auto own = Own();
  if (!own) RefuseWithoutData();
  return *own;
}

std::vector<fs::path> DataFolders() {
  std::vector<fs::path> folders;
  Mistakes mistakes;
  std::istringstream path(FromEnvironment("KESTREL_PATH"));
  for (std::string each; std::getline(path, each, ':');) {
    if (each.empty()) continue;
    if (!IsFolder(each))
      mistakes.Add("KESTREL_PATH", "", fmt::format("there is no folder '{}'", each),
                   "valid: folders that hold models/ or scenarios/, separated by colons");
    folders.push_back(each);
  }
  mistakes.ThrowIfAny();
  if (const auto own = Own()) folders.push_back(*own);
  if (folders.empty()) RefuseWithoutData();
  return folders;
}

fs::path DataFile(const fs::path& path) {
  const std::vector<fs::path> folders = DataFolders();
  std::error_code none;
  for (const fs::path& folder : folders)
    if (fs::exists(folder / path, none)) return folder / path;
  return folders.back() / path;
}

std::vector<std::string> NamesIn(const fs::path& folder, const std::string& ending) {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    if (ending.empty() ? entry.is_directory() : entry.path().extension() == ending) {
      names.push_back(entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> DataNames(const fs::path& path, const std::string& ending) {
  std::vector<std::string> names;
  for (const fs::path& folder : DataFolders()) {
    const std::vector<std::string> more = NamesIn(folder / path, ending);
    names.insert(names.end(), more.begin(), more.end());
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace kestrel
