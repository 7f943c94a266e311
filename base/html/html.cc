// SPDX-License-Identifier: Apache-2.0
#include "base/html/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "base/file/data_folders.h"

namespace kestrel {
namespace {

std::string ContentOf(const std::filesystem::path& file, std::string_view remedy) {
  std::ifstream stream(file, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(stream), {}};
  if (!stream || content.empty())
    throw std::runtime_error(
        fmt::format("the report needs {}, which cannot be read; {}", file.string(), remedy));
  return content;
}

}  // namespace

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
      case '"':
        html += "&quot;";
        break;
      default:
        html += c;
    }
  }
  return html;
}

std::string InScript(std::string_view json) {
  std::string text;
  text.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return text;
}

std::string Base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text((bytes.size() + 2) / 3 * 4, '=');
  char* out = text.data();
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (k < n ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k <= n; ++k) out[k] = kDigits[three >> (18 - 6 * k) & 63];
    out += 4;
  }
  return text;
}

std::string Filled(std::string_view page, const std::map<std::string_view, std::string>& parts) {
  std::string filled;
  for (;;) {
    const std::size_t begin = page.find("{{"), end = page.find("}}", begin);
    if (begin == std::string_view::npos || end == std::string_view::npos) return filled.append(page);
    filled.append(page.substr(0, begin)).append(parts.at(page.substr(begin + 2, end - begin - 2)));
    page.remove_prefix(end + 2);
  }
}

std::string PageFile(const std::filesystem::path& path) {
  return ContentOf(DataFile(path), "KESTREL_ROOT names the folder that holds it");
}

std::string PageScript(const std::vector<std::filesystem::path>& paths) {
  std::string script = "\"use strict\";\n";
  for (const std::filesystem::path& path : paths) script += PageFile(path);
  return script;
}

std::string LibraryFile(const PageLibrary& library) {
  const std::string content = ContentOf(
      library.file, fmt::format("install Debian's package {0} (apt-get install {0})", library.package));
  for (const std::string& words : library.says)
    if (content.find(words) == std::string::npos)
      throw std::runtime_error(
          fmt::format("the report needs the {} of Debian's package {} that says '{}'; {} "
                      "is another",
                      library.file.filename().string(), library.package, words, library.file.string()));
  return content;
}

PageLibrary ChartLibrary() {
  return {"/usr/share/javascript/chart.js/chart.min.js",
          "libjs-chart.js",
          {"/*!\n * Chart.js v3.", "Released under the MIT License"}};
}

}  // namespace kestrel
