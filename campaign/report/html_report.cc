// SPDX-License-Identifier: Apache-2.0
#include "campaign/report/html_report.h"

#include <map>
#include <string_view>

#include "base/html/html.h"
#include "campaign/report/page_data.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;

std::string Own(const char* name) { return PageFile(fs::path("campaign/report/page") / name); }

}  // namespace

std::string HtmlReport(const ReportSubject& subject, const fs::path& page_folder) {
  const fs::path own = "campaign/report/page";
  std::map<std::string_view, std::string> parts;
  parts["title"] = Escaped(subject.identity.name + " – Kestrel");
  parts["style"] = PageFile("base/html/web/page.css") + Own("report.css");
  parts["data"] = PageData(subject, page_folder);
  parts["chart"] = LibraryFile(ChartLibrary());
  parts["mit"] = PageFile("base/html/web/mit.txt");
  // In the order in which they need each other.
  parts["script"] =
      PageScript({"base/html/web/numbers.js", own / "data.js", "base/html/web/dom.js",
                  "base/html/web/theme.js", own / "marks.js", own / "charts.js", own / "success.js",
                  own / "distributions.js", own / "scatter.js", own / "effects.js", own / "places.js",
                  own / "run_panel.js", own / "runs_table.js", own / "tuning.js", own / "main.js"});
  return Filled(Own("report.html"), parts);
}

}  // namespace kestrel::campaign
