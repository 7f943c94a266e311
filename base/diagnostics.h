// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// What is wrong with an input, as data: whoever passes it on adds to its parts and never reads its text.
namespace kestrel {

// Where something was written: a line of a file, a file as a whole, or an option as it was given.
struct Place {
  Place() = default;
  // NOLINTBEGIN(google-explicit-constructor): an option or a file is written as its name
  Place(std::string named) : file(std::move(named)) {}
  Place(const char* named) : file(named) {}
  // NOLINTEND(google-explicit-constructor)
  Place(std::string in, int at) : file(std::move(in)), line(at) {}
  bool operator==(const Place&) const = default;
  std::string Text() const;  // "path/file.yaml:12", "--set key=value"

  std::string file;
  int line = 0;  // from 1; 0: none
};

struct Diagnostic {
  std::string file;    // or an option; empty: of neither
  int line = 0;        // from 1; 0: none
  std::string key;     // dotted; may be empty
  std::string what;    // what is wrong
  std::string remedy;  // what to do about it, such as "valid: 0 to 5"; may be empty

  Place place() const { return {file, line}; }
  std::string Text() const;  // "file:line: key: what; remedy"
};

// Bad input, every mistake of it: one per line in what().
struct InputError : std::runtime_error {
  explicit InputError(std::vector<Diagnostic> all);
  InputError(const Place& where, std::string_view what, std::string_view remedy = {});
  std::vector<Diagnostic> diagnostics;
};

// Gathers the mistakes of several files and overrides before any is reported.
class Mistakes {
 public:
  // key: dotted, may be empty; remedy: as of a diagnostic.
  void Add(const Place& where, std::string_view key, std::string_view what, std::string_view remedy = {});
  void Add(Diagnostic diagnostic) { all_.push_back(std::move(diagnostic)); }
  void Add(const InputError& error);                      // all of it, as it is
  void Add(const InputError& error, const Place& where);  // all of it, as said of what was given there
  bool empty() const { return all_.empty(); }
  const std::vector<Diagnostic>& all() const { return all_; }
  std::vector<std::string> Texts() const;
  void ThrowIfAny() const;

 private:
  std::vector<Diagnostic> all_;
};

}  // namespace kestrel
