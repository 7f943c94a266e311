// SPDX-License-Identifier: Apache-2.0
#include "campaign/report/html_report.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string_view>

#include "base/file/model_files.h"
#include "campaign/report/page_data.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;

// In the order in which they need each other.
constexpr const char* kScripts[] = {"data.js",          "dom.js",        "charts.js",  "success.js",
                                    "distributions.js", "scatter.js",    "effects.js", "places.js",
                                    "run_panel.js",     "runs_table.js", "tuning.js",  "main.js"};
constexpr const char* kChart = "/usr/share/javascript/chart.js/chart.min.js";

std::string ContentOf(const fs::path& file, std::string_view remedy) {
  std::ifstream stream(file, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(stream), {}};
  if (!stream || content.empty())
    throw std::runtime_error(
        fmt::format("the report needs {}, which cannot be read; {}", file.string(), remedy));
  return content;
}

std::string PageFile(const char* name) {
  return ContentOf(DataFile(fs::path("campaign/report/page") / name),
                   "KESTREL_ROOT names the folder that holds it");
}

std::string Chart() {
  const std::string chart =
      ContentOf(kChart, "install Debian's package libjs-chart.js (apt-get install libjs-chart.js)");
  if (!chart.starts_with("/*!\n * Chart.js v3.") ||
      chart.find("Released under the MIT License") == std::string::npos)
    throw std::runtime_error(
        fmt::format("the report needs version 3 of Chart.js, with its licence; {} is another", kChart));
  return chart;
}

std::string Escaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      default:
        html += c;
    }
  }
  return html;
}

// Each {{name}} of the template by what has that name; what comes in is not looked through again.
std::string Filled(std::string_view page, const std::map<std::string_view, std::string>& parts) {
  std::string filled;
  for (;;) {
    const std::size_t begin = page.find("{{"), end = page.find("}}", begin);
    if (begin == std::string_view::npos || end == std::string_view::npos) return filled.append(page);
    filled.append(page.substr(0, begin)).append(parts.at(page.substr(begin + 2, end - begin - 2)));
    page.remove_prefix(end + 2);
  }
}

}  // namespace

std::string HtmlReport(const ReportSubject& subject, const fs::path& page_folder) {
  std::string script = "\"use strict\";\n";
  for (const char* name : kScripts) script += PageFile(name);
  std::map<std::string_view, std::string> parts;
  parts["title"] = Escaped(subject.identity.name + " – Kestrel");
  parts["style"] = PageFile("report.css");
  parts["data"] = PageData(subject, page_folder);
  parts["chart"] = Chart();
  parts["script"] = std::move(script);
  return Filled(PageFile("report.html"), parts);
}

}  // namespace kestrel::campaign
