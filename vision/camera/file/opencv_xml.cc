// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/opencv_xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <string_view>

namespace kestrel::vision {
namespace {

using Kind = ConfigNode::Kind;

// OpenCV's parser goes down with the elements, one call each.
constexpr int kMaxDepth = 32;

bool IsShallow(std::string_view text) {
  int depth = 0;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text[i] != '<' || text[i + 1] == '?' || text[i + 1] == '!') continue;
    depth += text[i + 1] == '/' ? -1 : 1;
    if (depth > kMaxDepth) return false;
  }
  return true;
}

Place PlaceOfKey(const std::string& text, const std::string& key, const Place& otherwise) {
  for (std::size_t at = text.find('<' + key); at != std::string::npos; at = text.find('<' + key, at + 1)) {
    const std::size_t end = at + 1 + key.size();
    if (end < text.size() && (text[end] == '>' || text[end] == ' '))
      return {otherwise.file, 1 + static_cast<int>(std::count(
                                      text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'))};
  }
  return otherwise;
}

ConfigNode NodeOf(const cv::FileNode& from, const std::string& text, const Place& where, bool top) {
  ConfigNode node;
  node.where = where;
  if (from.isInt() || from.isReal() || from.isString()) {
    node.kind = Kind::kText;
    node.text = from.isInt()    ? fmt::format("{}", static_cast<int>(from))
                : from.isReal() ? fmt::format("{}", static_cast<double>(from))
                                : static_cast<std::string>(from);
    node.quoted = from.isString();
  } else if (from.isSeq() || from.isMap()) {
    node.kind = from.isSeq() ? Kind::kList : Kind::kMap;
    for (const cv::FileNode& member : from) {
      const std::string key = from.isMap() ? member.name() : std::to_string(node.members.size());
      node.members.push_back({key, NodeOf(member, text, top ? PlaceOfKey(text, key, where) : where, false)});
    }
  }
  return node;
}

}  // namespace

bool IsXml(std::string_view text) { return text.starts_with("<?xml") || text.starts_with("<opencv_storage"); }

Config ParseOpenCvXml(const std::string& text, const std::string& name, Mistakes& mistakes) {
  Config config;
  const auto none = [&] {
    mistakes.Add(Place(name), "", "is XML, but not as OpenCV's FileStorage writes it",
                 "valid: a calibration in XML or YAML by OpenCV");
    return Config{};
  };
  if (text.find("<opencv_storage") == std::string::npos || !IsShallow(text)) return none();
  try {
    const cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (!file.isOpened()) return none();
    config.root = NodeOf(file.root(), text, Place(name, 1), true);
    config.readable = config.root.kind == Kind::kMap;
  } catch (const cv::Exception&) {
    return none();
  }
  return config.readable ? config : none();
}

}  // namespace kestrel::vision
