// SPDX-License-Identifier: Apache-2.0
#include "base/user_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/temporary_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class UserFileTest : public InTemporaryFolder {};

TEST_F(UserFileTest, AFileIsReadToItsEnd) {
  for (const std::size_t size : {0, 1, 4096, 100'000}) {
    const std::string bytes(size, 'x');
    std::ofstream(folder_ / "file") << bytes;
    const FileContent content = ReadUserFile(folder_ / "file", 100'000);
    EXPECT_THAT(content.error, IsEmpty());
    EXPECT_EQ(content.bytes, bytes);
    EXPECT_TRUE(IsFile(folder_ / "file"));
  }
  EXPECT_THAT(ReadUserFile("/proc/self/status", 1 << 20).bytes,
              HasSubstr("VmPeak"));  // which says it has none
}

TEST_F(UserFileTest, WhatIsLargerThanSuchAFileIsNotRead) {
  std::ofstream(folder_ / "file") << std::string(1000, 'x');
  EXPECT_THAT(ReadUserFile(folder_ / "file", 999).error, HasSubstr("is too large; valid: up to 999 bytes"));
  EXPECT_THAT(ReadUserFile(folder_ / "file", 999).bytes, IsEmpty());
  EXPECT_THAT(ReadUserFile(folder_ / "file", 1000).error, IsEmpty());
  fs::resize_file(folder_ / "file", std::uintmax_t{20} << 30);
  EXPECT_THAT(ReadUserFile(folder_ / "file", kMaxDataBytes).error, HasSubstr("is too large"));
  EXPECT_THAT(ReadUserFile("/proc/self/status", 10).error, HasSubstr("is too large"));
}

TEST_F(UserFileTest, WhatIsNoRegularFileIsNotReadAndNamed) {
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  fs::create_symlink("loop", folder_ / "loop");
  const fs::path long_name = folder_ / std::string(300, 'n');
  for (const auto& [file, error, said] :
       {std::tuple{fs::path("/dev/zero"), "is a device or a pipe, not a file", "'/dev/zero' is a device"},
        {folder_ / "pipe", "is a device or a pipe, not a file", "pipe' is a device or a pipe"},
        {folder_, "is a folder, not a file", "is a folder, not a file"},
        {folder_ / "none", "cannot be read: No such file or directory", "there is no file '"},
        {folder_ / "loop", "cannot be read: Too many levels of symbolic links",
         "loop' cannot be read: Too many"},
        {long_name, "cannot be read: File name too long", "n' cannot be read: File name too long"}}) {
    EXPECT_EQ(ReadUserFile(file, 1 << 20).error, error);
    EXPECT_FALSE(IsFile(file));
    EXPECT_THAT(NoSuchFile(file), HasSubstr(said));
  }
}

}  // namespace
}  // namespace kestrel
