// SPDX-License-Identifier: Apache-2.0
#include "records/junit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <sstream>

namespace kestrel::records {
namespace {

struct Counts {
  int tests = 0, failures = 0, errors = 0;
  double wall_s = 0;

  void Add(const JunitCase& test) {
    ++tests;
    failures += !test.failure.empty(), errors += !test.error.empty();
    wall_s += test.wall_s;
  }
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

void AddCase(pugi::xml_node suite, const JunitCase& each) {
  pugi::xml_node test = suite.append_child("testcase");
  test.append_attribute("classname") = Printable(each.classname).c_str();
  test.append_attribute("name") = Printable(each.name).c_str();
  test.append_attribute("time") = fmt::format("{:.3f}", each.wall_s).c_str();
  const auto report = [&](const char* kind, const std::string& message) {
    if (!message.empty()) test.append_child(kind).append_attribute("message") = Printable(message).c_str();
  };
  report("failure", each.failure);
  report("error", each.error);
}

void AddRun(const Summary& run, std::vector<JunitCase>& cases) {
  const bool all_passed =
      std::all_of(run.criteria.begin(), run.criteria.end(), [](const Criterion& c) { return c.passed; });
  const bool flight = !run.complete || run.criteria.empty() || (!run.passed && all_passed);
  // The cases of a suite should add up to its time.
  const double share_s = run.wall_s / static_cast<double>(run.criteria.size() + flight);
  const auto add = [&](const std::string& name) -> JunitCase& {
    return cases.emplace_back(
        JunitCase{run.scenario, fmt::format("{}.seed_{}", run.scenario, run.seed), name, share_s, {}, {}});
  };
  if (flight) {
    JunitCase& test = add("flight");
    if (!run.complete)
      test.error = "the run broke off: " + run.error;
    else if (!run.passed)
      test.failure = "the flight ended with: " + run.outcome;
  }
  for (const Criterion& c : run.criteria) {
    JunitCase& test = add(c.name);
    if (!c.passed)
      test.failure = fmt::format("{} {}; it must be at {} {:g}", c.name,
                                 std::isnan(c.value) ? "was not reached" : fmt::format("is {:g}", c.value),
                                 c.at_least ? "least" : "most", c.limit);
  }
}

}  // namespace

std::string JunitXml(const std::vector<JunitCase>& cases) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node root = document.append_child("testsuites");
  root.append_attribute("name") = "kestrel";

  std::vector<std::string> suites;
  for (const JunitCase& test : cases)
    if (std::find(suites.begin(), suites.end(), test.suite) == suites.end()) suites.push_back(test.suite);
  Counts all;
  for (const std::string& name : suites) {
    pugi::xml_node suite = root.append_child("testsuite");
    suite.append_attribute("name") = Printable(name).c_str();
    Counts counts;
    for (const JunitCase& test : cases) {
      if (test.suite != name) continue;
      AddCase(suite, test);
      counts.Add(test), all.Add(test);
    }
    Number(suite, counts);
  }
  Number(root, all);
  std::ostringstream text;
  document.save(text, "  ");
  return text.str();
}

std::string ToJunit(const std::vector<Summary>& runs) {
  std::vector<JunitCase> cases;
  for (const Summary& run : runs) AddRun(run, cases);
  return JunitXml(cases);
}

}  // namespace kestrel::records
