// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/compare_command.h"

#include <gmock/gmock.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/diagnostics.h"
#include "campaign/execution/result_store.h"
#include "tests/campaign/example_campaign.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class CompareCommandLine : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    const campaign::CampaignResults a = campaign::ExampleCampaign();
    campaign::CampaignResults b = a;
    for (campaign::RunResult& run : b.results)
      if (const auto found = run.metrics.find("touchdown_error_m"); found != run.metrics.end())
        found->second *= 0.9;
    Write("a", a), Write("b", b);
  }
  void Write(const char* name, const campaign::CampaignResults& campaign) {
    fs::create_directories(folder_ / name);
    campaign::ResultStore store =
        campaign::ResultStore::Open(folder_ / name / "results.sqlite", campaign.identity);
    for (std::size_t i = 0; i < 60; ++i) store.Put(campaign.results[i]);
  }
  bool Run(std::vector<std::string> words) {
    CLI::App app;
    CompareArguments arguments;
    AddCompareCommand(app, arguments);
    std::reverse(words.begin(), words.end());  // as CLI11 takes them
    app.parse(words);
    return CompareCommand(arguments);
  }
};

TEST_F(CompareCommandLine, ReadsResultFilesOrTheirFoldersAndFailsWhereBIsWorse) {
  const std::string a = folder_ / "a", b = folder_ / "b" / "results.sqlite", json = folder_ / "out.json";
  EXPECT_TRUE(Run({"compare", a, b, "--json", json, "--metric", "touchdown_error_m"}));
  std::ifstream in(json);
  const auto comparison = nlohmann::json::parse(in);
  EXPECT_EQ(comparison.at("verdict"), "better");
  EXPECT_EQ(comparison.at("rows").at("both_have"), 60);
  EXPECT_EQ(comparison.at("metrics").size(), 1u);
  EXPECT_FALSE(Run({"compare", b, a}));
  EXPECT_TRUE(Run({"compare", a, a}));
}

TEST_F(CompareCommandLine, RefusesWhatHasNoResults) {
  try {
    Run({"compare", folder_ / "nothing", "no_such_campaign", "--json", "/nowhere/x.json"});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), testing::AllOf(HasSubstr("nothing' has no results"),
                                         HasSubstr("'no_such_campaign'"), HasSubstr("--json")));
  }
}

}  // namespace
}  // namespace kestrel::app
