// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>

#include "app/manual/completion.h"
#include "app/manual/man_page.h"
#include "app/manual/reference.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class ManualTest : public InTemporaryFolder {
 protected:
  ManualTest() {
    app_.require_subcommand(1);
    CLI::App* run = app_.add_subcommand("run", "Fly a scenario, 'once'");
    run->add_option("scenario", text_, "A name")->required()->type_name("SCENARIO");
    run->add_option("--out", text_, "Folder")->type_name("DIR");
    run->add_flag("--quiet", quiet_, "Print nothing");
    run->footer("Examples:\n  kestrel run hover");
    app_.add_subcommand("campaign", "Fly many")->add_subcommand("replay", "One of them");
    app_.add_subcommand("secret", "Hidden")->group("");
  }
  void Write(const char* name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  // What bash offers after these words, of which the last is not complete.
  std::string Offered(const std::string& words) const {
    return Shell(folder_,
                 fmt::format("PATH={}:$PATH bash -c 'source k.bash; COMP_WORDS=(kestrel {}); "
                             "COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _kestrel; echo ${{COMPREPLY[*]}}'",
                             folder_.string(), words))
        .out;
  }
  CLI::App app_{"Kestrel: about.", "kestrel"};
  std::string text_;
  bool quiet_ = false;
};

TEST_F(ManualTest, BashCompletesVerbsOptionsAndNames) {
  Write("k.bash", BashCompletion(app_));
  Write("kestrel", "#!/bin/sh\n[ \"$*\" = 'list scenarios --names' ] && printf 'hover\\nlanding\\n'\n");
  ASSERT_EQ(Shell(folder_, "chmod +x kestrel && mkdir folder").status, 0);
  EXPECT_EQ(Offered("r"), "run\n");
  EXPECT_EQ(Offered("\"\""), "run campaign\n");
  EXPECT_EQ(Offered("campaign re"), "replay\n");
  EXPECT_EQ(Offered("run ho"), "hover\n");
  EXPECT_EQ(Offered("run hover --q"), "--quiet\n");
  EXPECT_EQ(Offered("run hover --out fo"), "folder\n");
}

TEST_F(ManualTest, TheScriptsOfOtherShellsHaveEveryVerb) {
  for (const std::string& script : {ZshCompletion(app_), FishCompletion(app_)})
    EXPECT_THAT(script,
                AllOf(HasSubstr("run"), HasSubstr("replay"), HasSubstr("quiet"), Not(HasSubstr("secret"))));
  EXPECT_THAT(FishCompletion(app_), HasSubstr(R"(-a run -d 'Fly a scenario, '\''once'\''')"));
}

TEST_F(ManualTest, TheManPageIsReadByManWithoutAWarning) {
  Write("k.1", ManPage(app_, "1.2"));
  const Ended page = Shell(folder_, "groff -Tascii -P-cbou -man -ww k.1");
  EXPECT_EQ(page.status, 0);
  EXPECT_EQ(page.err, "");
  EXPECT_THAT(page.out, AllOf(HasSubstr("kestrel run [OPTIONS] scenario"), HasSubstr("--out DIR"),
                              HasSubstr("kestrel - about"), HasSubstr("  kestrel run hover"),
                              HasSubstr("campaign replay"), Not(HasSubstr("secret"))));
}

TEST_F(ManualTest, TheReferenceHasEveryVerbWithItsOptions) {
  EXPECT_THAT(CommandReference(app_),
              AllOf(HasSubstr("## kestrel run\n"), HasSubstr("- `--out DIR`: Folder\n"),
                    HasSubstr("## kestrel campaign replay\n"), Not(HasSubstr("secret"))));
}

// A page that is out of date is written anew by `kestrel reference`.
TEST_F(ManualTest, TheCommittedReferenceIsWhatTheProgramPrints) {
  const auto page = std::filesystem::path(KESTREL_SOURCE_DIR) / "docs" / "reference" / "commands.md";
  const Ended printed = Shell(folder_, KESTREL_PROGRAM " reference");
  EXPECT_EQ(printed.status, 0);
  EXPECT_EQ(printed.out, Content(page)) << "kestrel reference > docs/reference/commands.md";
}

}  // namespace
}  // namespace kestrel::app
