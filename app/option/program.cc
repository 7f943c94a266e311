// SPDX-License-Identifier: Apache-2.0
#include "app/option/program.h"

#include <csignal>
#include <exception>
#include <opencv2/core/utility.hpp>
#include <utility>

#include "app/option/exit_status.h"
#include "app/option/parse_command_line.h"
#include "app/option/plugin_option.h"
#include "base/diagnostics.h"
#include "base/printable.h"
#include "base/process/print_note.h"
#include "base/version.h"
#include "flight/load_plugins.h"

namespace kestrel::app {

Program::Program(const std::string& name, const std::string& description) : command_line_(description, name) {
  command_line_.require_subcommand(1);
  command_line_.set_version_flag("--version", Version());
}

void Program::Add(CLI::App* verb, std::function<int()> act) { verbs_.push_back({verb, std::move(act)}); }

void Program::TakePlugins(const std::vector<std::string>& verbs) {
  for (const std::string& verb : verbs) AddPluginOption(command_line_.get_subcommand(verb), plugins_);
}

int Program::Run(int argc, char** argv, const std::function<void()>& begin) {
  // Beyond a limit of the shell's for files, writing fails as on a full disk, and is told.
  std::signal(SIGXFSZ, SIG_IGN);
  // The second core draws the next image; threads inside OpenCV would only wait for it.
  cv::setNumThreads(1);
  if (const auto status = ParseCommandLine(command_line_, argc, argv)) return *status;
  try {
    if (begin) begin();
    flight::LoadPlugins(plugins_);
    for (const Verb& verb : verbs_)
      if (*verb.command) return verb.act();
  } catch (const InputError& e) {
    PrintNote("{}\n", e.what());
    return kBadInput;
  } catch (const std::exception& e) {
    PrintNote("kestrel: {}\n", Printable(e.what()));
    return kBrokeOff;
  }
  return kBadInput;
}

}  // namespace kestrel::app
