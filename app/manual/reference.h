// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kestrel::app {

// docs/reference/commands.md: all verbs with their options, as Markdown.
std::string CommandReference(const CLI::App& app);

}  // namespace kestrel::app
