// SPDX-License-Identifier: Apache-2.0
#include "app/page/report_command.h"

#include <fmt/format.h>

#include <optional>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/printable.h"
#include "base/process/print_note.h"
#include "records/page/flight_page.h"
#include "records/page/page_media.h"

namespace kestrel::app {
namespace {

void TellWhatIsLeftOut(const std::filesystem::path& folder) {
  if (folder.empty()) return;
  for (const std::string& each : records::LeftOutOfPage(folder))
    PrintNote("{}: {}\n", Printable(folder.string()), each);
}

}  // namespace

CLI::App* AddReportCommand(CLI::App& app, ReportArguments& a) {
  CLI::App* command = app.add_subcommand(
      "report", "Write a page that shows a flight: its video, its scene, its figures, on one time line");
  command->add_option("folder", a.folder, "Of a flight: what run, serve or fly has written")
      ->type_name("FLIGHT")
      ->required();
  command->add_option("second", a.second, "Of another one, to be laid over it")->type_name("FLIGHT");
  command
      ->add_option("--out", a.out,
                   "Of the page (default: report.html in the folder; of two flights compared.html there)")
      ->type_name("FILE");
  command->footer(
      "Examples:\n  kestrel report results/runs/landing-1\n"
      "  kestrel report results/runs/landing-1 results/runs/landing-2 --out both.html");
  return command;
}

void ReportCommand(const ReportArguments& a) {
  namespace fs = std::filesystem;
  const std::optional<fs::path> second = a.second.empty() ? std::nullopt : std::optional<fs::path>(a.second);
  const fs::path file =
      !a.out.empty() ? fs::path(a.out) : fs::path(a.folder) / (second ? "compared.html" : "report.html");
  Mistakes mistakes;
  for (const std::string& each : {a.folder, a.second})
    if (!each.empty() && !fs::is_directory(each))
      mistakes.Add("report", "", fmt::format("'{}' is no folder", each),
                   "valid: that of a flight, such as results/runs/landing-1");
  mistakes.ThrowIfAny();
  CheckWritableFile(file, "--out", mistakes);
  mistakes.ThrowIfAny();
  const std::string page = records::FlightPage(a.folder, second);
  WriteFile(file, page);
  for (const std::string& each : {a.folder, a.second}) TellWhatIsLeftOut(each);
  fmt::print("{}\n", Printable(file.string()));
}

std::string ReportOf(const std::filesystem::path& folder) {
  try {
    records::WriteFlightPage(folder);
    TellWhatIsLeftOut(folder);
    return (folder / "report.html").string();
  } catch (const std::exception& e) {
    PrintNote("no report.html: {}\n", Printable(e.what()));
    return folder.string();
  }
}

}  // namespace kestrel::app
