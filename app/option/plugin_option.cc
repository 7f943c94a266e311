// SPDX-License-Identifier: Apache-2.0
#include "app/option/plugin_option.h"

#include <CLI/CLI.hpp>

namespace kestrel::app {

void AddPluginOption(CLI::App* command, std::vector<std::string>& files) {
  command
      ->add_option("--plugin", files,
                   "Shared object with missions or camera models of your own; may be repeated "
                   "(KESTREL_PLUGINS names more, separated by colons)")
      ->allow_extra_args(false);
  for (CLI::App* each : command->get_subcommands({})) AddPluginOption(each, files);
}

}  // namespace kestrel::app
