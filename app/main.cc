// SPDX-License-Identifier: Apache-2.0
// The command line: reads what is asked for, has it done, and turns the end into an exit status.
#include <fmt/format.h>
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <opencv2/core/utility.hpp>
#include <string>
#include <vector>

#include "app/bench_command.h"
#include "app/camera/calibrate_command.h"
#include "app/camera/mirror_command.h"
#include "app/campaign/campaign_command.h"
#include "app/campaign/tune_command.h"
#include "app/files/explain_command.h"
#include "app/files/file_reference.h"
#include "app/files/new_command.h"
#include "app/files/schema_command.h"
#include "app/flight/replay_command.h"
#include "app/manual/manual_command.h"
#include "app/option/exit_status.h"
#include "app/option/parse_command_line.h"
#include "app/option/plugin_option.h"
#include "app/simulated/check_command.h"
#include "app/simulated/encounters_command.h"
#include "app/simulated/horizon_command.h"
#include "app/simulated/isa_option.h"
#include "app/simulated/list_command.h"
#include "app/simulated/render_board.h"
#include "app/simulated/run_command.h"
#include "app/simulated/serve_command.h"
#include "app/simulated/view_command.h"
#include "base/diagnostics.h"
#include "base/printable.h"
#include "base/process/print_note.h"
#include "base/version.h"
#include "flight/load_plugins.h"

namespace kestrel::app {
namespace {

int Main(int argc, char** argv) {
  // The second core draws the next image; threads inside OpenCV would only wait for it.
  cv::setNumThreads(1);
#ifdef __GLIBC__
  // Images come and go with each frame: their memory is kept, not given back and faulted in again.
  mallopt(M_MMAP_THRESHOLD, 1 << 25);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
  CLI::App app{
      "Kestrel: flight by vision, in the loop.\n\nExit status: 0 the run met its criteria, 1 it did not, "
      "2 bad input, 3 the run broke off.",
      "kestrel"};
  app.require_subcommand(1);
  app.set_version_flag("--version", Version());
  // In the order in which help shows them.
  struct Verb {
    const CLI::App* command;
    std::function<int()> done;
  };
  std::vector<Verb> verbs;
  const auto met = [](bool is) { return is ? kMet : kNotMet; };
  RunArguments run;
  verbs.push_back({AddRunCommand(app, run), [&] { return RunCommand(run); }});
  ListArguments list;
  verbs.push_back({AddListCommand(app, list), [&] { return ListCommand(list), kMet; }});
  ExplainArguments explain;
  verbs.push_back({AddExplainCommand(app, explain), [&] { return ExplainCommand(explain), kMet; }});
  NewArguments begin;
  verbs.push_back({AddNewCommand(app, begin), [&] { return NewCommand(begin), kMet; }});
  SchemaArguments schema;
  verbs.push_back({AddSchemaCommand(app, schema), [&] { return SchemaCommand(schema), kMet; }});
  CheckArguments check;
  verbs.push_back({AddCheckCommand(app, check), [&] { return CheckCommand(check), kMet; }});
  flight::ServeArguments serve;
  verbs.push_back({AddServeCommand(app, serve), [&] { return ServeCommand(serve); }});
  EncountersArguments encounters;
  verbs.push_back(
      {AddEncountersCommand(app, encounters), [&] { return met(EncountersCommand(encounters)); }});
  CampaignArguments campaign;
  verbs.push_back({AddCampaignCommand(app, campaign), [&] { return met(CampaignCommand(campaign)); }});
  TuneArguments tune;
  verbs.push_back({AddTuneCommand(app, tune), [&] { return met(TuneCommand(tune)); }});
  BenchArguments bench;
  verbs.push_back({AddBenchCommand(app, bench), [&] { return met(BenchCommand(bench)); }});
  ReplayArguments replay;
  verbs.push_back({AddReplayCommand(app, replay), [&] { return met(ReplayCommand(replay)); }});
  MirrorArguments mirror;
  verbs.push_back({AddMirrorCommand(app, mirror), [&] { return MirrorCommand(mirror), kMet; }});
  ViewArguments view;
  verbs.push_back({AddViewCommand(app, view), [&] { return ViewCommand(view), kMet; }});
  HorizonArguments horizon;
  verbs.push_back({AddHorizonCommand(app, horizon), [&] { return HorizonCommand(horizon), kMet; }});
  CalibrateArguments calibrate;
  verbs.push_back({AddCalibrateCommand(app, calibrate), [&] { return CalibrateCommand(calibrate), kMet; }});
  RenderBoardArguments board;
  verbs.push_back({AddRenderBoardCommand(app, board), [&] { return RenderBoardCommand(board), kMet; }});
  ManualArguments manual;
  verbs.push_back({AddCompletionCommand(app, manual), [&] { return CompletionCommand(app, manual), kMet; }});
  verbs.push_back({AddManCommand(app), [&] { return ManCommand(app), kMet; }});
  verbs.push_back({AddReferenceCommand(app, manual), [&] {
                     if (manual.page == "files")
                       fmt::print("{}", FileReference());
                     else
                       ReferenceCommand(app);
                     return kMet;
                   }});

  // Of all that fly.
  std::string isa;
  for (const char* name : {"run", "serve", "encounters", "campaign", "tune", "bench", "replay"})
    AddIsaOption(app.get_subcommand(name), isa);
  std::vector<std::string> plugins;
  for (const char* name :
       {"run", "list", "explain", "new", "schema", "check", "serve", "campaign", "tune", "replay"})
    AddPluginOption(app.get_subcommand(name), plugins);
  // Last, or each verb without a footer of its own would have this one.
  app.footer(
      "Examples:\n  kestrel run landing\n  kestrel check my_flight.yaml\n"
      "  kestrel bench flights --seeds 1..20\n"
      "  kestrel calibrate photos/*.jpg --model pinhole --out calibration");

  if (const auto status = ParseCommandLine(app, argc, argv)) return *status;
  try {
    GoBy(isa, argv);
    flight::LoadPlugins(plugins);
    for (const Verb& verb : verbs)
      if (*verb.command) return verb.done();
  } catch (const InputError& e) {
    PrintNote("{}\n", e.what());
    return kBadInput;
  } catch (const std::exception& e) {
    PrintNote("kestrel: {}\n", Printable(e.what()));
    return kBrokeOff;
  }
  return kBadInput;
}

}  // namespace
}  // namespace kestrel::app

int main(int argc, char** argv) { return kestrel::app::ExitWith(kestrel::app::Main(argc, argv)); }
