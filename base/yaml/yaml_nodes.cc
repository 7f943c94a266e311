// SPDX-License-Identifier: Apache-2.0
#include "base/yaml/yaml_nodes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "base/yaml/quoted.h"

namespace kestrel {
namespace {

using Kind = ConfigNode::Kind;

// What no file comes near that a person or a program writes.
constexpr std::size_t kMaxValues = 50'000, kMaxBytes = 16u << 20, kMaxDepth = 32;

// What a value takes, with all that is in it.
struct Extent {
  std::size_t values = 0, bytes = 0, depth = 0;
};

Extent ExtentOf(const ConfigNode& node) {
  Extent extent{1, node.text.size() + node.where.file.size(), 1};
  for (const auto& [key, member] : node.members) {
    const Extent of_member = ExtentOf(member);
    extent.values += of_member.values;
    extent.bytes += of_member.bytes + key.size();
    extent.depth = std::max(extent.depth, of_member.depth + 1);
  }
  return extent;
}

// Builds the tree from what the parser meets, value by value, and not from the parser's own tree: an alias in
// that costs nothing until it is followed, and then everything.
class TreeBuilder final : public YAML::EventHandler {
 public:
  explicit TreeBuilder(const std::function<Place(int line)>& where_of) : where_of_(where_of) {
    root_.where = where_of(0);
  }
  ConfigNode Take() { return std::move(root_); }

 private:
  struct Open {
    ConfigNode node;
    YAML::Mark mark;
    YAML::anchor_t anchor;
    std::optional<std::string> key = std::nullopt;  // of the next value, once it was read
    Place key_where = {};
  };

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ > 0) throw YAML::Exception(mark, "more than one document");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { Add(mark, Node(mark), anchor); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    ConfigNode node = Node(mark);
    node.kind = Kind::kText;
    node.text = value;
    node.quoted = tag == "!";
    Add(mark, std::move(node), anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) throw YAML::Exception(mark, "an alias within what it stands for");
    // Before it is copied.
    if (open_.size() + ExtentOf(found->second).depth > kMaxDepth) TooDeep(mark);
    Count(mark, ExtentOf(found->second));
    ConfigNode node = found->second;
    if (!open_.empty() && open_.back().key) node.where = open_.back().key_where;
    Put(mark, std::move(node));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    Start(mark, Kind::kList, anchor);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    Start(mark, Kind::kMap, anchor);
  }
  void OnSequenceEnd() override { End(); }
  void OnMapEnd() override { End(); }

  // The line of a member is that of its key.
  ConfigNode Node(const YAML::Mark& mark) const {
    ConfigNode node;
    node.where = open_.empty()      ? root_.where
                 : open_.back().key ? open_.back().key_where
                                    : where_of_(mark.line);
    return node;
  }
  void Start(const YAML::Mark& mark, Kind kind, YAML::anchor_t anchor) {
    if (open_.size() >= kMaxDepth) TooDeep(mark);
    if (IsKey()) NoName(mark);
    ConfigNode node = Node(mark);
    node.kind = kind;
    Count(mark, ExtentOf(node));
    open_.push_back({std::move(node), mark, anchor});
  }
  void End() {
    Open ended = std::move(open_.back());
    open_.pop_back();
    Keep(ended.mark, ended.node, ended.anchor);
    Put(ended.mark, std::move(ended.node));
  }
  void Add(const YAML::Mark& mark, ConfigNode node, YAML::anchor_t anchor) {
    Count(mark, ExtentOf(node));
    Keep(mark, node, anchor);
    Put(mark, std::move(node));
  }
  void Keep(const YAML::Mark& mark, const ConfigNode& node, YAML::anchor_t anchor) {
    if (anchor == YAML::NullAnchor) return;
    Count(mark, ExtentOf(node));
    anchors_[anchor] = node;
  }
  void Put(const YAML::Mark& mark, ConfigNode node) {
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& in = open_.back();
    if (in.node.kind == Kind::kList) {
      in.node.members.push_back({std::to_string(in.node.members.size()), std::move(node)});
    } else if (in.key) {
      in.node.members.push_back({std::move(*in.key), std::move(node)});
      in.key.reset();
    } else {
      if (node.kind != Kind::kText) NoName(mark);
      in.key = std::move(node.text);
      in.key_where = where_of_(mark.line);
    }
  }
  bool IsKey() const { return !open_.empty() && open_.back().node.kind == Kind::kMap && !open_.back().key; }
  void Count(const YAML::Mark& mark, const Extent& more) {
    all_.values += more.values;
    all_.bytes += more.bytes;
    if (all_.values > kMaxValues || all_.bytes > kMaxBytes)
      throw YAML::Exception(
          mark, fmt::format("too much, aliases put in; valid: up to {} keys and values, of {} MiB together",
                            kMaxValues, kMaxBytes >> 20));
  }
  [[noreturn]] static void TooDeep(const YAML::Mark& mark) {
    throw YAML::Exception(mark, fmt::format("nested too deeply; valid: up to {} levels", kMaxDepth));
  }
  [[noreturn]] static void NoName(const YAML::Mark& mark) {
    throw YAML::Exception(mark, "a key must be a name");
  }

  const std::function<Place(int line)>& where_of_;
  ConfigNode root_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, ConfigNode> anchors_;
  Extent all_;
  int documents_ = 0;
};

// Whether JSON has it without quotes.
bool IsPlain(const std::string& text) {
  if (text == "true" || text == "false") return true;
  const std::size_t first = text.starts_with('-') ? 1 : 0;
  const auto digit = [&](std::size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
  if (!digit(first) || (text[first] == '0' && digit(first + 1)) || text.ends_with('.')) return false;
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

ConfigNode ReadNodes(const std::string& text, const std::function<Place(int line)>& where_of) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  TreeBuilder tree(where_of);
  while (parser.HandleNextDocument(tree)) {}
  return tree.Take();
}

std::string FlowText(const ConfigNode& node) {
  std::vector<std::string> members;
  switch (node.kind) {
    case Kind::kNothing:
      return "null";
    case Kind::kText:
      return !node.quoted && IsPlain(node.text) ? node.text : Quoted(node.text);
    case Kind::kList:
      for (const auto& [key, member] : node.members) members.push_back(FlowText(member));
      return fmt::format("[{}]", fmt::join(members, ", "));
    case Kind::kMap:
      for (const auto& [key, member] : node.members) members.push_back(Quoted(key) + ": " + FlowText(member));
      return fmt::format("{{{}}}", fmt::join(members, ", "));
  }
  return "";
}

}  // namespace kestrel
