// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/scenario_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "base/file/model_files.h"
#include "campaign/execution/result_store.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class ScenarioFilesTest : public InTemporaryFolder {};

TEST_F(ScenarioFilesTest, TellsByWhichModelsFlightsAre) {
  const fs::path camera = folder_ / "mine.yaml", scenario = folder_ / "flight.yaml";
  fs::copy(Root() / "models/cameras/thesis_6mm.yaml", camera);
  std::ofstream(scenario) << "mission: hover\ncamera: mine.yaml\n";
  const ScenarioFiles before(scenario.string(), {}, {});
  EXPECT_THAT(before.Models(), HasSubstr("vehicles/pelican/pelican.yaml "));
  EXPECT_THAT(before.Models(), HasSubstr("pads/helipad/helipad.png "));
  EXPECT_THAT(before.Models(), Not(HasSubstr("cameras/")));  // no flight is by any of them
  EXPECT_THAT(ModelsThatDiffer(before.Models(), ScenarioFiles(scenario.string(), {}, {}).Models()),
              IsEmpty());
  EXPECT_NO_THROW(before.RequireUnchanged());

  std::ofstream(camera, std::ios::app) << "# another\n";
  EXPECT_THAT(ModelsThatDiffer(before.Models(), ScenarioFiles(scenario.string(), {}, {}).Models()),
              ElementsAre(camera.string()));
  EXPECT_THROW(before.RequireUnchanged(), std::runtime_error);
}

TEST_F(ScenarioFilesTest, WhatVariesMayBeAnyOfItsKind) {
  const std::string one = ScenarioFiles("hover", {}, {"seed"}).Models();
  EXPECT_THAT(one, AllOf(HasSubstr("cameras/thesis_6mm.yaml "), Not(HasSubstr("cameras/fisheye.yaml ")),
                         Not(HasSubstr("vehicles/sr20/"))));
  const std::string any = ScenarioFiles("hover", {}, {"seed", "camera", "vehicle"}).Models();
  EXPECT_THAT(any, AllOf(HasSubstr("cameras/thesis_6mm.yaml "), HasSubstr("cameras/fisheye.yaml "),
                         HasSubstr("vehicles/sr20/sr20.yaml "), Not(HasSubstr("worlds/winter"))));
  EXPECT_THAT(ScenarioFiles("avoid", {}, {}).Models(), Not(HasSubstr("pads/")));
  EXPECT_THAT(ScenarioFiles("avoid", {}, {"pad"}).Models(), HasSubstr("pads/helipad/helipad.yaml "));
}

}  // namespace
}  // namespace kestrel::campaign
