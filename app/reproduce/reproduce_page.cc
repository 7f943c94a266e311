// SPDX-License-Identifier: Apache-2.0
#include "app/reproduce/reproduce_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

#include "base/file/data_folders.h"
#include "base/file/files.h"
#include "base/html/html.h"
#include "base/version.h"
#include "records/telemetry/metrics.h"

namespace kestrel::app {
namespace {

std::string PictureOf(const Shown& shown) {
  const bool png = shown.picture.extension() == ".png";
  return fmt::format(
      "<figure{3}><img loading=\"lazy\" alt=\"{0}\" "
      "src=\"data:image/{1};base64,{2}\"><figcaption>{0}</figcaption>"
      "</figure>\n",
      Escaped(shown.label), png ? "png" : "jpeg", Base64(ReadFile(shown.picture)),
      shown.wide ? " class=\"whole\"" : "");
}

std::string UnitOf(const std::string& metric) {
  for (const mission::Metric& each : records::AllMetrics())
    if (each.name == metric) return each.unit == "1" ? "" : each.unit;
  return "";
}

// A metric that is not finite is of what did not happen.
std::string Number(double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : "never"; }

std::string Table(const Thesis& thesis, const ThesisItem& item,
                  const std::map<std::string, Reproduced>& flown) {
  if (item.values.empty()) return "";
  std::string html = "<div class=\"wide\"><table><thead><tr><th></th><th></th>";
  for (const std::string& flight : item.flights)
    html +=
        fmt::format("<th colspan=\"2\" class=\"number\">{}</th>", Escaped(thesis.flights.at(flight).label));
  html += "</tr><tr><th></th><th>unit</th>";
  for (std::size_t i = 0; i < item.flights.size(); ++i)
    html += "<th class=\"number\">thesis</th><th class=\"number\">here</th>";
  html += "</tr></thead><tbody>\n";
  for (const ThesisValue& value : item.values) {
    html += fmt::format("<tr><td>{}</td><td>{}</td>", Escaped(value.what), Escaped(UnitOf(value.metric)));
    for (std::size_t i = 0; i < item.flights.size(); ++i) {
      const auto& metrics = flown.at(item.flights[i]).metrics;
      const auto found = metrics.find(value.metric);
      html +=
          fmt::format("<td class=\"number\">{}</td><td class=\"number here\">{}</td>",
                      i < value.thesis.size() && !value.thesis[i].empty() ? Escaped(value.thesis[i]) : "–",
                      found == metrics.end() ? "–" : Number(found->second));
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string Card(const Thesis& thesis, const ReproducedItem& shown,
                 const std::map<std::string, Reproduced>& flown, std::uint64_t seed) {
  const ThesisItem& item = *shown.item;
  std::string html = "<article class=\"card\">";
  for (const std::string& name : item.names) html += fmt::format("<a id=\"{}\"></a>", Escaped(name));
  html += fmt::format("<p class=\"kind\">{}</p><h3>{}</h3>\n", Escaped(item.section), Escaped(TitleOf(item)));
  if (!item.shows.empty()) html += fmt::format("<p>{}</p>\n", Escaped(item.shows));
  if (!item.thesis.empty()) html += fmt::format("<p><b>The thesis:</b> {}</p>\n", Escaped(item.thesis));
  if (!item.none.empty())
    return html + fmt::format("<p class=\"note\">{}</p></article>\n", Escaped(item.none));
  html += Table(thesis, item, flown);
  html += "<div class=\"pictures\">\n";
  for (const Shown& picture : shown.pictures) html += PictureOf(picture);
  html += "</div>\n";
  for (const std::string& missing : shown.missing)
    html += fmt::format("<p class=\"bad\">{}</p>\n", Escaped(missing));
  for (const std::string& flight : item.flights)
    if (const Reproduced& is = flown.at(flight); !is.error.empty())
      html += fmt::format("<p class=\"bad\">{}: broke off: {}</p>\n", Escaped(flight), Escaped(is.error));
  std::string commands = fmt::format("kestrel reproduce {}\n", item.names.front());
  for (const std::string& flight : item.flights)
    commands += CommandOf(thesis.flights.at(flight), seed) + '\n';
  return html + fmt::format("<pre>{}</pre></article>\n", Escaped(commands));
}

std::string ChapterOf(const ThesisItem& item) {
  const std::string number = item.names.front().substr(item.names.front().find('-') + 1);
  return std::string(1, static_cast<char>(std::toupper(static_cast<unsigned char>(number[0]))));
}

}  // namespace

std::string ReproducePage(const Thesis& thesis, const std::vector<ReproducedItem>& items,
                          const std::map<std::string, Reproduced>& flown, std::uint64_t seed) {
  std::size_t with = 0, without = 0;
  std::vector<std::string> chapters;
  for (const ReproducedItem& each : items) {
    (each.item->none.empty() ? with : without) += each.item->names.size();
    if (chapters.empty() || chapters.back() != ChapterOf(*each.item))
      chapters.push_back(ChapterOf(*each.item));
  }
  const auto heading = [](const std::string& chapter) {
    return (std::isdigit(static_cast<unsigned char>(chapter[0])) != 0 ? "Chapter " : "Appendix ") + chapter;
  };
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width\"><title>The thesis's tables and figures – "
      "Kestrel"
      "</title>\n<style>\n" +
      ReadFile(DataFile("campaign/report/page/report.css")) +
      ReadFile(DataFile("app/reproduce/reproduce.css")) + "</style></head><body>\n";
  html += fmt::format(
      "<div class=\"masthead\"><div class=\"inner\"><p class=\"kind\">Kestrel, reproduced</p><h1>The "
      "thesis's "
      "tables and figures</h1><p class=\"facts\"><span>I. F. Mondragón, On-board visual control algorithms "
      "for "
      "Unmanned Aerial Vehicles (UPM)</span><span><b>{}</b> with a counterpart</span><span><b>{}</b> without "
      "one, "
      "each with the reason</span><span>seed <b>{}</b></span><span>{}</span></p></div></div>\n<nav><div "
      "class=\"inner\">",
      with, without, seed, Escaped(Version()));
  for (const std::string& chapter : chapters)
    html += fmt::format("<a href=\"#chapter-{}\">{}</a>", chapter, heading(chapter));
  html += "</div></nav>\n<main>\n";
  std::string chapter;
  for (const ReproducedItem& each : items) {
    if (ChapterOf(*each.item) != chapter) {
      if (!chapter.empty()) html += "</section>\n";
      chapter = ChapterOf(*each.item);
      html += fmt::format("<section id=\"chapter-{}\"><h2>{}</h2>\n", chapter, heading(chapter));
    }
    html += Card(thesis, each, flown, seed);
  }
  return html + (chapter.empty() ? "" : "</section>\n") + "</main></body></html>\n";
}

}  // namespace kestrel::app
