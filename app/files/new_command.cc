// SPDX-License-Identifier: Apache-2.0
#include "app/files/new_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <sstream>

#include "app/files/field_text.h"
#include "app/option/one_of.h"
#include "base/diagnostics.h"
#include "base/nearest_name.h"
#include "base/yaml/config.h"

namespace kestrel::app {
namespace {

constexpr std::size_t kColumns = 120;

// What is said of a key: behind it where that fits, or before it.
std::string WithComment(const std::string& line, const std::string& comment) {
  if (comment.empty()) return line + '\n';
  if (line.size() + 4 + comment.size() <= kColumns) return line + "  # " + comment + '\n';
  return std::string(line.find_first_not_of(" -"), ' ') + "# " + comment + '\n' + line + '\n';
}

std::string CommentOf(const FieldDescription& f) {
  if (!f.fields.empty()) return f.meaning;
  return f.meaning.empty() ? TypeText(f) : fmt::format("{}; {}", f.meaning, TypeText(f));
}

// With a space before it.
std::string ValueOf(const FieldDescription& f) {
  if (!f.value.empty()) return ' ' + f.value;
  if (f.kind == FieldKind::kAny) return " {}";
  return f.kind == FieldKind::kTexts ? " []" : "";  // of a number, as the model has it
}

std::string AsComment(const std::string& lines) {
  std::string text;
  std::istringstream all(lines);
  for (std::string line; std::getline(all, line);) text += (line.starts_with("#") ? "" : "#") + line + '\n';
  return text;
}

// Its keys are names that stand for any, of which no valid file can be made.
bool HoldsNames(const FieldDescription& f) {
  return f.kind == FieldKind::kStruct && std::any_of(f.fields.begin(), f.fields.end(), [](const auto& each) {
           return each.kind == FieldKind::kMap;
         });
}

std::string Lines(const std::vector<FieldDescription>& fields, int indent);

std::string Lines(const FieldDescription& f, int indent) {
  const std::string key = fmt::format("{:{}}{}:", "", indent, f.key);
  if (f.fields.empty()) return WithComment(key + ValueOf(f), CommentOf(f));
  std::string text = WithComment(key, CommentOf(f));
  if (f.kind == FieldKind::kMap)
    return text + fmt::format("{:{}}NAME:\n", "", indent + 2) + Lines(f.fields, indent + 4);
  if (HoldsNames(f)) return AsComment(text + Lines(f.fields, indent + 2));
  if (f.kind != FieldKind::kList) return text + Lines(f.fields, indent + 2);
  std::string item = Lines(f.fields, indent + 4);
  // The dash goes before the first key, whatever comment stands before that.
  std::size_t begin = 0;
  while (item[begin + static_cast<std::size_t>(indent) + 4] == '#') begin = item.find('\n', begin) + 1;
  item[begin + static_cast<std::size_t>(indent) + 2] = '-';
  return text + item;
}

std::string Lines(const std::vector<FieldDescription>& fields, int indent) {
  std::string text;
  for (const FieldDescription& each : fields) text += Lines(each, indent);
  return text;
}

const FileKind::Variant& VariantOf(const FileKind& kind, const NewArguments& a) {
  std::string asked;
  for (const auto& [selector, value] : a.variants) {
    if (value.empty()) continue;
    if (selector != kind.selector)
      throw InputError("--" + selector, fmt::format("a {} has no key '{}'", kind.name, selector),
                       "leave it out");
    asked = value;
  }
  std::vector<std::string> names;
  for (const FileKind::Variant& each : kind.variants) {
    if (asked.empty() || each.name == asked) return each;
    names.push_back(each.name);
  }
  throw InputError("--" + kind.selector, fmt::format("there is no {} '{}'", kind.selector, asked),
                   RemedyForName(asked, names));
}

}  // namespace

CLI::App* AddNewCommand(CLI::App& app, NewArguments& a) {
  CLI::App* command = app.add_subcommand("new", "Begin a file, in which every key stands with its meaning");
  command->add_option("what", a.kind, "What to begin")->required()->check(OneOf(FileKindNames()));
  command->add_option("file", a.file, "File that is written; without one it is printed");
  command->add_option("--mission", a.variants["mission"], "Mission of a scenario")->type_name("MISSION");
  command->add_option("--model", a.variants["model"], "Model of a camera");
  command->add_option("--kind", a.variants["kind"], "Kind of a vehicle: multirotor, helicopter");
  command->footer(
      "Examples:\n  kestrel new scenario my_flight.yaml --mission landing\n  kestrel new campaign");
  return command;
}

std::string NewFile(const FileKind& kind, const FileKind::Variant& variant) {
  std::string text =
      fmt::format("# {}\n# A key behind '#' has the value that stands there unless it is given.\n",
                  AsSentence(kind.summary));
  for (FieldDescription each : variant.fields) {
    const auto example = kind.examples.find(each.key);
    if (example != kind.examples.end()) each.value = example->second, each.fields.clear();
    if (each.key == kind.selector) each.value = variant.name;
    if (each.key == kDescriptionKey) each.value = fmt::format("My own {}.", kind.name);
    const bool stands = each.required || each.key == kind.selector || example != kind.examples.end() ||
                        (kind.name == "scenario" && each.key == "flight");
    // A map of no keys.
    if (each.kind == FieldKind::kStruct && each.fields.empty() && each.value.empty()) continue;
    text += stands ? Lines(each, 0) : AsComment(Lines(each, 0));
  }
  return text;
}

void NewCommand(const NewArguments& a) {
  const FileKind& kind = FileKindNamed(a.kind);
  const std::string text = NewFile(kind, VariantOf(kind, a));
  if (a.file.empty()) {
    fmt::print("{}", text);
    return;
  }
  if (std::filesystem::exists(a.file))
    throw InputError(a.file.string(), "is there already", "name another file, or remove it");
  std::ofstream out(a.file);
  out << text;
  if (!out.flush()) throw InputError(a.file.string(), "cannot be written");
}

}  // namespace kestrel::app
