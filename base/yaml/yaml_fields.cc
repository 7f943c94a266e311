// SPDX-License-Identifier: Apache-2.0
#include "base/yaml/yaml_fields.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/exceptions.h>

#include <algorithm>
#include <boost/locale/utf.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <numeric>
#include <set>
#include <sstream>
#include <unordered_map>

#include "base/printable.h"
#include "base/user_file.h"
#include "base/yaml/yaml_nodes.h"

namespace kestrel {
namespace {

using Kind = ConfigNode::Kind;

constexpr char kDescription[] = "description";

// What is shown of many mistakes, and of a long one: nobody reads more, and a terminal chokes on it.
constexpr std::size_t kMaxShown = 50, kLongestShown = 2000;

// The number of the first line that is not UTF-8, in which alone others read what is kept of a file. 0: all
// are.
int LineNotUtf8(const std::string& text) {
  using Utf8 = boost::locale::utf::utf_traits<char>;
  int line = 1;
  for (auto at = text.begin(); at != text.end();) {
    const auto letter = Utf8::decode(at, text.end());
    if (letter == boost::locale::utf::illegal || letter == boost::locale::utf::incomplete) return line;
    line += letter == '\n';
  }
  return 0;
}

void Override(ConfigNode& root, const std::string& text, Mistakes& mistakes) {
  const std::string where = "--set " + text;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    return mistakes.Add(where, "", "not of the form key.path=value");
  ConfigNode value;
  try {
    value = ReadNodes(text.substr(equals + 1), [&](int) { return where; });
  } catch (const YAML::Exception& e) {
    return mistakes.Add(where, text.substr(0, equals), "the value is not valid YAML: " + e.msg);
  }

  ConfigNode* node = &root;
  std::istringstream path(text.substr(0, equals));
  std::string walked;
  for (std::string key; std::getline(path, key, '.');) {
    if (node->kind == Kind::kText)
      return mistakes.Add(where, walked, "is a single value: it has no keys below it");
    walked += (walked.empty() ? "" : ".") + key;
    // The last of equal keys is the one that a repeated override means; in a file they are refused anyway.
    const auto found = std::find_if(node->members.rbegin(), node->members.rend(),
                                    [&](const auto& member) { return member.first == key; });
    if (found != node->members.rend()) {
      node = &found->second;
    } else if (node->kind == Kind::kList) {
      return mistakes.Add(where, walked,
                          fmt::format("the list has {} elements, counted from 0", node->members.size()));
    } else {
      node->kind = Kind::kMap;
      node = &node->members.emplace_back(key, ConfigNode{Kind::kNothing, "", false, where, {}}).second;
    }
  }
  *node = std::move(value);
}

// On standard error, whatever reads the file how often.
void NoticeOnce(const std::string& notice) {
  static std::mutex mutex;
  static std::set<std::string> told;
  const std::lock_guard lock(mutex);
  if (told.insert(notice).second) std::fputs(("kestrel: " + Printable(notice) + "\n").c_str(), stderr);
}

std::string Shown(const ConfigNode& node) {
  switch (node.kind) {
    case Kind::kNothing:
      return "nothing";
    case Kind::kText:
      return node.text.size() <= 200 ? '\'' + node.text + '\'' : '\'' + node.text.substr(0, 100) + "'...";
    case Kind::kList:
      return fmt::format("a list of {}", node.members.size());
    case Kind::kMap:
      return "a map";
  }
  return "";
}

void TakeDescription(Config& config, Mistakes& mistakes) {
  constexpr std::size_t kLongest = 200;
  std::vector<std::pair<std::string, ConfigNode>>& members = config.root.members;
  if (config.root.kind != Kind::kMap) return;
  const auto found = std::find_if(members.begin(), members.end(),
                                  [](const auto& member) { return member.first == kDescription; });
  if (found == members.end()) return;
  const ConfigNode& node = found->second;
  if (node.kind != Kind::kText || node.text.empty() || node.text.size() > kLongest || HasControl(node.text))
    mistakes.Add(node.where, kDescription,
                 fmt::format("{} is not valid; valid: a sentence of up to {} bytes in one line", Shown(node),
                             kLongest));
  else
    config.description = node.text;
  members.erase(found);
}

enum class Parsed { kNumber, kNotFinite, kNotANumber };

Parsed ParseNumber(const ConfigNode& node, double& value) {
  if (node.kind != Kind::kText || node.quoted) return Parsed::kNotANumber;
  std::string_view text = node.text;
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  std::string_view magnitude = text;
  if (!magnitude.empty() && magnitude[0] == '-') magnitude.remove_prefix(1);
  std::string lower(magnitude);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  if (lower == ".inf" || lower == "inf" || lower == ".nan" || lower == "nan") return Parsed::kNotFinite;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::result_out_of_range) return Parsed::kNotFinite;
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && std::isfinite(value) ? Parsed::kNumber : Parsed::kNotANumber;
}

std::string QuotedIfNeeded(const std::string& text) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) || std::strchr("_./-", c); };
  static const std::vector<std::string> kSpecial = {"true", "false", "null", "yes", "no", "on", "off"};
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  if (!text.empty() && (std::isalpha(static_cast<unsigned char>(text[0])) || text[0] == '_') &&
      text.find('\0') == std::string::npos && std::all_of(text.begin(), text.end(), plain) &&
      std::find(kSpecial.begin(), kSpecial.end(), lower) == kSpecial.end()) {
    return text;
  }
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      quoted += {'\\', c};
    else if (byte < 0x20 || byte == 0x7f)
      quoted += fmt::format("\\x{:02x}", byte);
    else
      quoted += c;
  }
  return quoted + '"';
}

// The beginning and the end, between which the middle is left out: a place stands first, and what would be
// valid last.
std::string Shortened(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  return fmt::format("{} [...] {}", std::string_view(text).substr(0, most / 2),
                     std::string_view(text).substr(text.size() - most / 2));
}

std::string ShownOf(const std::vector<std::string>& all) {
  std::string shown;
  for (std::size_t i = 0; i < std::min(all.size(), kMaxShown); ++i) {
    if (i > 0) shown += '\n';
    shown += Shortened(all[i], kLongestShown);
  }
  if (all.size() > kMaxShown) shown += fmt::format("\nand {} more", all.size() - kMaxShown);
  return shown;
}

}  // namespace

InputError::InputError(std::vector<std::string> all)
    : std::runtime_error(Printable(ShownOf(all))), messages(std::move(all)) {}

void Mistakes::Add(std::string_view where, std::string_view key, std::string_view what) {
  messages_.push_back(key.empty() ? fmt::format("{}: {}", where, what)
                                  : fmt::format("{}: {}: {}", where, key, what));
}

void Mistakes::ThrowIfAny() const {
  if (!messages_.empty()) throw InputError(messages_);
}

Config LoadConfig(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                  Mistakes& mistakes) {
  const FileContent content = ReadUserFile(file, kMaxTextBytes);
  if (!content.trouble.empty()) {
    mistakes.Add(file.string(), "", content.trouble);
    return {};
  }
  return ParseConfig(content.bytes, file.string(), overrides, mistakes);
}

Config ParseConfig(const std::string& text, const std::string& name,
                   const std::vector<std::string>& overrides, Mistakes& mistakes) {
  Config config;
  const auto where_of = [&](int line) { return fmt::format("{}:{}", name, line + 1); };
  if (const int line = LineNotUtf8(text); line > 0) {
    mistakes.Add(fmt::format("{}:{}", name, line), "", "it is not in UTF-8; valid: the file saved in UTF-8");
    return config;
  }
  try {
    config.root = ReadNodes(text, where_of);
    config.readable = true;
    TakeDescription(config, mistakes);
  } catch (const YAML::Exception& e) {
    mistakes.Add(where_of(e.mark.line), "", "not valid YAML: " + e.msg);
    return config;
  }
  for (const std::string& each : overrides) Override(config.root, each, mistakes);
  return config;
}

std::optional<std::string> NearestName(std::string_view name, const std::vector<std::string>& valid) {
  const auto distance = [](std::string_view a, std::string_view b) {  // Levenshtein
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), 0u);
    for (std::size_t i = 0; i < a.size(); ++i) {
      std::size_t diagonal = row[0]++;
      for (std::size_t j = 0; j < b.size(); ++j) {
        const std::size_t changed = diagonal + (a[i] != b[j]);
        diagonal = row[j + 1];
        row[j + 1] = std::min({changed, row[j] + 1, diagonal + 1});
      }
    }
    return row.back();
  };
  std::optional<std::string> nearest;
  // Beyond a third of the letters it would be a guess.
  std::size_t least = (name.size() < 4 ? 1 : std::max<std::size_t>(2, name.size() / 3)) + 1;
  for (const std::string& each : valid) {
    if (name.size() >= each.size() + least || each.size() >= name.size() + least) continue;
    if (const std::size_t d = distance(name, each); d < least) least = d, nearest = each;
  }
  return nearest;
}

FieldReader::FieldReader(const ConfigNode& node, std::string path, Mistakes& mistakes)
    : node_(node), path_(std::move(path)), mistakes_(mistakes) {
  RefuseRepeated(node_, path_);
}

const ConfigNode* FieldReader::Find(FieldKey key) {
  keys_.push_back(key.name);
  const auto last = [this](std::string_view name) -> const ConfigNode* {
    for (auto it = node_.members.rbegin(); it != node_.members.rend(); ++it)
      if (it->first == name) return &it->second;
    return nullptr;
  };
  if (node_.kind == Kind::kMap) {
    const ConfigNode* now = last(key.name);
    const ConfigNode* before = key.former ? last(key.former) : nullptr;
    if (before) {
      former_keys_.push_back(key.former);
      if (now)
        Wrong(*before, key.former, fmt::format("is the former name of '{}', which is given too", key.name));
      else
        NoticeOnce(fmt::format("{}: {}: is called '{}' now", before->where, Path(key.former), key.name));
    }
    if (now || before) return now ? now : before;
  }
  if (key.required && (node_.kind == Kind::kMap || node_.kind == Kind::kNothing)) {
    mistakes_.Add(node_.where, Path(key.name), "must be given");
  }
  return nullptr;
}

ConfigNode FieldReader::Nothing() const { return {Kind::kNothing, "", false, node_.where, {}}; }

std::string FieldReader::Path(std::string_view key) const {
  return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

bool FieldReader::Holds(const ConfigNode& node, Kind kind, FieldKey key) const {
  if (node.kind == kind || node.kind == Kind::kNothing) return true;
  Wrong(node, key.name, fmt::format("{} is not a {}", Shown(node), kind == Kind::kList ? "list" : "map"));
  return false;
}

void FieldReader::Wrong(const ConfigNode& node, std::string_view key, std::string_view what) const {
  mistakes_.Add(node.where, Path(key), what);
}

bool FieldReader::Number(const ConfigNode& node, std::string_view key, double low, double high,
                         double& value) const {
  double number = 0;
  switch (ParseNumber(node, number)) {
    case Parsed::kNotANumber:
      Wrong(node, key, fmt::format("{} is not a number; valid: {} to {}", Shown(node), low, high));
      return false;
    case Parsed::kNotFinite:
      Wrong(node, key, fmt::format("{} is not a finite number; valid: {} to {}", node.text, low, high));
      return false;
    case Parsed::kNumber:
      break;
  }
  if (!(number >= low && number <= high)) {
    Wrong(node, key, fmt::format("{} is out of range; valid: {} to {}", node.text, low, high));
    return false;
  }
  value = number;
  return true;
}

void FieldReader::operator()(FieldKey key, double& value, double low, double high) {
  if (const ConfigNode* node = Find(key)) Number(*node, key.name, low, high, value);
}

void FieldReader::operator()(FieldKey key, std::optional<double>& value, double low, double high) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  if (node->kind == Kind::kNothing) return value.reset();
  double number = 0;
  if (Number(*node, key.name, low, high, number)) value = number;
}

void FieldReader::operator()(FieldKey key, int& value, int low, int high) {
  const ConfigNode* node = Find(key);
  double number = 0;
  if (!node || !Number(*node, key.name, low, high, number)) return;
  if (number != std::floor(number)) {
    return Wrong(*node, key.name,
                 fmt::format("{} is not a whole number; valid: {} to {}", node->text, low, high));
  }
  value = static_cast<int>(number);
}

void FieldReader::operator()(FieldKey key, std::uint64_t& value) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  std::uint64_t number = 0;
  const char* last = node->text.data() + node->text.size();
  const auto [end, error] = std::from_chars(node->text.data(), last, number);
  if (node->kind != Kind::kText || node->quoted || error != std::errc() || end != last) {
    return Wrong(*node, key.name,
                 fmt::format("{} is not valid; valid: a whole number, 0 to {}", Shown(*node), UINT64_MAX));
  }
  value = number;
}

void FieldReader::operator()(FieldKey key, bool& value) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  if (node->kind != Kind::kText || node->quoted || (node->text != "true" && node->text != "false")) {
    return Wrong(*node, key.name, fmt::format("{} is not valid; valid: true, false", Shown(*node)));
  }
  value = node->text == "true";
}

void FieldReader::operator()(FieldKey key, std::string& value) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  if (node->kind != Kind::kText) return Wrong(*node, key.name, fmt::format("{} is not a text", Shown(*node)));
  value = node->text;
}

void FieldReader::operator()(FieldKey key, std::string& value, std::initializer_list<const char*> valid) {
  (*this)(key, value, std::vector<std::string>(valid.begin(), valid.end()));
}

void FieldReader::operator()(FieldKey key, std::string& value, const std::vector<std::string>& valid) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  if (node->kind != Kind::kText || std::find(valid.begin(), valid.end(), node->text) == valid.end()) {
    const auto nearest = NearestName(node->text, valid);
    return Wrong(
        *node, key.name,
        fmt::format("{} is not valid;{} valid: {}", Shown(*node),
                    nearest ? fmt::format(" did you mean '{}'?", *nearest) : "", fmt::join(valid, ", ")));
  }
  value = node->text;
}

void FieldReader::operator()(FieldKey key, std::vector<std::string>& value) {
  const ConfigNode* node = Find(key);
  if (!node || !Holds(*node, ConfigNode::Kind::kList, key)) return;
  value.clear();
  for (const auto& [index, member] : node->members) {
    if (member.kind == Kind::kText)
      value.push_back(member.text);
    else
      Wrong(member, fmt::format("{}.{}", key.name, index), fmt::format("{} is not a text", Shown(member)));
  }
}

void FieldReader::operator()(FieldKey key, ConfigNode& value) {
  if (const ConfigNode* node = Find(key)) value = *node;
}

void FieldReader::Numbers(FieldKey key, double* values, int size, double low, double high) {
  const ConfigNode* node = Find(key);
  if (!node) return;
  const auto is_element = [&](const auto& member) {
    for (int i = 0; i < size; ++i)
      if (member.first == std::to_string(i)) return true;
    return false;
  };
  const bool some = node->kind == Kind::kMap && !node->members.empty() &&
                    std::all_of(node->members.begin(), node->members.end(), is_element);
  if (!some && (node->kind != Kind::kList || node->members.size() != static_cast<std::size_t>(size))) {
    return Wrong(*node, key.name,
                 fmt::format("{} is not valid; valid: a list of {} numbers, each {} to {}", Shown(*node),
                             size, low, high));
  }
  std::vector<double> read(values, values + size);
  bool all = true;
  for (const auto& [index, member] : node->members) {
    all &= Number(member, fmt::format("{}.{}", key.name, index), low, high, read[std::stoul(index)]);
  }
  if (all) std::copy(read.begin(), read.end(), values);
}

void FieldReader::RefuseRepeated(const ConfigNode& node, const std::string& path) const {
  if (node.kind != Kind::kMap) return;
  std::unordered_map<std::string_view, const std::string*> first;
  for (const auto& [key, member] : node.members) {
    const auto [before, is_new] = first.emplace(key, &member.where);
    if (is_new) continue;
    mistakes_.Add(member.where, path.empty() ? key : path + '.' + key,
                  "given twice, first at " + *before->second);
  }
}

void FieldReader::Finish() const {
  if (node_.kind == Kind::kText || node_.kind == Kind::kList) {
    return mistakes_.Add(
        node_.where, path_,
        fmt::format("{} is not valid; valid: a map of {}", Shown(node_), fmt::join(keys_, ", ")));
  }
  for (const auto& [key, member] : node_.members) {
    if (std::find(keys_.begin(), keys_.end(), key) != keys_.end() ||
        std::find(former_keys_.begin(), former_keys_.end(), key) != former_keys_.end())
      continue;
    std::vector<std::string> valid = keys_;
    if (path_.empty()) valid.push_back(kDescription);
    const auto nearest = NearestName(key, valid);
    Wrong(member, key,
          nearest ? fmt::format("unknown key; did you mean '{}'?", *nearest)
                  : fmt::format("unknown key; valid: {}", fmt::join(keys_, ", ")));
  }
}

void FieldWriter::operator()(FieldKey key, double& value, double, double) {
  Line(key.name, fmt::format("{}", value));
}
void FieldWriter::operator()(FieldKey key, std::optional<double>& value, double, double) {
  Line(key.name, value ? fmt::format("{}", *value) : "null");
}
void FieldWriter::operator()(FieldKey key, int& value, int, int) { Line(key.name, fmt::format("{}", value)); }
void FieldWriter::operator()(FieldKey key, std::uint64_t& value) { Line(key.name, fmt::format("{}", value)); }
void FieldWriter::operator()(FieldKey key, bool& value) { Line(key.name, value ? "true" : "false"); }
void FieldWriter::operator()(FieldKey key, std::string& value) { Line(key.name, QuotedIfNeeded(value)); }

void FieldWriter::Numbers(std::string_view key, const double* values, int size) {
  Line(key, fmt::format("[{}]", fmt::join(values, values + size, ", ")));
}

void FieldWriter::Line(std::string_view key, std::string_view value) {
  text_ += fmt::format("{:{}}{}: {}\n", "", 2 * indent_, QuotedIfNeeded(std::string(key)), value);
}

void FieldWriter::Block(std::string_view key, const std::string& block, const char* empty) {
  if (block.empty()) return Line(key, empty);
  text_ += fmt::format("{:{}}{}:\n{}", "", 2 * indent_, QuotedIfNeeded(std::string(key)), block);
}

std::string FieldWriter::AsListItem(std::string block) const {
  const std::size_t dash = 2 * (indent_ + 1);
  if (block.empty()) return fmt::format("{:{}}- {{}}\n", "", dash);
  return block[dash] = '-', block;
}

}  // namespace kestrel
