// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace kestrel::sim {

// A file of parameters as the autopilots' own readers take it; what they would not take is thrown.
//
// ArduPilot (AP_Param::parse_param_line): lines by fgets into 99 characters; # at the start is a comment; then a name of
// up to 16 characters and a number, between spaces, commas or tabs. MAVProxy wants no third word.
inline std::map<std::string, double> ReadArduPilotParameters(const std::string& text) {
  std::map<std::string, double> read;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() > 97) throw std::runtime_error("too long: " + line);
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    std::string name, rest;
    double value = 0;
    if (!(words >> name >> value) || words >> rest || name.size() > 16)
      throw std::runtime_error("not read: " + line);
    if (!read.emplace(name, value).second) throw std::runtime_error("twice: " + name);
  }
  return read;
}

// QGroundControl (ParameterManager::readParametersFromStream): five words between tabs; 6 is an integer, 9 a float.
inline std::map<std::string, double> ReadPx4Parameters(const std::string& text) {
  std::map<std::string, double> read;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::vector<std::string> words;
    std::istringstream in(line);
    for (std::string word; std::getline(in, word, '\t');) words.push_back(word);
    if (words.size() != 5 || words[0] != "1" || words[1] != "1" || words[2].size() > 16)
      throw std::runtime_error("not read: " + line);
    const bool integer = words[3].find_first_of(".e") == std::string::npos;
    if (words[4] != "9" && (words[4] != "6" || !integer))
      throw std::runtime_error("of another type: " + line);
    if (!read.emplace(words[2], std::stod(words[3])).second) throw std::runtime_error("twice: " + words[2]);
  }
  return read;
}

}  // namespace kestrel::sim
