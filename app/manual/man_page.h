// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kestrel::app {

// The man page of a program with all its verbs, in roff (man(7)).
std::string ManPage(const CLI::App& app, const std::string& version);

}  // namespace kestrel::app
