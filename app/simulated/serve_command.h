// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/option/live_option.h"
#include "flight/served/serve_arguments.h"

namespace CLI {
class App;
}

namespace kestrel::app {

struct ServeCommandArguments : flight::ServeArguments {
  LiveArguments live;
};

// The verb with its options.
CLI::App* AddServeCommand(CLI::App& app, ServeCommandArguments& arguments);

// Serves until the end or an interrupt, and prints where and how it went: the exit status. Throws InputError
// with every mistake of the arguments, and as ServeFlight does.
int ServeCommand(const ServeCommandArguments& arguments);

}  // namespace kestrel::app
