// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

// Where models/, scenarios/ and the report's page lie.
namespace kestrel {

// Kestrel's own: the folder that KESTREL_ROOT of the environment names; share/kestrel of the prefix that the
// program is installed in; or, of a program in a build folder, the source. Throws InputError: there is none.
std::filesystem::path Root();

// Those that a name is looked for in, the first that has it: the folders of KESTREL_PATH of the environment,
// separated by colons, then Kestrel's own. Throws InputError: one of them is not there, or there is none.
std::vector<std::filesystem::path> DataFolders();

// A file or folder of the first data folder that has it, by its path below ("models/pads/helipad"); of the
// last one where none has it.
std::filesystem::path DataFile(const std::filesystem::path& path);

// Folders, or files of an ending, in a folder: sorted, without the ending.
std::vector<std::string> NamesIn(const std::filesystem::path& folder, const std::string& ending);
// The same of a path below all data folders: each name once.
std::vector<std::string> DataNames(const std::filesystem::path& path, const std::string& ending);

}  // namespace kestrel
