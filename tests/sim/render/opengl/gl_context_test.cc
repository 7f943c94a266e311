// SPDX-License-Identifier: Apache-2.0
#include "sim/render/opengl/gl_context.h"

#include <gmock/gmock.h>

#include <stdexcept>
#include <thread>

namespace kestrel::sim {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(GlContext, NamesBackendRendererAndVersion) {
  EXPECT_THAT(MakeGlContext("osmesa")->RendererName(), AllOf(StartsWith("osmesa: "), HasSubstr(", Mesa ")));
}

// A process draws with one backend, so EGL is tried in another, which starts the test anew.
TEST(GlContext, EglWorksWithoutAGraphicsCard) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        fputs(MakeGlContext("egl")->RendererName().c_str(), stderr);
        exit(0);
      },
      ::testing::ExitedWithCode(0), "egl: .*Mesa");
}

TEST(GlContext, RefusesASecondBackendInOneProcess) {
  MakeGlContext("osmesa");
  try {
    MakeGlContext("egl");
    FAIL() << "two backends in one process";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("osmesa already"), HasSubstr("egl needs a process of its own")));
  }
  EXPECT_THAT(MakeGlContext("auto")->RendererName(), StartsWith("osmesa: "));
}

TEST(GlContext, AutoPrefersTheBackendThatNeedsNoGraphicsCard) {
  EXPECT_THAT(MakeGlContext("auto")->RendererName(), StartsWith("osmesa: "));
}

TEST(GlContext, RefusesAnUnknownBackendWithTheValidNames) {
  try {
    MakeGlContext("glx");
    FAIL() << "an unknown backend was accepted";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(),
                AllOf(HasSubstr("\"glx\""), HasSubstr("auto"), HasSubstr("osmesa"), HasSubstr("egl")));
  }
}

TEST(GlContext, EachThreadHasItsOwn) {
  const auto mine = MakeGlContext("osmesa");
  const std::string name = mine->RendererName();
  std::string other;
  std::thread([&] { other = MakeGlContext("osmesa")->RendererName(); }).join();
  EXPECT_EQ(other, name);
  EXPECT_EQ(mine->RendererName(), name);
}

}  // namespace
}  // namespace kestrel::sim
