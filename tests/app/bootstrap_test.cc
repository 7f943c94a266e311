// SPDX-License-Identifier: Apache-2.0
// The script `kestrel` at the top of the tree, with stand-ins for the programs that it calls.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class BootstrapTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    fs::copy_file(fs::path(KESTREL_SOURCE_DIR) / "kestrel", folder_ / "kestrel");
    std::ofstream(folder_ / "packages.txt") << "libnothing-dev   # a package that is missing\n";
    fs::create_directory(folder_ / "bin");
    StandIn("dpkg-query", "true");
    StandIn("sudo", "\"$@\"");
    StandIn("apt-get", "echo \"Get:1 libnothing-dev [42 kB]\"");
    StandIn("cmake", "true");
    StandIn("ninja", "printf '#!/bin/sh\\necho flown\\n' > build/kestrel-run; chmod +x build/kestrel-run");
  }
  void StandIn(const char* program, const char* line) {
    const fs::path file = folder_ / "bin" / program;
    std::ofstream(file) << "#!/bin/sh\n" << line << "\n";
    fs::permissions(file, fs::perms::owner_all);
  }
  // As on a terminal, or with its output in files.
  Ended Run(bool terminal) const {
    const char* command = "PATH=$PWD/bin:$PATH ./kestrel run landing";
    return Shell(folder_, terminal ? fmt::format("script -qec '{}' /dev/null </dev/null", command) : command);
  }
};

TEST_F(BootstrapTest, OnATerminalThePackagesAreSeenToCome) {
  const Ended run = Run(true);
  EXPECT_EQ(run.status, 0) << run.out << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("installing libnothing-dev"),
                             HasSubstr("Get:1 libnothing-dev [42 kB]"), HasSubstr("flown")));
}

TEST_F(BootstrapTest, ElsewhereTheyGoToTheLogAlone) {
  const Ended run = Run(false);
  EXPECT_EQ(run.status, 0) << run.out << run.err;
  EXPECT_THAT(run.out + run.err, AllOf(HasSubstr("flown"), Not(HasSubstr("Get:1"))));
  EXPECT_THAT(Content(folder_ / "build/install.log"), HasSubstr("Get:1 libnothing-dev"));
}

TEST_F(BootstrapTest, PackagesThatDoNotComeEndItWithTheReason) {
  StandIn("apt-get", "echo E: no network; exit 100");
  for (const bool terminal : {true, false}) {
    const Ended run = Run(terminal);
    EXPECT_EQ(run.status, 3) << run.out << run.err;
    EXPECT_THAT(run.out + run.err, AllOf(HasSubstr("no network"), HasSubstr("cannot install the packages")));
  }
}

}  // namespace
}  // namespace kestrel::app
