// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "campaign/report/html_report.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel campaign report`: what a campaign came to, or has come to until now, for people and other
// programs.
struct CampaignReportArguments {
  std::string of;   // a campaign's file or name, or a result file
  std::string out;  // folder of the results, where they are not in results/campaigns/NAME
  bool quiet = false;
};

// Under `kestrel campaign`.
CLI::App* AddCampaignReportCommand(CLI::App& campaign, CampaignReportArguments& arguments);

// False: a threshold is not kept. Writes report.html, runs.csv and summary.json beside the results and prints
// the summary. Throws InputError: there are no results; std::runtime_error: a file cannot be written, or what
// the page needs is missing.
bool CampaignReportCommand(const CampaignReportArguments& arguments);

// What a page tells of a result file. campaign: its file or name, as the commands on the page have it; empty:
// by the name that the results are of.
campaign::ReportSubject SubjectOf(const std::filesystem::path& results, const std::string& campaign = {});

}  // namespace kestrel::app
