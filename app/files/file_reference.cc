// SPDX-License-Identifier: Apache-2.0
#include "app/files/file_reference.h"

#include <fmt/format.h>

#include "app/files/field_text.h"
#include "app/files/file_kinds.h"

namespace kestrel::app {
namespace {

// A bar would end the cell.
std::string Cell(const std::string& text) {
  std::string cell;
  for (const char c : text) cell += c == '|' ? "\\|" : std::string(1, c);
  return cell;
}

void Rows(const std::vector<FieldDescription>& fields, const std::string& prefix, std::string& page) {
  for (const FieldDescription& each : fields) {
    const std::string path = prefix + each.key;
    page += fmt::format("| `{}` | {} | {} |\n", path, Cell(each.meaning), Cell(TypeAndDefault(each)));
    Rows(each.fields,
         path + (each.kind == FieldKind::kMap    ? ".NAME."
                 : each.kind == FieldKind::kList ? "[]."
                                                 : "."),
         page);
  }
}

std::string Table(const std::vector<FieldDescription>& fields) {
  std::string page = "| key | meaning | value |\n|---|---|---|\n";
  Rows(fields, "", page);
  return page + '\n';
}

}  // namespace

std::string FileReference() {
  std::string page =
      "# Files\n\nThis page is printed by `kestrel reference files`, and is not edited. `kestrel explain "
      "KEY` says the "
      "same of one key,\n`kestrel new KIND` begins a file with all of them, and `kestrel schema KIND` is for "
      "editors.\n\n`.NAME.` stands for any name, `[].` for each of a list.\n\n";
  for (const FileKind& kind : FileKinds())
    page += fmt::format("- [{0}](#{0}): {1}\n", kind.name, kind.summary);
  for (const FileKind& kind : FileKinds()) {
    page +=
        fmt::format("\n## {}\n\n{}\n\n{}", kind.name, AsSentence(kind.summary), Table(CommonFields(kind)));
    for (const FileKind::Variant& variant : kind.variants)
      if (const auto own = OwnFields(kind, variant); !own.empty())
        page += fmt::format("With `{}: {}`:\n\n{}", kind.selector, variant.name, Table(own));
    page.pop_back();
  }
  return page;
}

}  // namespace kestrel::app
