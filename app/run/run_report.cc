// SPDX-License-Identifier: Apache-2.0
#include "app/run/run_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/option/colour.h"
#include "base/printable.h"

namespace kestrel::app {
namespace {

std::ptrdiff_t CountMissed(const records::Summary& s) {
  return std::count_if(s.criteria.begin(), s.criteria.end(),
                       [](const records::Criterion& c) { return !c.passed; });
}

bool EndedBeforeItsPurpose(const records::Summary& s) {
  return s.complete && !s.passed && CountMissed(s) == 0;
}

std::string Line(const records::Criterion& c, bool colours) {
  // What did not happen has no value: an error at touch-down of a flight that never touched down.
  const std::string value = std::isnan(c.value) ? "not reached" : fmt::format("{:.4g}", c.value);
  return fmt::format("  {} {:<26} {:>11}   {} {:g}\n",
                     c.passed ? Green("ok  ", colours) : Red("NOT ", colours), c.name, value,
                     c.at_least ? "at least" : "at most", c.limit);
}

// A mosaic whose images are chained alone, as the thesis has it, stands beside the one that is judged.
std::string ComparedLines(const records::Summary& s) {
  std::string text;
  for (const auto& [name, value] : s.metrics)
    if (name.starts_with("chain_"))
      text += fmt::format("       {:<26} {:>11.4g}   to compare\n", name, value);
  return text;
}

}  // namespace

std::string Verdict(const records::Summary& s, bool colours) {
  const std::string run = fmt::format("{}, seed {}: ", s.scenario, s.seed);
  if (!s.complete) return fmt::format("{}{}: {}\n", run, Red("BROKE OFF", colours), Printable(s.error));
  if (s.passed)
    return fmt::format("{}{}{} ({})\n", run, Green("PASSED", colours),
                       s.criteria.empty() ? ", no criteria to judge by" : "", s.outcome);
  if (EndedBeforeItsPurpose(s))
    return fmt::format("{}{}: the flight ended before what it is for was done ({})\n", run,
                       Red("FAILED", colours), s.outcome);
  return fmt::format("{}{}: {} of {} criteria not met ({})\n", run, Red("FAILED", colours), CountMissed(s),
                     s.criteria.size(), s.outcome);
}

std::string CriteriaLines(const records::Summary& s, bool colours) {
  std::string text;
  for (const records::Criterion& c : s.criteria) text += Line(c, colours);
  return text;
}

std::string MissedCriteria(const records::Summary& s, bool colours) {
  std::string text;
  for (const records::Criterion& c : s.criteria)
    if (!c.passed) text += Line(c, colours);
  return text;
}

std::string RunReport(const records::Summary& s, const std::string& report, bool colours) {
  std::string text = Verdict(s, colours) + CriteriaLines(s, colours) + ComparedLines(s);
  text += fmt::format("  {:.1f} s flown in {:.1f} s, {:.1f} x real time, drawn by {}\n  {}\n", s.sim_s,
                      s.wall_s, s.sim_s / std::max(s.wall_s, 1e-9), s.renderer, report);
  return text;
}

}  // namespace kestrel::app
