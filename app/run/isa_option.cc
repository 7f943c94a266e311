// SPDX-License-Identifier: Apache-2.0
#include "app/run/isa_option.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "app/option/within.h"
#include "base/process/own_program.h"
#include "sim/render/ray/instruction_set.h"

namespace kestrel::app {
namespace {

constexpr const char* kVariable = "KESTREL_ISA";

}  // namespace

void AddIsaOption(CLI::App* command, std::string& isa) {
  command
      ->add_option("--isa", isa,
                   fmt::format("Instruction set to keep to: {}. Machines that are to come to the same bits "
                               "take the same (default: the best of each)",
                               fmt::join(sim::InstructionSets(), ", ")))
      ->check(NotEmpty);
  for (CLI::App* each : command->get_subcommands({})) AddIsaOption(each, isa);
}

void GoBy(const std::string& isa, char** arguments) {
  const std::string set = isa.empty() ? ChosenInstructionSet() : isa;
  if (set.empty()) return;
  sim::UseInstructionSet(set, isa.empty() ? kVariable : "--isa");
  bool as_wanted = true;
  for (const auto& [name, value] : sim::EnvironmentOf(set)) {
    const char* const now = std::getenv(name.c_str());
    if (value == (now ? now : "")) continue;
    as_wanted = false;
    value.empty() ? unsetenv(name.c_str()) : setenv(name.c_str(), value.c_str(), 1);
  }
  setenv(kVariable, set.c_str(), 1);
  if (as_wanted) return;
  execv(OwnProgram().c_str(), arguments);
  throw std::runtime_error(
      fmt::format("--isa: cannot begin {} again: {}", OwnProgram().string(), std::strerror(errno)));
}

void GoByTheEnvironment() {
  if (!ChosenInstructionSet().empty()) sim::UseInstructionSet(ChosenInstructionSet(), kVariable);
}

std::string ChosenInstructionSet() {
  const char* const name = std::getenv(kVariable);
  return name ? name : "";
}

}  // namespace kestrel::app
