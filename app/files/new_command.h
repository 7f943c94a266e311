// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "app/files/file_kinds.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel new`: a file of a kind to begin with, in which every key stands with its meaning.
struct NewArguments {
  std::string kind;
  std::filesystem::path file;                   // empty: standard output
  std::map<std::string, std::string> variants;  // by selector: mission, model, kind
};

CLI::App* AddNewCommand(CLI::App& app, NewArguments& arguments);

// Throws InputError: there is such a file already, or it cannot be written, or the kind has no such variant.
void NewCommand(const NewArguments& arguments);

// What must be given, and what a variant is about, stands as it is; all other keys as comments, with their defaults.
std::string NewFile(const FileKind& kind, const FileKind::Variant& variant);

}  // namespace kestrel::app
