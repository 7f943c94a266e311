// SPDX-License-Identifier: Apache-2.0
#include "app/reproduce/reproduce_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <set>
#include <string>

#include "app/reproduce/thesis_items.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Reproduce : public InTemporaryFolder {};

// Every caption of the thesis: chapter or appendix, and its last figure or table.
TEST_F(Reproduce, EveryCaptionOfTheThesisHasItsItem) {
  std::set<std::string> captions;
  const auto add = [&](const char* kind, const char* chapter, int last) {
    for (int i = 1; i <= last; ++i) captions.insert(fmt::format("{}-{}.{}", kind, chapter, i));
  };
  add("figure", "1", 2), add("figure", "2", 1), add("figure", "3", 11), add("figure", "4", 18);
  add("figure", "5", 24), add("figure", "6", 23), add("figure", "b", 2);
  add("table", "1", 1), add("table", "3", 1), add("table", "6", 3), add("table", "b", 2);
  std::set<std::string> items;
  for (const ThesisItem& item : LoadThesis(ThesisFile()).items)
    items.insert(item.names.begin(), item.names.end());
  EXPECT_EQ(items, captions);
}

TEST_F(Reproduce, ItemsAreChosenByNameOrNumber) {
  const Thesis thesis = LoadThesis(ThesisFile());
  ASSERT_EQ(Chosen(thesis, {"4.14"}).size(), 1);
  EXPECT_EQ(Chosen(thesis, {"4.14"}), Chosen(thesis, {"Figure 4.16"}));
  EXPECT_EQ(Chosen(thesis, {"table-b.1"}), Chosen(thesis, {"figure-B.1"}));
  EXPECT_EQ(Chosen(thesis, {}).size(), thesis.items.size());
  EXPECT_THROW(Chosen(thesis, {"figure-9.9"}), InputError);
}

TEST_F(Reproduce, TitlesNameRunsOfFiguresByTheirEnds) {
  ThesisItem item;
  item.names = {"table-3.1", "figure-3.7", "figure-3.8", "figure-3.9", "figure-b.1", "figure-b.2"};
  EXPECT_EQ(TitleOf(item), "Table 3.1, figures 3.7 to 3.9, figures B.1 and B.2");
}

TEST_F(Reproduce, AFileThatIsWrongIsRefusedWithEveryMistake) {
  WriteFile(folder_ / "thesis.yaml",
            "flights: {pose: {scenario: pose}}\n"
            "items:\n"
            "  - {names: [figure-1.1, picture]}\n"
            "  - {names: [figure-1.1], flights: [nobody], values: [{what: x, metric: nothing}]}\n");
  try {
    LoadThesis(folder_ / "thesis.yaml");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_EQ(e.diagnostics.size(), 5);
    EXPECT_THAT(e.what(), HasSubstr("'nobody' is none of the flights"));
    EXPECT_THAT(e.what(), HasSubstr("'nothing' is no metric"));
    EXPECT_THAT(e.what(), HasSubstr("a second time"));
  }
}

TEST_F(Reproduce, OneItemIsFlownDrawnAndOnAPageWithoutFilesBesideIt) {
  const Ended ended = Shell(folder_, KESTREL_PROGRAM " reproduce figure-6.13 figure-1.1 --out page");
  ASSERT_EQ(ended.status, 0) << ended.err;
  const std::string page = ReadFile(folder_ / "page/index.html");
  EXPECT_THAT(page, HasSubstr("src=\"data:image/png;base64,iVBOR"));
  EXPECT_THAT(page, HasSubstr("kestrel reproduce figure-6.13"));
  EXPECT_THAT(page, HasSubstr("kestrel run attitude_3"));
  EXPECT_THAT(page, HasSubstr("Forecasts of a market"));
  EXPECT_THAT(page, Not(HasSubstr("src=\"flights")));
}

TEST_F(Reproduce, ListTellsWhyThereIsNoCounterpart) {
  const Ended ended = Shell(folder_, KESTREL_PROGRAM " reproduce --list");
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("figure-3.4    no counterpart: Photographs"));
  EXPECT_THAT(ended.out, HasSubstr("table-6.3"));
}

}  // namespace
}  // namespace kestrel::app
