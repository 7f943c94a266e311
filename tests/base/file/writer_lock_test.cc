// SPDX-License-Identifier: Apache-2.0
#include "base/file/writer_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"

namespace kestrel {
namespace {

using ::testing::HasSubstr;

class WriterLockTest : public InTemporaryFolder {
 protected:
  std::string Refusal() const {
    try {
      const WriterLock lock = LockFolder(folder_ / "a/run");
      return "";
    } catch (const InputError& e) {
      return e.what();
    }
  }
};

TEST_F(WriterLockTest, OneAloneHasAFolderUntilItIsDone) {
  {
    const WriterLock first = LockFolder(folder_ / "a/run");
    EXPECT_THAT(Refusal(), HasSubstr("--out: another process is writing to '" + (folder_ / "a/run").string() +
                                     "'; valid: to let it end, or another folder"));
    const WriterLock other = LockFolder(folder_ / "b");
  }
  EXPECT_EQ(Refusal(), "");
}

TEST_F(WriterLockTest, AFolderThatCannotBeIsAnErrorWithItsName) {
  try {
    LockFolder("/proc/none/run");
    FAIL() << "nothing thrown";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("cannot write /proc/none/run: "));
  }
}

}  // namespace
}  // namespace kestrel
