// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <regex>

#include "app/files/explain_command.h"
#include "app/files/file_kinds.h"
#include "app/files/file_reference.h"
#include "app/files/new_command.h"
#include "app/files/schema_command.h"
#include "base/diagnostics.h"
#include "campaign/table/campaign_plan.h"
#include "campaign/tuning/tune_plan.h"
#include "flight/hardware/aircraft.h"
#include "flight/simulated/scenario.h"
#include "tests/support/content.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

namespace fs = std::filesystem;

class Files : public InTemporaryFolder {
 protected:
  fs::path Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
};

void WithoutMeaning(const std::vector<FieldDescription>& fields, const std::string& prefix,
                    std::vector<std::string>& paths) {
  for (const FieldDescription& each : fields) {
    if (each.meaning.empty()) paths.push_back(prefix + each.key);
    WithoutMeaning(each.fields, prefix + each.key + '.', paths);
  }
}

TEST_F(Files, EveryKeyOfEveryKindSaysWhatItMeans) {
  for (const FileKind& kind : FileKinds()) {
    for (const FileKind::Variant& variant : kind.variants) {
      std::vector<std::string> paths;
      WithoutMeaning(variant.fields, "", paths);
      EXPECT_THAT(paths, IsEmpty()) << kind.name << ' ' << variant.name;
    }
  }
}

TEST_F(Files, AKeyIsExplainedWithItsRangeAndItsDefault) {
  const std::string text = ExplainText({.key = "wind.mean_m_s", .kind = ""});
  EXPECT_THAT(text, AllOf(StartsWith("wind.mean_m_s (scenario)\n"),
                          HasSubstr("\n  number from 0 to 20, by default 0\n")));
}

TEST_F(Files, AKeyIsFoundByItsEndAndOneThatManyHaveInAllOfThem) {
  EXPECT_THAT(ExplainText({.key = "mean_m_s", .kind = ""}), StartsWith("wind.mean_m_s (scenario)"));
  EXPECT_THAT(ExplainText({.key = "targets.0.diameter_m", .kind = ""}),
              StartsWith("targets.diameter_m (scenario)"));
  EXPECT_THAT(ExplainText({.key = "criteria.touchdown_error_m.max", .kind = ""}),
              StartsWith("criteria.NAME.max (scenario)"));
  EXPECT_THAT(ExplainText({.key = "seed", .kind = ""}),
              AllOf(HasSubstr("seed (scenario)"), HasSubstr("seed (campaign)")));
  EXPECT_THAT(ExplainText({.key = "seed", .kind = "campaign"}), Not(HasSubstr("(scenario)")));
  EXPECT_THAT(ExplainText({.key = "flight.height_m", .kind = "scenario"}),
              HasSubstr("(scenario with mission: hover"));
}

TEST_F(Files, AKeyThatNoFileHasIsRefusedWithTheNearest) {
  try {
    ExplainText({.key = "wind.mean_ms", .kind = ""});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("no file has a key 'wind.mean_ms'"),
                                HasSubstr("did you mean 'wind.mean_m_s'?")));
  }
}

TEST_F(Files, ANewScenarioOfEachMissionIsValid) {
  const FileKind& kind = FileKindNamed("scenario");
  for (const FileKind::Variant& variant : kind.variants) {
    const fs::path file = Write(variant.name + ".yaml", NewFile(kind, variant));
    // What a mission needs of the world is not the mission's key: a balloon to follow, say.
    try {
      flight::LoadScenario(file.string(), {}, false);
    } catch (const InputError& e) {
      for (const Diagnostic& each : e.diagnostics)
        EXPECT_THAT(each.Text(), Not(HasSubstr("unknown key"))) << variant.name;
    }
  }
  EXPECT_NO_THROW(flight::LoadScenario((folder_ / "landing.yaml").string()));
  EXPECT_NO_THROW(flight::LoadScenario((folder_ / "hover.yaml").string()));
}

TEST_F(Files, ANewCampaignAndANewTuningAreValid) {
  for (const char* name : {"campaign", "tuning"}) {
    const FileKind& kind = FileKindNamed(name);
    const fs::path file = Write(fmt::format("{}.yaml", name), NewFile(kind, kind.variants.front()));
    if (kind.name == "campaign")
      EXPECT_NO_THROW(campaign::LoadCampaign(file));
    else
      EXPECT_NO_THROW(campaign::LoadTune(file));
  }
}

// With the defaults that it shows: each key may be taken out of its comment.
TEST_F(Files, ANewFileOfAnAircraftIsValidWithAllItsKeys) {
  const FileKind& kind = FileKindNamed("aircraft");
  const std::string text =
      std::regex_replace("\n" + NewFile(kind, kind.variants.front()), std::regex("\n#(?! )"), "\n");
  EXPECT_THAT(text, HasSubstr("\nsafety:"));
  Mistakes mistakes;
  flight::LoadAircraft(Write("aircraft.yaml", text).string(), {}, mistakes);
  EXPECT_THAT(mistakes.Texts(), IsEmpty());
}

TEST_F(Files, NoFileIsWrittenOver) {
  const fs::path file = Write("mine.yaml", "mine\n");
  EXPECT_THROW(NewCommand({.kind = "campaign", .file = file, .variants = {}}), InputError);
  EXPECT_EQ(Content(file), "mine\n");
  EXPECT_THROW(NewCommand({.kind = "campaign", .file = "", .variants = {{"mission", "hover"}}}), InputError);
  EXPECT_THROW(NewCommand({.kind = "scenario", .file = "", .variants = {{"mission", "hovr"}}}), InputError);
}

// Python's jsonschema is what editors' own validators are like, and knows nothing of our reader.
TEST_F(Files, TheSchemasTakeEveryFileOfOursAndRefuseWhatTheReaderRefuses) {
  for (const FileKind& kind : FileKinds()) Write(kind.name + ".json", JsonSchema(kind));
  Write("bad_key.yaml", "mission: hover\nflight: {hight_m: 4}\n");
  Write("bad_value.yaml", "mission: hover\nwind: {mean_m_s: 21}\n");
  Write("bad_type.yaml", "mission: hover\nwind: {turbulence: 3}\n");
  Write("other_mission.yaml", "mission: pose\nflight: {gains: {}}\n");
  Write("check.py", R"(import glob, json, sys, yaml
from jsonschema import Draft7Validator

source = sys.argv[1]
def wrong(kind, file):
    schema = json.load(open(kind + '.json'))
    Draft7Validator.check_schema(schema)
    return [e.message for e in Draft7Validator(schema).iter_errors(yaml.safe_load(open(file)))]

kinds = {'scenario': 'scenarios/*/*.yaml', 'campaign': 'scenarios/*/campaigns/*.yaml',
         'tuning': 'scenarios/*/tunings/*.yaml', 'vehicle': 'models/vehicles/*/*.yaml',
         'world': 'models/worlds/*/*.yaml', 'pad': 'models/pads/*/*.yaml', 'camera': 'models/cameras/*.yaml'}
for kind, pattern in kinds.items():
    files = glob.glob(source + '/' + pattern)
    if not files:
        print('no files of', kind)
    for file in files:
        text = open(file).read()
        if kind == 'camera' and 'width_px' not in text:
            continue  # of another program
        if kind == 'scenario' and 'mission:' not in text:
            continue  # gains
        for each in wrong(kind, file):
            print(file + ': ' + each)
for bad in ['bad_key', 'bad_value', 'bad_type', 'other_mission']:
    if not wrong('scenario', bad + '.yaml'):
        print(bad, 'is taken')
)");
  const Ended checked = Shell(folder_, "python3 check.py " KESTREL_SOURCE_DIR " 2>&1");
  EXPECT_EQ(checked.status, 0);
  EXPECT_EQ(checked.out, "");
}

// A page that is out of date is written anew by `kestrel reference files`.
TEST_F(Files, TheReferenceIsWhatTheProgramPrints) {
  EXPECT_EQ(FileReference(), Content(fs::path(KESTREL_SOURCE_DIR) / "docs" / "reference" / "files.md"))
      << "kestrel reference files > docs/reference/files.md";
}

}  // namespace
}  // namespace kestrel::app
