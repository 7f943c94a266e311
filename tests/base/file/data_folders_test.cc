// SPDX-License-Identifier: Apache-2.0
#include "base/file/data_folders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "tests/support/temporary_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class DataFoldersTest : public InTemporaryFolder {
 protected:
  void TearDown() override {
    unsetenv("KESTREL_ROOT");
    unsetenv("KESTREL_PATH");
    InTemporaryFolder::TearDown();
  }
  // An empty file.
  fs::path Add(const fs::path& file) const {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << "";
    return folder_ / file;
  }
  void SetPath(std::initializer_list<const char*> folders) const {
    std::string path;
    for (const char* each : folders) path += (path.empty() ? "" : ":") + (folder_ / each).string();
    setenv("KESTREL_PATH", path.c_str(), 1);
  }
};

TEST_F(DataFoldersTest, AreTheSourceForAProgramInABuildFolder) {
  EXPECT_TRUE(fs::exists(Root() / "base" / "file" / "data_folders.h"));
  EXPECT_THAT(ScenarioNames(), Contains("landing"));
}

TEST_F(DataFoldersTest, TheFirstThatHasANameGivesIt) {
  const fs::path first = Add("a/models/cameras/shared.yaml");
  Add("b/models/cameras/shared.yaml");
  const fs::path second = Add("b/models/pads/square/square.yaml");
  setenv("KESTREL_ROOT", (folder_ / "c").c_str(), 1);
  SetPath({"a", "b"});
  EXPECT_EQ(DataFile("models/cameras/shared.yaml"), first);
  EXPECT_EQ(DataFile("models/pads/square/square.yaml"), second);
  EXPECT_EQ(DataFile("models/none.yaml"), folder_ / "c/models/none.yaml");
}

TEST_F(DataFoldersTest, ListsShowTheNamesOfAll) {
  Add("a/scenarios/mine/shared.yaml");
  Add("a/scenarios/mine/mine.yaml");
  Add("b/scenarios/theirs/theirs.yaml");
  Add("b/scenarios/mine/shared.yaml");
  setenv("KESTREL_ROOT", (folder_ / "b").c_str(), 1);
  SetPath({"a"});
  EXPECT_THAT(ScenarioNames(), ElementsAre("mine", "shared", "theirs"));
}

TEST_F(DataFoldersTest, OneOfThePathThatIsNotThereIsRefused) {
  SetPath({"nowhere"});
  try {
    DataFolders();
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(),
                AllOf(HasSubstr("KESTREL_PATH"), HasSubstr("nowhere"), HasSubstr("valid: folders")));
  }
}

TEST_F(DataFoldersTest, AModelMayBeAFileBesideTheScenario) {
  const fs::path world = Add("my/field.xml");
  std::string name = "field.xml";
  Mistakes mistakes;
  EXPECT_EQ(ModelFile(Model::kWorld, name, folder_ / "my", Place("my.yaml", 3), mistakes), world);
  EXPECT_EQ(name, world);
  EXPECT_THAT(mistakes.Texts(), IsEmpty());
  name = "meadow.xml";
  EXPECT_FALSE(ModelFile(Model::kWorld, name, folder_ / "my", Place("my.yaml", 3), mistakes));
  EXPECT_THAT(mistakes.Texts(), ElementsAre(HasSubstr("my.yaml:3: world: there is no file")));
}

TEST_F(DataFoldersTest, AModelIsFoundByItsName) {
  Mistakes mistakes;
  std::string name = "pelican";
  EXPECT_EQ(ModelFile(Model::kVehicle, name, "", "", mistakes),
            Root() / "models/vehicles/pelican/pelican.yaml");
  name = "airfield";
  EXPECT_EQ(ModelFile(Model::kWorld, name, "", "", mistakes), Root() / "models/worlds/airfield/airfield.xml");
  EXPECT_EQ(name, "airfield");
  EXPECT_THAT(mistakes.Texts(), IsEmpty());
  name = "pelikan";
  ModelFile(Model::kVehicle, name, "", Place("my.yaml", 2), mistakes);
  EXPECT_THAT(mistakes.Texts(),
              ElementsAre("my.yaml:2: vehicle: there is no vehicle 'pelikan'; did you mean 'pelican'?"));
}

}  // namespace
}  // namespace kestrel
