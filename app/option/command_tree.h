// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

// What a program's verbs and options say of themselves: for what refuses others, for completion scripts, the man page
// and the reference.
namespace kestrel::app {

// Those that help shows.
std::vector<const CLI::App*> VerbsOf(const CLI::App& command);
std::vector<const CLI::Option*> OptionsOf(const CLI::App& command);      // with dashes
std::vector<const CLI::Option*> PositionalsOf(const CLI::App& command);  // without

// "kestrel campaign replay"
std::string PathOf(const CLI::App& command);

// A command and all below it, each before those that are below it.
std::vector<const CLI::App*> AllOf(const CLI::App& command);

// "kestrel run [OPTIONS] scenario"
std::string UsageOf(const CLI::App& command);

// "--set KEY=VALUE", "--jobs INT", "--quiet"
std::string TermOf(const CLI::Option& option);

// Its description, with what would be valid and the default, where they are known.
std::string ExplanationOf(const CLI::Option& option);

// What a value is, for completion: FILE, DIR, SCENARIO; empty: nothing is known.
std::string TypeOf(const CLI::Option& option);
// The words that a value is one of; none: it is not one of a few.
std::vector<std::string> WordsOf(const CLI::Option& option);
bool TakesValue(const CLI::Option& option);

// By which `kestrel list` names what a value of a type may be: "scenarios" of SCENARIO; empty: none.
std::string ListedKind(const std::string& type);

}  // namespace kestrel::app
