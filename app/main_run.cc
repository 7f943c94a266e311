// SPDX-License-Identifier: Apache-2.0
// The program `kestrel-run`: the verbs of `kestrel` that a first flight needs, without what campaigns, benchmarks and
// calibration are built of. `./kestrel run` builds this one, in a third of the time.
#include "app/option/exit_status.h"
#include "app/option/program.h"
#include "app/page/report_command.h"
#include "app/run/check_command.h"
#include "app/run/demo_command.h"
#include "app/run/isa_option.h"
#include "app/run/keep_image_memory.h"
#include "app/run/run_command.h"

namespace kestrel::app {
namespace {

int Main(int argc, char** argv) {
  KeepImageMemory();
  Program program("kestrel", "Kestrel: flight by vision, in the loop.");
  CLI::App& line = program.command_line();
  RunArguments run;
  program.Add(AddRunCommand(line, run), [&] { return RunCommand(run); });
  DemoArguments demo;
  program.Add(AddDemoCommand(line, demo), [&] { return DemoCommand(demo); });
  CheckArguments check;
  program.Add(AddCheckCommand(line, check), [&] { return CheckCommand(check), kMet; });
  ReportArguments report;
  program.Add(AddReportCommand(line, report), [&] { return ReportCommand(report), kMet; });
  std::string isa;
  AddIsaOption(line.get_subcommand("run"), isa);
  program.TakePlugins({"run", "check"});
  return program.Run(argc, argv, [&] { GoBy(isa, argv); });
}

}  // namespace
}  // namespace kestrel::app

int main(int argc, char** argv) { return kestrel::app::ExitWith(kestrel::app::Main(argc, argv)); }
