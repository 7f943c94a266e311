// SPDX-License-Identifier: Apache-2.0
// The program `kestrel`, with all that the simulator does.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

#include "app/bench/bench_command.h"
#include "app/camera/calibrate_command.h"
#include "app/camera/mirror_command.h"
#include "app/campaign/campaign_command.h"
#include "app/campaign/margins_command.h"
#include "app/campaign/tune_command.h"
#include "app/dataset/dataset_command.h"
#include "app/files/explain_command.h"
#include "app/files/file_reference.h"
#include "app/files/new_command.h"
#include "app/files/schema_command.h"
#include "app/files/vehicle_command.h"
#include "app/flight/export_command.h"
#include "app/flight/identify_command.h"
#include "app/flight/replay_command.h"
#include "app/manual/manual_command.h"
#include "app/mosaic/mosaic_command.h"
#include "app/option/exit_status.h"
#include "app/option/program.h"
#include "app/page/report_command.h"
#include "app/reproduce/reproduce_command.h"
#include "app/run/check_command.h"
#include "app/run/demo_command.h"
#include "app/run/isa_option.h"
#include "app/run/keep_image_memory.h"
#include "app/run/picture_command.h"
#include "app/run/run_command.h"
#include "app/simulated/encounters_command.h"
#include "app/simulated/horizon_command.h"
#include "app/simulated/list_command.h"
#include "app/simulated/render_board.h"
#include "app/simulated/serve_command.h"
#include "app/simulated/track_command.h"
#include "app/simulated/view_command.h"
#include "app/stabilise/stabilise_command.h"
#include "flight/served/wire_flight.h"

namespace kestrel::app {
namespace {

// Of the program for real aircraft, which is a program of its own, so that it holds nothing of the simulator.
CLI::App* AddFlyVerb(CLI::App& app) {
  CLI::App* verb =
      app.add_subcommand("fly", "Fly a real aircraft: what follows goes to kestrel-fly beside this program");
  verb->set_help_flag();
  return verb->prefix_command();
}

// Does not return but by an exception.
void HandOverToFly(char** argv) {
  const std::string program = flight::HardwareProgram().string();
  execv(program.c_str(), argv);
  throw std::runtime_error(fmt::format("cannot start {}: {}", program, std::strerror(errno)));
}

int Main(int argc, char** argv) {
  KeepImageMemory();
  Program program(
      "kestrel",
      "Kestrel: flight by vision, in the loop.\n\nExit status: 0 the run met its criteria, 1 it did not, "
      "2 bad input, 3 the run broke off.");
  CLI::App& app = program.command_line();
  const auto met = [](bool is) { return is ? kMet : kNotMet; };
  RunArguments run;
  program.Add(AddRunCommand(app, run), [&] { return RunCommand(run); });
  DemoArguments demo;
  program.Add(AddDemoCommand(app, demo), [&] { return DemoCommand(demo); });
  ListArguments list;
  program.Add(AddListCommand(app, list), [&] { return ListCommand(list), kMet; });
  ExplainArguments explain;
  program.Add(AddExplainCommand(app, explain), [&] { return ExplainCommand(explain), kMet; });
  NewArguments begin;
  program.Add(AddNewCommand(app, begin), [&] { return NewCommand(begin), kMet; });
  VehicleArguments vehicle;
  program.Add(AddVehicleCommand(app, vehicle), [&] { return VehicleCommand(vehicle), kMet; });
  SchemaArguments schema;
  program.Add(AddSchemaCommand(app, schema), [&] { return SchemaCommand(schema), kMet; });
  CheckArguments check;
  program.Add(AddCheckCommand(app, check), [&] { return CheckCommand(check), kMet; });
  PictureArguments picture;
  program.Add(AddPictureCommand(app, picture), [&] { return PictureCommand(picture), kMet; });
  ServeCommandArguments serve;
  program.Add(AddServeCommand(app, serve), [&] { return ServeCommand(serve); });
  EncountersArguments encounters;
  program.Add(AddEncountersCommand(app, encounters), [&] { return met(EncountersCommand(encounters)); });
  CampaignArguments campaign;
  program.Add(AddCampaignCommand(app, campaign), [&] { return met(CampaignCommand(campaign)); });
  TuneArguments tune;
  program.Add(AddTuneCommand(app, tune), [&] { return met(TuneCommand(tune)); });
  MarginsArguments margins;
  program.Add(AddMarginsCommand(app, margins), [&] { return met(MarginsCommand(margins)); });
  ReproduceArguments reproduce;
  program.Add(AddReproduceCommand(app, reproduce), [&] { return met(ReproduceCommand(reproduce)); });
  BenchArguments bench;
  program.Add(AddBenchCommand(app, bench), [&] { return met(BenchCommand(bench)); });
  ReplayArguments replay;
  program.Add(AddReplayCommand(app, replay), [&] { return met(ReplayCommand(replay)); });
  ReportArguments report;
  program.Add(AddReportCommand(app, report), [&] { return ReportCommand(report), kMet; });
  ExportArguments to_export;
  program.Add(AddExportCommand(app, to_export), [&] { return ExportCommand(to_export), kMet; });
  IdentifyArguments identify;
  program.Add(AddIdentifyCommand(app, identify), [&] { return met(IdentifyCommand(identify)); });
  DatasetCommandArguments dataset;
  program.Add(AddDatasetCommand(app, dataset), [&] { return DatasetCommand(dataset), kMet; });
  MirrorArguments mirror;
  program.Add(AddMirrorCommand(app, mirror), [&] { return MirrorCommand(mirror), kMet; });
  ViewArguments view;
  program.Add(AddViewCommand(app, view), [&] { return ViewCommand(view), kMet; });
  HorizonArguments horizon;
  program.Add(AddHorizonCommand(app, horizon), [&] { return HorizonCommand(horizon), kMet; });
  TrackArguments track;
  program.Add(AddTrackCommand(app, track), [&] { return TrackCommand(track), kMet; });
  MosaicArguments mosaic;
  program.Add(AddMosaicCommand(app, mosaic), [&] { return met(MosaicCommand(mosaic)); });
  StabiliseArguments stabilise;
  program.Add(AddStabiliseCommand(app, stabilise), [&] { return met(StabiliseCommand(stabilise)); });
  CalibrateArguments calibrate;
  program.Add(AddCalibrateCommand(app, calibrate), [&] { return CalibrateCommand(calibrate), kMet; });
  RenderBoardArguments board;
  program.Add(AddRenderBoardCommand(app, board), [&] { return RenderBoardCommand(board), kMet; });
  ManualArguments manual;
  program.Add(AddCompletionCommand(app, manual), [&] { return CompletionCommand(app, manual), kMet; });
  program.Add(AddManCommand(app), [&] { return ManCommand(app), kMet; });
  program.Add(AddReferenceCommand(app, manual), [&] {
    if (manual.page == "files")
      fmt::print("{}", FileReference());
    else
      ReferenceCommand(app);
    return kMet;
  });

  // Of all that fly.
  std::string isa;
  for (const char* name : {"run", "picture", "serve", "encounters", "campaign", "tune", "reproduce", "bench",
                           "replay", "dataset"})
    AddIsaOption(app.get_subcommand(name), isa);
  program.Add(AddFlyVerb(app), [&] { return HandOverToFly(argv), kBrokeOff; });
  program.TakePlugins({"run", "picture", "list", "explain", "new", "schema", "check", "serve", "campaign",
                       "tune", "replay", "export", "dataset"});
  // Last, or each verb without a footer of its own would have this one.
  app.footer(
      "Examples:\n  kestrel run landing\n  kestrel check my_flight.yaml\n"
      "  kestrel bench flights --seeds 1..20\n"
      "  kestrel calibrate photos/*.jpg --model pinhole --out calibration");
  return program.Run(argc, argv, [&] { GoBy(isa, argv); });
}

}  // namespace
}  // namespace kestrel::app

int main(int argc, char** argv) { return kestrel::app::ExitWith(kestrel::app::Main(argc, argv)); }
