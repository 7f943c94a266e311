// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "app/files/file_kinds.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel schema`: a JSON Schema (draft 7) of a kind of file, by which editors complete, explain and check it.
struct SchemaArguments {
  std::string kind;
};

CLI::App* AddSchemaCommand(CLI::App& app, SchemaArguments& arguments);
void SchemaCommand(const SchemaArguments& arguments);

std::string JsonSchema(const FileKind& kind);

}  // namespace kestrel::app
