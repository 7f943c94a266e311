// SPDX-License-Identifier: Apache-2.0
#include "app/dataset/dataset_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class DatasetCommandTest : public InTemporaryFolder {
 protected:
  void Parse(const std::string& line) {
    CLI::App app;
    AddDatasetCommand(app, arguments_);
    app.parse(line);
  }
  DatasetCommandArguments arguments_;
};

TEST_F(DatasetCommandTest, WorldCameraAndRateAreSettingsOfTheScenario) {
  Parse("dataset landing --world nowhere --camera nosuch --rate 1000 --out " + (folder_ / "set").string());
  EXPECT_THAT(
      [&] { DatasetCommand(arguments_); },
      ThrowsMessage<InputError>(AllOf(HasSubstr("--set world=nowhere"), HasSubstr("--set camera=nosuch"),
                                      HasSubstr("--set image.rate_hz=1000"))));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "set"));
}

TEST_F(DatasetCommandTest, RefusesALayoutThatThereIsNot) {
  EXPECT_THAT([&] { Parse("dataset landing --format ros --out set"); },
              ThrowsMessage<CLI::ValidationError>(HasSubstr("valid: euroc, tum, kitti")));
}

}  // namespace
}  // namespace kestrel::app
