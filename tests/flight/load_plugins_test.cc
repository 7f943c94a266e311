// SPDX-License-Identifier: Apache-2.0
#include "flight/load_plugins.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "base/diagnostics.h"
#include "base/version.h"
#include "mission/plugin.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

class LoadPluginsTest : public InTemporaryFolder {
 protected:
  void TearDown() override {
    unsetenv("KESTREL_PLUGINS");
    InTemporaryFolder::TearDown();
  }
  std::string Write(const char* name, const std::string& content) const {
    std::ofstream(folder_ / name) << content;
    return folder_ / name;
  }
};

std::vector<std::string> Refusal(const std::vector<std::string>& files) {
  try {
    LoadPlugins(files);
  } catch (const InputError& e) {
    Mistakes mistakes;
    mistakes.Add(e);
    return mistakes.Texts();
  }
  return {};
}

TEST_F(LoadPluginsTest, RefusesAllFilesThatAreNone) {
  const std::string text = Write("text.so", "no plug-in");
  EXPECT_THAT(Refusal({text, folder_ / "nowhere.so"}),
              ElementsAre(AllOf(StartsWith(text), HasSubstr("is no plug-in of Kestrel")),
                          HasSubstr("there is no file")));
  EXPECT_THAT(LoadedPlugins(), IsEmpty());
}

TEST_F(LoadPluginsTest, RefusesOneOfAnotherVersionWithoutLoadingIt) {
  // No shared object: had it been loaded, the refusal would be that of the system.
  const std::string old =
      Write("old.so", std::string(KESTREL_PLUGIN_MARK_ "0.0.1 abc, g++ 9") + '\0' + "more");
  EXPECT_THAT(Refusal({old}),
              ElementsAre(AllOf(HasSubstr("was built for Kestrel 0.0.1 abc, g++ 9, and this is"),
                                HasSubstr(Version()), HasSubstr("build it with"))));
}

TEST_F(LoadPluginsTest, SaysWhyTheSystemLoadsOneNot) {
  const std::string broken =
      Write("broken.so", fmt::format(KESTREL_PLUGIN_MARK_ "{}, " KESTREL_COMPILER_, Version()) + '\0');
  EXPECT_THAT(Refusal({broken}), ElementsAre(HasSubstr("cannot be loaded")));
}

TEST_F(LoadPluginsTest, LoadsThoseOfTheEnvironment) {
  const std::string text = Write("text.so", "no plug-in");
  setenv("KESTREL_PLUGINS", (text + ":" + text).c_str(), 1);
  EXPECT_THAT(Refusal({}), ElementsAre(StartsWith(text), StartsWith(text)));
}

}  // namespace
}  // namespace kestrel::flight
