// SPDX-License-Identifier: Apache-2.0
#include "base/html/html.h"

#include <gmock/gmock.h>

#include <stdexcept>

#include "base/file/data_folders.h"

namespace kestrel {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// The test vectors of RFC 4648, section 10, and a byte that is none of text.
TEST(Html, Base64IsThatOfItsStandard) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foo"), "Zm9v");
  EXPECT_EQ(Base64("foob"), "Zm9vYg==");
  EXPECT_EQ(Base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(Base64("\xff\xfe\xfd"), "//79");
}

TEST(Html, TextIsNoMarkup) {
  EXPECT_EQ(Escaped("a<b>&\"c\" 'd'"), "a&lt;b&gt;&amp;&quot;c&quot; 'd'");
  EXPECT_EQ(InScript(R"({"a":"</script><!--"})"), R"({"a":"\u003c/script>\u003c!--"})");
}

// What comes in may look like the name of a part.
TEST(Html, PartsAreNotLookedThroughAgain) {
  EXPECT_EQ(Filled("1{{a}}2{{b}}3", {{"a", "{{b}}"}, {"b", "x"}}), "1{{b}}2x3");
  EXPECT_EQ(Filled("none {{ open", {}), "none {{ open");
  EXPECT_THROW(Filled("{{a}}", {}), std::out_of_range);
}

TEST(Html, ScriptsAreOneStrictOne) {
  EXPECT_THAT(PageScript({"base/html/web/dom.js"}), StartsWith("\"use strict\";\n// SPDX"));
  EXPECT_THROW(PageScript({"base/html/web/none.js"}), std::runtime_error);
}

TEST(Html, ALibraryThatIsNotThereOrAnotherIsToldOf) {
  const auto message = [](const PageLibrary& library) -> std::string {
    try {
      LibraryFile(library);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(message({"/none/there.js", "libjs-there", {}}), HasSubstr("apt-get install libjs-there"));
  const auto there = DataFile("base/html/web/dom.js");
  EXPECT_THAT(message({there, "libjs-there", {"SPDX", "version 7"}}), HasSubstr("'version 7'"));
  EXPECT_EQ(message({there, "libjs-there", {"SPDX"}}), "");
  EXPECT_EQ(message(ChartLibrary()), "");
}

}  // namespace
}  // namespace kestrel
