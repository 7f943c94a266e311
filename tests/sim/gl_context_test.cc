// SPDX-License-Identifier: Apache-2.0
#include "sim/gl_context.h"

#include <gmock/gmock.h>

#include <stdexcept>
#include <thread>

namespace kestrel {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(GlContext, NamesBackendRendererAndVersion) {
  EXPECT_THAT(MakeGlContext("osmesa")->RendererName(), AllOf(StartsWith("osmesa: "), HasSubstr(", Mesa ")));
  EXPECT_THAT(MakeGlContext("egl")->RendererName(), AllOf(StartsWith("egl: "), HasSubstr(", Mesa ")));
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

TEST(GlContext, EachThreadHasItsOwnOfEitherBackend) {
  const auto mine = MakeGlContext("osmesa");
  const std::string name = mine->RendererName();
  std::string other;
  std::thread([&] { other = MakeGlContext("egl")->RendererName(); }).join();
  EXPECT_THAT(other, StartsWith("egl: "));
  EXPECT_EQ(mine->RendererName(), name);
}

}  // namespace
}  // namespace kestrel
