// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/scenario_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "campaign/execution/result_store.h"
#include "scenarios/model_files.h"
#include "tests/scenarios/temporary_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class ScenarioFilesTest : public InTemporaryFolder {};

TEST_F(ScenarioFilesTest, TellsByWhichModelsFlightsAre) {
  const fs::path camera = folder_ / "mine.yaml", scenario = folder_ / "flight.yaml";
  fs::copy(Root() / "models/cameras/thesis_6mm.yaml", camera);
  std::ofstream(scenario) << "mission: hover\ncamera: mine.yaml\n";
  const ScenarioFiles before(scenario.string(), {});
  EXPECT_THAT(before.Models(), HasSubstr("vehicles/pelican/pelican.yaml "));
  EXPECT_THAT(before.Models(), Not(HasSubstr("README")));  // no flight depends on it
  EXPECT_THAT(ModelsThatDiffer(before.Models(), ScenarioFiles(scenario.string(), {}).Models()), IsEmpty());
  EXPECT_NO_THROW(before.RequireUnchanged());

  std::ofstream(camera, std::ios::app) << "# another\n";
  EXPECT_THAT(ModelsThatDiffer(before.Models(), ScenarioFiles(scenario.string(), {}).Models()),
              ElementsAre(camera.string()));
  EXPECT_THROW(before.RequireUnchanged(), std::runtime_error);
}

}  // namespace
}  // namespace kestrel
