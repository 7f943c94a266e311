// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

// What pages of HTML share that hold all they show: they work from a file, without a network.
namespace kestrel {

// Text as HTML has it, in an element or in a quoted attribute.
std::string Escaped(std::string_view text);

// JSON, or any text in whose strings \u003c means "<", as it may stand within a script element: "<!--" and
// "</script" would end or hide what follows.
std::string InScript(std::string_view json);

// Base64 (RFC 4648), in one line.
std::string Base64(std::string_view bytes);

// Each {{name}} of the template by what has that name; what comes in is not looked through again. A name that
// is not among the parts is std::out_of_range.
std::string Filled(std::string_view page, const std::map<std::string_view, std::string>& parts);

// A file of a page: of the program's own data, by its path below ("base/html/web/dom.js"). Throws
// std::runtime_error: it cannot be read.
std::string PageFile(const std::filesystem::path& path);
// Such files of a folder, one behind the other, as one strict script: in the order in which they need each other.
std::string PageScript(const std::vector<std::filesystem::path>& paths);

// A library of others that is put into a page: a file of a package of Debian's.
struct PageLibrary {
  std::filesystem::path file;
  std::string package;
  std::vector<std::string> says;  // words of the file: its version, and its licence where it names it
};

// Throws std::runtime_error: it is not there, or does not say so; with the remedy. What licence it is under must
// be told by the page.
std::string LibraryFile(const PageLibrary& library);

// Chart.js 3, of libjs-chart.js (MIT).
PageLibrary ChartLibrary();

}  // namespace kestrel
