// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace CLI {
class App;
}

namespace kestrel::app {

// Parses a command line whose verbs are subcommands. `help` and `version` do as --help and --version do.
// Where nothing remains to be done, or the command line is wrong, the text is printed and the exit status
// returned: 0 or 2. A verb or an option that is not known is answered with the nearest one that is.
std::optional<int> ParseCommandLine(CLI::App& app, int argc, const char* const* argv);

}  // namespace kestrel::app
