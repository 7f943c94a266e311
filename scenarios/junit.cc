// SPDX-License-Identifier: Apache-2.0
#include "scenarios/junit.h"

#include <fmt/format.h>

#include <algorithm>
#include <pugixml.hpp>
#include <sstream>

namespace kestrel {
namespace {

struct Counts {
  int tests = 0, failures = 0, errors = 0;
  double wall_s = 0;
};

// XML 1.0 cannot hold most control characters, not even escaped.
std::string Printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 && c != '\n' && c != '\t'; }, '?');
  return text;
}

void Number(pugi::xml_node node, const Counts& counts) {
  node.append_attribute("tests") = counts.tests;
  node.append_attribute("failures") = counts.failures;
  node.append_attribute("errors") = counts.errors;
  node.append_attribute("time") = fmt::format("{:.3f}", counts.wall_s).c_str();
}

pugi::xml_node AddCase(pugi::xml_node suite, const Summary& run, const std::string& name, double wall_s) {
  pugi::xml_node test = suite.append_child("testcase");
  test.append_attribute("classname") = Printable(fmt::format("{}.seed_{}", run.scenario, run.seed)).c_str();
  test.append_attribute("name") = Printable(name).c_str();
  test.append_attribute("time") = fmt::format("{:.3f}", wall_s).c_str();
  return test;
}

void Report(pugi::xml_node test, const char* kind, const std::string& message) {
  test.append_child(kind).append_attribute("message") = Printable(message).c_str();
}

Counts AddRun(pugi::xml_node suite, const Summary& run) {
  Counts counts{0, 0, 0, run.wall_s};
  const bool all_passed =
      std::all_of(run.criteria.begin(), run.criteria.end(), [](const Criterion& c) { return c.passed; });
  const bool flight = !run.complete || run.criteria.empty() || (!run.passed && all_passed);
  counts.tests = static_cast<int>(run.criteria.size()) + flight;
  const double share_s = run.wall_s / counts.tests;  // the cases of a suite should add up to its time
  if (flight) {
    const pugi::xml_node test = AddCase(suite, run, "flight", share_s);
    if (!run.complete) {
      ++counts.errors;
      Report(test, "error", "the run broke off: " + run.error);
    } else if (!run.passed) {
      ++counts.failures;
      Report(test, "failure", "the flight ended with: " + run.outcome);
    }
  }
  for (const Criterion& c : run.criteria) {
    const pugi::xml_node test = AddCase(suite, run, c.name, share_s);
    if (c.passed) continue;
    ++counts.failures;
    Report(test, "failure",
           fmt::format("{} is {:g}; it must be at {} {:g}", c.name, c.value, c.at_least ? "least" : "most",
                       c.limit));
  }
  return counts;
}

}  // namespace

std::string ToJunit(const std::vector<Summary>& runs) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node root = document.append_child("testsuites");
  root.append_attribute("name") = "kestrel";

  std::vector<std::string> scenarios;
  for (const Summary& run : runs) {
    if (std::find(scenarios.begin(), scenarios.end(), run.scenario) == scenarios.end()) {
      scenarios.push_back(run.scenario);
    }
  }
  Counts all;
  const auto add = [](Counts& sum, const Counts& more) {
    sum.tests += more.tests, sum.failures += more.failures, sum.errors += more.errors,
        sum.wall_s += more.wall_s;
  };
  for (const std::string& scenario : scenarios) {
    pugi::xml_node suite = root.append_child("testsuite");
    suite.append_attribute("name") = Printable(scenario).c_str();
    Counts counts;
    for (const Summary& run : runs) {
      if (run.scenario == scenario) add(counts, AddRun(suite, run));
    }
    Number(suite, counts);
    add(all, counts);
  }
  Number(root, all);
  std::ostringstream text;
  document.save(text, "  ");
  return text.str();
}

}  // namespace kestrel
