// SPDX-License-Identifier: Apache-2.0
#include "app/files/explain_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>

#include "app/files/field_text.h"
#include "app/files/file_kinds.h"
#include "app/option/one_of.h"
#include "base/diagnostics.h"
#include "base/nearest_name.h"

namespace kestrel::app {
namespace {

struct Found {
  std::string path;
  FieldDescription field;
  std::string where;  // "scenario", "scenario, of the mission landing"
};

// All keys below some, with their paths; of one that a map holds by a name that stands for any.
void Gather(const std::vector<FieldDescription>& fields, const std::string& prefix, const std::string& where,
            std::vector<Found>& all) {
  for (const FieldDescription& each : fields) {
    const std::string path = prefix + each.key;
    all.push_back({path, each, where});
    Gather(each.fields, path + (each.kind == FieldKind::kMap ? ".NAME." : "."), where, all);
  }
}

std::vector<Found> KeysOf(const FileKind& kind) {
  std::vector<Found> all;
  Gather(CommonFields(kind), "", kind.name, all);
  for (const FileKind::Variant& variant : kind.variants) {
    const std::vector<FieldDescription> own = OwnFields(kind, variant);
    if (!own.empty())
      Gather(own, "", fmt::format("{} with {}: {}", kind.name, kind.selector, variant.name), all);
  }
  return all;
}

std::vector<std::string> PartsOf(const std::string& path) {
  std::vector<std::string> parts{""};
  for (const char c : path)
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

// Whether a path means this one or ends it; in a list by a number or without, in a map by any name.
bool Means(std::string asked, const std::string& path) {
  std::vector<std::string> wanted = PartsOf(asked), has = PartsOf(path);
  std::erase_if(wanted, [](const std::string& part) {
    return !part.empty() &&
           std::all_of(part.begin(), part.end(), [](unsigned char c) { return std::isdigit(c); });
  });
  if (wanted.empty() || wanted.size() > has.size()) return false;
  return std::equal(wanted.rbegin(), wanted.rend(), has.rbegin(),
                    [](const std::string& a, const std::string& b) { return a == b || b == "NAME"; });
}

std::string TableOf(const std::vector<FieldDescription>& fields) {
  std::size_t widest = 0;
  for (const FieldDescription& each : fields) widest = std::max(widest, each.key.size());
  std::string text;
  for (const FieldDescription& each : fields)
    text +=
        fmt::format("  {:<{}}  {}\n", each.key, widest, each.meaning.empty() ? TypeText(each) : each.meaning);
  return text;
}

std::string TextOf(const Found& found) {
  const FieldDescription& f = found.field;
  std::string text = fmt::format("{} ({})\n", found.path, found.where);
  if (!f.meaning.empty()) text += fmt::format("  {}\n", AsSentence(f.meaning));
  text += fmt::format("  {}\n", TypeAndDefault(f));
  if (!f.former.empty()) text += fmt::format("  formerly {}\n", f.former);
  if (!f.fields.empty()) text += '\n' + TableOf(f.fields);
  return text;
}

std::string KindText(const FileKind& kind) {
  std::string text = fmt::format("{}: {}\n\n{}", kind.name, kind.summary, TableOf(CommonFields(kind)));
  for (const FileKind::Variant& variant : kind.variants)
    if (const auto own = OwnFields(kind, variant); !own.empty())
      text += fmt::format("\n{}: {}\n{}", kind.selector, variant.name, TableOf(own));
  return text;
}

std::string AllKinds() {
  std::string text;
  for (const FileKind& kind : FileKinds()) text += fmt::format("{:<10}{}\n", kind.name, kind.summary);
  return text + "\nkestrel explain --of KIND shows its keys, kestrel explain KEY what one means.\n";
}

std::vector<const FileKind*> KindsAsked(const std::string& name) {
  std::vector<const FileKind*> kinds;
  for (const FileKind& each : FileKinds())
    if (name.empty() || each.name == name) kinds.push_back(&each);
  return kinds;
}

}  // namespace

CLI::App* AddExplainCommand(CLI::App& app, ExplainArguments& a) {
  CLI::App* command = app.add_subcommand("explain", "Say what a key of a file means and what it may be");
  command->add_option("key", a.key,
                      "Key with dots, or its end; without one: the kinds of files, or all keys of one");
  command->add_option("--of", a.kind, "Kind of file that has it")->check(OneOf(FileKindNames()));
  command->footer(
      "Examples:\n  kestrel explain wind.mean_m_s\n  kestrel explain speed_limit_m_s\n"
      "  kestrel explain --of campaign");
  return command;
}

std::string ExplainText(const ExplainArguments& a) {
  if (a.key.empty()) return a.kind.empty() ? AllKinds() : KindText(FileKindNamed(a.kind));
  std::vector<Found> whole, ends;
  std::vector<std::string> names;
  for (const FileKind* kind : KindsAsked(a.kind)) {
    for (Found& each : KeysOf(*kind)) {
      names.push_back(each.path);
      names.push_back(each.field.key);
      if (!Means(a.key, each.path)) continue;
      auto& list = PartsOf(a.key).size() >= PartsOf(each.path).size() ? whole : ends;
      // What several variants mean alike is said once.
      const auto same = std::find_if(list.begin(), list.end(), [&](const Found& other) {
        return other.path == each.path && other.field == each.field;
      });
      if (same == list.end())
        list.push_back(std::move(each));
      else
        same->where += ", " + each.where;
    }
  }
  const std::vector<Found>& found = whole.empty() ? ends : whole;
  if (found.empty())
    throw InputError(
        "kestrel explain",
        fmt::format("no file{} has a key '{}'", a.kind.empty() ? "" : " of the kind " + a.kind, a.key),
        RemedyForName(a.key, names));
  std::string text;
  for (const Found& each : found) text += (text.empty() ? "" : "\n") + TextOf(each);
  return text;
}

void ExplainCommand(const ExplainArguments& a) { fmt::print("{}", ExplainText(a)); }

}  // namespace kestrel::app
