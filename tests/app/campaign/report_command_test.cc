// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/report_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/yaml/yaml_fields.h"
#include "tests/campaign/landing_campaign.h"
#include "tests/support/content.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class ReportCommandTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    campaign::ReportSubject subject = campaign::LandingCampaign(20, folder_);
    subject.identity.plan +=
        "\n# --set runs=20\n\n# --set set=[wind.gusts.rate_per_min=0]\n\n# --stop-when 0.02\n";
    campaign::ResultStore store = campaign::ResultStore::Open(file_, subject.identity);
    for (std::size_t k = 0; k < 12; ++k) store.Put(subject.results[k]);
  }

  void TearDown() override { fs::remove_all(folder_); }

  const fs::path folder_ = fs::path(testing::TempDir()) / fmt::format("kestrel report {}", getpid());
  const fs::path file_ = folder_ / "results.sqlite";
};

TEST_F(ReportCommandTest, WritesWhatHasAResultBesideTheResults) {
  CampaignReportCommand({file_.string(), "", true});
  EXPECT_THAT(Content(folder_ / "report.html"), StartsWith("<!DOCTYPE html>"));
  const std::string csv = Content(folder_ / "runs.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 13);
  const auto summary = nlohmann::json::parse(Content(folder_ / "summary.json"));
  EXPECT_EQ(summary["rows"], 20);
  EXPECT_EQ(summary["runs"], 12);
}

TEST_F(ReportCommandTest, FliesAgainWithTheOptionsOfTheFirstTime) {
  const std::string options =
      " --set runs=20 --set 'set=[wind.gusts.rate_per_min=0]' --out '" + folder_.string() + "'";
  EXPECT_EQ(SubjectOf(file_).replay, "./kestrel campaign replay landing_dispersion.yaml" + options);
  EXPECT_EQ(SubjectOf(file_, "mine.yaml").again, "./kestrel campaign mine.yaml" + options);
}

TEST_F(ReportCommandTest, NamesTheCampaignsFileWhereItIs) {
  const fs::path file = folder_ / "mine.yaml";
  {
    campaign::CampaignIdentity identity = campaign::ResultStore::Read(file_).identity();
    identity.file = file.string();
    campaign::ResultStore::Open(file_, identity);
  }
  EXPECT_THAT(SubjectOf(file_).replay, HasSubstr("replay landing_dispersion.yaml "));  // it is no more
  std::ofstream(file) << "scenario: landing\n";
  EXPECT_THAT(SubjectOf(file_).replay, HasSubstr("replay '" + file.string() + "' "));
}

TEST_F(ReportCommandTest, TakesAFolderAsCompareDoes) {
  CampaignReportCommand({folder_.string(), "", true});
  EXPECT_TRUE(fs::exists(folder_ / "report.html"));
}

TEST_F(ReportCommandTest, AFolderThatCannotBeWrittenIsRefusedBeforeTheWork) {
  fs::permissions(folder_, fs::perms(0555));
  const pid_t reader = fork();
  if (reader == 0) {
    if (getuid() == 0 && setuid(65534) != 0) _exit(9);  // permissions do not hold root back
    try {
      CampaignReportCommand({file_.string(), "", true});
    } catch (const InputError& e) {
      _exit(std::string(e.what()).starts_with("report: '") ? 2 : 4);
    } catch (const std::exception&) {
      _exit(3);
    }
    _exit(0);
  }
  int status = 0;
  waitpid(reader, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 2);
  fs::permissions(folder_, fs::perms::owner_all);
}

TEST_F(ReportCommandTest, JudgesTheThresholdsOfThePlan) {
  std::vector<std::string> names;
  for (const campaign::JudgedThreshold& each : SubjectOf(file_).summary.thresholds)
    names.push_back(each.name);
  EXPECT_THAT(names, ElementsAre("success", "touchdown_error_m, 95 % quantile"));
}

TEST_F(ReportCommandTest, TellsWhetherTheThresholdsAreKept) {
  EXPECT_FALSE(CampaignReportCommand({file_.string(), "", true}));  // of 12 runs no more than 74 % is shown
  campaign::CampaignIdentity identity = campaign::LandingCampaign(20, folder_).identity;
  std::string& plan = identity.plan;
  plan = plan.substr(0, plan.find("thresholds:")) + "thresholds: {success: {min: 0}}\n";
  const fs::path kept = folder_ / "kept.sqlite";
  campaign::ResultStore::Open(kept, identity).Put(campaign::LandingCampaign(20, folder_).results[0]);
  EXPECT_TRUE(CampaignReportCommand({kept.string(), "", true}));
}

TEST_F(ReportCommandTest, RefusesWhatHoldsNoResults) {
  EXPECT_THROW(CampaignReportCommand({(folder_ / "none.sqlite").string(), "", true}), InputError);
  std::ofstream(folder_ / "text.sqlite") << "text";
  EXPECT_THROW(CampaignReportCommand({(folder_ / "text.sqlite").string(), "", true}), InputError);
  EXPECT_THROW(CampaignReportCommand({"no_such_campaign", "", true}), InputError);
}

}  // namespace
}  // namespace kestrel::app
