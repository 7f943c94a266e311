// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/command_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <sstream>
#include <string>
#include <string_view>

#include "app/simulated/list_command.h"
#include "base/process/end_signals.h"

namespace kestrel::app {
namespace {

void End(int) {
  constexpr std::string_view kText = "kestrel: interrupted before anything flew\n";
  if (write(STDERR_FILENO, kText.data(), kText.size()) < 0) _exit(3);
  _exit(3);
}

}  // namespace

std::string NoneNamed(const std::string& kind) {
  std::string text = fmt::format("kestrel: no {0} is named; valid: a {0}'s YAML file, or one of", kind);
  std::istringstream lines(ListText(kind + 's'));
  for (std::string line; std::getline(lines, line);) text += "\n  " + line;
  return text;
}

void RefuseReportOf(const char* kind, const std::filesystem::path& data, Mistakes& mistakes) {
  std::error_code none;
  if (std::filesystem::exists(data, none))
    mistakes.Add("--out", "",
                 fmt::format("{} is of a {}, whose report.html would be replaced", data.string(), kind),
                 "valid: another folder");
}

void EndOnInterrupt() { OnEndSignals(End); }

}  // namespace kestrel::app
