// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/scenario.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "base/diagnostics.h"
#include "base/yaml/yaml_fields.h"
#include "flight/simulated/possible_metrics.h"
#include "records/telemetry/metrics.h"
#include "scenarios/hover/hover.h"
#include "scenarios/landing/landing.h"
#include "tests/support/diagnostic_texts.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

// A folder for files of scenarios and, where a test asks for it, a copy of the models that it may break.
class ScenarioTest : public InTemporaryFolder {
 protected:
  void TearDown() override {
    unsetenv("KESTREL_ROOT");
    InTemporaryFolder::TearDown();
  }
  std::string Write(const fs::path& file, const std::string& text) const {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << text;
    return (folder_ / file).string();
  }
  // From here on the models and scenarios are those of a copy in the folder.
  void CopyRoot() const {
    for (const char* part : {"models", "scenarios"})
      fs::copy(Root() / part, folder_ / part, fs::copy_options::recursive);
    setenv("KESTREL_ROOT", folder_.c_str(), 1);
  }
  void Replace(const fs::path& file, const std::string& what, const std::string& with) const {
    std::ifstream in(folder_ / file);
    std::string text(std::istreambuf_iterator<char>(in), {});
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    Write(file, text.replace(at, what.size(), with));
  }
};

std::vector<std::string> Refusal(const std::string& name_or_file,
                                 const std::vector<std::string>& overrides = {}) {
  try {
    LoadScenario(name_or_file, overrides);
  } catch (const InputError& e) {
    return Texts(e);
  }
  return {};
}

TEST_F(ScenarioTest, ALandingThatWouldSinkFasterNearThePadThanAboveIsRefused) {
  const std::string file = Write("mine.yaml", "mission: landing\nflight:\n  descent_m_s: 0.3\n");
  EXPECT_THAT(Refusal(file, {"flight.commit_sink_m_s=0.4"}),
              ElementsAre(HasSubstr("flight.commit_sink_m_s: 0.4 is above flight.descent_m_s = 0.3")));
  EXPECT_THAT(Refusal(file, {"flight.commit_sink_m_s=0.3"}), IsEmpty());
}

TEST_F(ScenarioTest, EveryScenarioIsValidAndItsResolvedTextReadsBackTheSame) {
  const std::vector<std::string> names = ScenarioNames();
  EXPECT_THAT(names, ::testing::IsSupersetOf({"hover", "landing", "pose", "pose_high"}));
  for (const std::string& name : names) {
    const LoadedScenario loaded = LoadScenario(
        name, {"seed=18446744073709551615", "wind.mean_m_s=1.2345678901234567", "duration_s=12.5",
               "start.offset_m=[0.1, -0.2]", "criteria.fix_share={min: 0.3, max: 0.99}"});
    const std::string text = ToYaml(loaded.scenario);
    const LoadedScenario again = LoadScenario(Write("again.yaml", text));
    EXPECT_EQ(ToYaml(again.scenario), text);
    EXPECT_EQ(again.scenario.name, name);  // though the file has another
    EXPECT_EQ(again.scenario.seed, UINT64_MAX);
    EXPECT_EQ(again.simulator.wind.mean_m_s, 1.2345678901234567);
    EXPECT_EQ(again.simulator.start.offset_m, Eigen::Vector2d(0.1, -0.2));
    EXPECT_EQ(&again.scenario.flight.type(), &loaded.scenario.flight.type());
    ASSERT_TRUE(again.scenario.criteria.count("fix_share"));
    EXPECT_EQ(*again.scenario.criteria.at("fix_share").max, 0.99);
  }
}

TEST_F(ScenarioTest, TheResolvedTextHoldsEveryValue) {
  const std::string text = ToYaml(LoadScenario("landing").scenario);
  for (const char* key :
       {"seed:", "duration_s:", "vehicle: pelican", "world: airfield", "camera: thesis_6mm",
        "blind_m:", "gps_rate_hz:", "latency_s:", "lambda_per_s:", "give_up_s:", "touchdown_error_m:"}) {
    EXPECT_THAT(text, HasSubstr(key));
  }
}

TEST_F(ScenarioTest, AFileNeedsNothingButItsMission) {
  const LoadedScenario loaded = LoadScenario(Write("my_flight.yaml", "mission: hover\n"));
  EXPECT_EQ(loaded.scenario.name, "my_flight");
  EXPECT_EQ(loaded.scenario.flight.As<scenarios::HoverFlight>()->height_m, scenarios::HoverFlight{}.height_m);
  EXPECT_EQ(std::get<sim::MultirotorParameters>(loaded.simulator.vehicle).mass_kg, 1.3);
  EXPECT_EQ(vision::WidthPx(loaded.simulator.camera), 640);
  EXPECT_EQ(loaded.simulator.autopilot.roll.gain, 0.80);
  EXPECT_EQ(loaded.simulator.scene.pad.size_m, Eigen::Vector2d(1.19, 0.91));
  EXPECT_NEAR(loaded.pad.length_m, 1.19, 1e-12);
  EXPECT_TRUE(
      loaded.scenario.flight->Make(PartsOf(loaded, sim::MakeModel(loaded.simulator.scene, false).get())));
}

TEST_F(ScenarioTest, OverridesReachTheSimulatorAndTheFlight) {
  const LoadedScenario loaded =
      LoadScenario("landing", {"flight.blind_m=0.5", "seed=42", "image.latency_s=0.2", "occlusion.share=0.7",
                               "pad.yaw_deg=33", "mount.pitch_deg=10", "sensors.gps_horizontal_m.white=0.7"});
  EXPECT_EQ(loaded.scenario.flight.As<scenarios::LandingFlight>()->blind_m, 0.5);
  EXPECT_EQ(loaded.simulator.seed, 42u);
  EXPECT_EQ(loaded.simulator.image.latency_s, 0.2);
  EXPECT_EQ(loaded.simulator.occlusion.share, 0.7);
  EXPECT_EQ(loaded.simulator.scene.pad_yaw_deg, 33);
  EXPECT_EQ(loaded.simulator.mount.pitch_deg, 10);
  EXPECT_EQ(loaded.simulator.sensors.gps_horizontal_m.white, 0.7);
}

TEST_F(ScenarioTest, AListTakesAnOverrideOfOneElementOnlyWhereItIsGiven) {
  const std::string file = Write("a.yaml", "mission: pose\npad: {position_m: [1, 2]}\n");
  EXPECT_EQ(LoadScenario(file, {"pad.position_m.1=-4"}).simulator.scene.pad_position_m,
            Eigen::Vector2d(1, -4));
}

TEST_F(ScenarioTest, EveryMistakeIsNamedWithFileLineKeyAndWhatWouldBeValid) {
  const std::string file = Write("bad.yaml",
                                 "mission: landing\n"
                                 "flight: {blind_m: 7}\n"
                                 "durations_s: 30\n"
                                 "wind:\n"
                                 "  mean_m_s: strong\n"
                                 "  turbulance: true\n"
                                 "start: {height_m: -3}\n"
                                 "render: {backend: opengl}\n");
  const auto mistakes = Refusal(file, {"image.rate_hz=0", "seed=-1"});
  ASSERT_EQ(mistakes.size(), 8u);
  EXPECT_THAT(mistakes,
              Contains(AllOf(StartsWith(file + ":2: flight.blind_m: 7"), HasSubstr("valid: 0 to 2"))));
  EXPECT_THAT(mistakes, Contains(file + ":3: durations_s: unknown key; did you mean 'duration_s'?"));
  EXPECT_THAT(mistakes,
              Contains(AllOf(StartsWith(file + ":5: wind.mean_m_s: 'strong'"), HasSubstr("0 to 20"))));
  EXPECT_THAT(mistakes, Contains(file + ":6: wind.turbulance: unknown key; did you mean 'turbulence'?"));
  EXPECT_THAT(mistakes,
              Contains(AllOf(StartsWith(file + ":7: start.height_m: -3"), HasSubstr("valid: 0.3 to 600"))));
  EXPECT_THAT(mistakes,
              Contains(AllOf(StartsWith(file + ":8: render.backend: 'opengl'"), HasSubstr("osmesa, egl"))));
  EXPECT_THAT(mistakes,
              Contains(AllOf(StartsWith("--set image.rate_hz=0: image.rate_hz"), HasSubstr("0.5 to 500"))));
  EXPECT_THAT(mistakes, Contains(StartsWith("--set seed=-1: seed")));
}

TEST_F(ScenarioTest, WhatIsWrongWithAFlightAsAWholeIsToldWithTheLineOfItsKey) {
  const std::string file = Write("fuzzy.yaml",
                                 "mission: landing\n"
                                 "flight:\n"
                                 "  height_law: fuzzy\n"
                                 "  commit_sink_m_s: 0.9\n"
                                 "  fuzzy:\n"
                                 "    controller:\n"
                                 "      rules:\n"
                                 "        - if error is high then descent is fast\n"
                                 "        - if eror is near then descent is slow\n");
  EXPECT_THAT(Refusal(file),
              ElementsAre(StartsWith(file + ":4: flight.commit_sink_m_s: 0.9 is above"),
                          file + ":9: flight.fuzzy.controller.rules.1: 'eror' is not an input; did you mean "
                                 "'error'?"));
  EXPECT_THAT(Refusal("landing", {"flight.fuzzy.controller.rules=[]"}),
              ElementsAre(StartsWith("--set flight.fuzzy.controller.rules=[]: flight.fuzzy.controller.rules: "
                                     "there is no rule")));
}

TEST_F(ScenarioTest, ALandscapeIsAsItsWorldHasItButForTheScenariosOwnWords) {
  const LoadedScenario plain = LoadScenario("pose", {"world=winter_cloudy"});
  const LoadedScenario own = LoadScenario("pose", {"world=winter_cloudy", "landscape.haze_m=1234"});
  ASSERT_TRUE(plain.simulator.scene.landscape);
  ASSERT_TRUE(own.simulator.scene.landscape);
  EXPECT_EQ(own.simulator.scene.landscape->haze_m, 1234);
  EXPECT_NE(plain.simulator.scene.landscape->haze_m, 1234);
  EXPECT_EQ(own.simulator.scene.landscape->snow_share, plain.simulator.scene.landscape->snow_share);
  EXPECT_GT(plain.simulator.scene.landscape->snow_share, 0);
  const std::string resolved = ToYaml(own.scenario);
  EXPECT_EQ(ToYaml(LoadScenario(Write("again.yaml", resolved)).scenario), resolved);
}

TEST_F(ScenarioTest, WhatDoesNotGoWithALandscapeIsRefused) {
  const auto refusal = [](const std::vector<std::string>& overrides) {
    try {
      LoadScenario("pose", overrides);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal({"world=summer_sun", "render.backend=egl"}), HasSubstr("render.backend: 'egl'"));
  EXPECT_THAT(refusal({"landscape.haze_m=3000"}), AllOf(HasSubstr("airfield"), HasSubstr("summer_sun")));
  EXPECT_THAT(refusal({"world=summer_sun", "landscape.haze=3"}), HasSubstr("did you mean 'haze_m'?"));
  EXPECT_THAT(refusal({"pad.name=none"}), HasSubstr("pad.name: none"));
}

TEST_F(ScenarioTest, APadOnUnevenGroundLeansByTheSeedAndNotOnADeck) {
  const auto lean = [](const std::vector<std::string>& overrides) {
    return LoadScenario("landing", overrides).simulator.scene.pad_lean_deg;
  };
  EXPECT_EQ(lean({}), Eigen::Vector2d(0, 0));
  EXPECT_NE(lean({"pad.uneven_deg=2", "seed=3"}), lean({"pad.uneven_deg=2", "seed=4"}));
  EXPECT_EQ(lean({"pad.uneven_deg=4", "seed=3"}), Eigen::Vector2d(2 * lean({"pad.uneven_deg=2", "seed=3"})));
  EXPECT_THAT(
      Refusal("landing_ship", {"pad.uneven_deg=2"}),
      ElementsAre(HasSubstr("pad.uneven_deg: 2, but a deck is level at rest; valid: 0, or deck: null")));
}

TEST_F(ScenarioTest, AMissingFileIsNamed) {
  const std::string file = (folder_ / "none.yaml").string();
  EXPECT_THAT(Refusal(file), ElementsAre(AllOf(StartsWith(file), HasSubstr("No such file"))));
}

TEST_F(ScenarioTest, NamesThatAreNotKnownGetTheNearest) {
  EXPECT_THAT(Refusal("landin"), ElementsAre(AllOf(HasSubstr("there is no scenario 'landin'"),
                                                   HasSubstr("did you mean 'landing'?"))));
  EXPECT_THAT(Refusal("xyzzy"),
              ElementsAre(AllOf(HasSubstr("valid: "), HasSubstr(" hover,"), HasSubstr(" landing,"))));
  const auto one = [](const char* override_) { return Refusal("pose", {override_}); };
  EXPECT_THAT(one("mission=landnig"),
              ElementsAre(AllOf(HasSubstr("mission"), HasSubstr("did you mean 'landing'?"))));
  EXPECT_THAT(one("vehicle=pelikan"),
              ElementsAre(AllOf(HasSubstr("no vehicle 'pelikan'"), HasSubstr("did you mean 'pelican'?"))));
  EXPECT_THAT(one("world=airfeld"),
              ElementsAre(AllOf(HasSubstr("no world 'airfeld'"), HasSubstr("did you mean 'airfield'?"))));
  EXPECT_THAT(one("camera=thesis6mm"), ElementsAre(AllOf(HasSubstr("no camera 'thesis6mm'"),
                                                         HasSubstr("did you mean 'thesis_6mm'?"))));
  EXPECT_THAT(one("pad.name=hellipad"),
              ElementsAre(AllOf(HasSubstr("no pad 'hellipad'"), HasSubstr("did you mean 'helipad'?"))));
  EXPECT_THAT(one("criteria.touchdown_eror_m={max: 1}"),
              ElementsAre(HasSubstr("did you mean 'touchdown_error_m'?")));
}

TEST_F(ScenarioTest, MistakesInTheNamesComeTogether) {
  const auto mistakes =
      Refusal("pose", {"vehicle=a", "world=b", "camera=c", "pad.name=d", "criteria.e={min: 1}"});
  EXPECT_EQ(mistakes.size(), 5u);
}

TEST_F(ScenarioTest, AMissionMustBeGiven) {
  EXPECT_THAT(Refusal(Write("a.yaml", "seed: 3\n")),
              Contains(AllOf(HasSubstr("mission"), HasSubstr("must be given"))));
}

TEST_F(ScenarioTest, ACriterionNeedsALimit) {
  EXPECT_THAT(
      Refusal("hover", {"criteria={settle_s: {max: 15}, touchdown_error_m: {max: 0.1}}"}),
      ElementsAre(AllOf(HasSubstr("criteria.touchdown_error_m: a flight of this scenario, of the mission "
                                  "'hover', has no 'touchdown_error_m'"),
                        HasSubstr("hold_vertical_rmse_m"))));
  EXPECT_THAT(Refusal("hover", {"image.rate_hz=0.5", "duration_s=16"}),
              ElementsAre(AllOf(HasSubstr("image.rate_hz: 0.5 gives 8 images in duration_s = 16"),
                                HasSubstr("at least 0.625"))));
  LoadScenario("hover", {"image.rate_hz=0.5", "duration_s=20"});
  LoadScenario("hover", {"image.rate_hz=0.5", "duration_s=16", "criteria={}"});  // it is not judged
  EXPECT_THAT(Refusal("pose", {"criteria.fix_share={}"}),
              ElementsAre(HasSubstr("criteria.fix_share: has no limit")));
}

TEST_F(ScenarioTest, AMetricsFormerNameIsReadWithANotice) {
  testing::internal::CaptureStderr();
  const Scenario s = LoadScenario("hover", {"criteria={greatest_tilt_deg: {max: 33}}"}).scenario;
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("greatest_tilt_deg: is called 'max_tilt_deg' now"));
  ASSERT_TRUE(s.criteria.contains("max_tilt_deg"));
  EXPECT_EQ(*s.criteria.at("max_tilt_deg").max, 33);
  EXPECT_EQ(s.criteria.size(), 1u);
}

TEST_F(ScenarioTest, ACriterionThatNoFlightCanMeetIsRefusedWhereItIsWritten) {
  const std::string file = Write("never.yaml", R"(mission: pose
criteria:
  fix_x_rmse_m: {max: -0.1}
  fix_share: {min: 1.5}
  longest_loss_s: {min: 3, max: 2}
  touchdown_error_m: {max: 1}
  max_tilt_deg: {max: 200}
)");
  EXPECT_THAT(
      Refusal(file),
      ElementsAre(AllOf(HasSubstr("never.yaml:4: criteria.fix_share.min: 1.5 is met by no flight"),
                        HasSubstr("never above 1; valid: 0 to 1")),
                  AllOf(HasSubstr("never.yaml:3: criteria.fix_x_rmse_m.max: -0.1 is met by no flight"),
                        HasSubstr("never below 0; valid: 0 or more")),
                  HasSubstr("never.yaml:5: criteria.longest_loss_s: min = 3 is above max = 2"),
                  HasSubstr("never.yaml:6: criteria.touchdown_error_m: a flight of this scenario")));
}

TEST_F(ScenarioTest, ACameraMustBeWhole) {
  CopyRoot();
  const std::string file = (folder_ / "models/cameras/thesis_6mm.yaml").string();
  Replace("models/cameras/thesis_6mm.yaml", "fy_px: 810.81", "fy_px: 800");
  EXPECT_THAT(Refusal("pose"), IsEmpty());
  Replace("models/cameras/thesis_6mm.yaml", "fx_px: 810.81\n", "");
  EXPECT_THAT(Refusal("pose"),
              Contains(AllOf(HasSubstr(file), HasSubstr("fx_px"), HasSubstr("must be given"))));
}

TEST_F(ScenarioTest, AnyCameraWillDoThatSeesAlongItsAxis) {
  CopyRoot();
  EXPECT_THAT(Refusal("landing", {"camera=fisheye"}), IsEmpty());
  Replace("models/cameras/fisheye.yaml", "cx_px: 319.5", "cx_px: -100");
  EXPECT_THAT(Refusal("landing", {"camera=fisheye"}),
              ElementsAre(AllOf(HasSubstr("camera=fisheye: camera: 'fisheye'"), HasSubstr("(-100, "),
                                HasSubstr("does not see along its own optical axis"))));
}

TEST_F(ScenarioTest, TheSensorsPartsAndFaultsReadBackTheSame) {
  const std::string file = Write("a.yaml", R"(
mission: landing
mount:
  vibration: [{from_hz: 60, until_hz: 90, rms_deg: 0.1}, {rms_mm: 0.2}]
image:
  latency_s: 0.06
  exposure: {time_s: 0.004, line_s: 0.00003, samples: 6}
  auto_exposure: {target_grey: 110, lag_s: 0.4, longest_s: 0.015}
  lens: {cos_power: 4, vignetting: [-0.2, 0.1, 0], defocus_px: 0.6, defocus: disc, rim_px: 300}
  full_well_e: 12000
  gamma: 2.2
  jpeg_quality: 80
  scatter: {defocus_px: 0.4}
  faults:
    - {type: slow, from_s: 4, rate_hz: 3}
    - {type: intermittent, loss: 0.2, probability: 0.5}
    - {type: delayed, rate_per_min: 3, length_s: 2, delay_s: 0.1}
)");
  const LoadedScenario loaded = LoadScenario(file);
  const sim::ImageParameters& image = loaded.simulator.image;
  EXPECT_EQ(image.exposure.samples, 6);
  EXPECT_EQ(image.lens.defocus, "disc");
  EXPECT_EQ(image.scatter.defocus_px, 0.4);
  ASSERT_EQ(image.faults.size(), 3u);
  EXPECT_EQ(image.faults[0].rate_hz, 3);
  EXPECT_EQ(image.faults[1].loss, 0.2);
  EXPECT_EQ(image.faults[2].delay_s, 0.1);
  ASSERT_EQ(loaded.simulator.mount.vibration.size(), 2u);
  EXPECT_EQ(loaded.simulator.mount.vibration[1].rms_mm, 0.2);
  const std::string text = ToYaml(loaded.scenario);
  EXPECT_EQ(ToYaml(LoadScenario(Write("again.yaml", text)).scenario), text);
}

TEST_F(ScenarioTest, AnImageMustHaveTimeToBeExposedAndReadOut) {
  const auto one = [](std::vector<std::string> overrides) { return Refusal("pose", overrides); };
  EXPECT_THAT(
      one({"image.exposure.time_s=0.06", "image.latency_s=0.1"}),
      ElementsAre(AllOf(HasSubstr("image.exposure.time_s"), HasSubstr("0.06 s"), HasSubstr("0.05 s"))));
  EXPECT_THAT(one({"image.exposure.line_s=0.0002", "image.latency_s=0.1"}),
              ElementsAre(AllOf(HasSubstr("image.exposure.line_s"), HasSubstr("480 rows take up to 0.0958 s"),
                                HasSubstr("0.000104"))));
  EXPECT_THAT(one({"image.exposure={time_s: 0.02, line_s: 0.00005}", "image.latency_s=0.02"}),
              ElementsAre(AllOf(HasSubstr("image.latency_s"), HasSubstr("valid: 0.021975 or more"))));
  EXPECT_THAT(one({"image.exposure={time_s: 0.02, line_s: 0.00005}", "image.latency_s=0.021975"}), IsEmpty());
  // what scatter and auto-exposure may make of it counts
  EXPECT_THAT(one({"image.exposure.time_s=0.03", "image.scatter.time_s=0.03"}),
              ElementsAre(HasSubstr("image.exposure.time_s")));
  EXPECT_THAT(one({"image.exposure.time_s=0.01", "image.auto_exposure={target_grey: 90, longest_s: 0.06}"}),
              ElementsAre(HasSubstr("image.auto_exposure.longest_s")));
  EXPECT_THAT(one({"image.auto_exposure={target_grey: 90, longest_s: 0.06}"}),
              IsEmpty());  // no time to change
  EXPECT_THAT(one({"image.auto_exposure={target_grey: 90, shortest_s: 0.02, longest_s: 0.01}"}),
              ElementsAre(AllOf(HasSubstr("image.auto_exposure.longest_s"), HasSubstr("not above"))));
}

TEST_F(ScenarioTest, AnExposureThatDoesNotFitIsReportedBesideOtherMistakes) {
  const auto mistakes =
      Refusal("pose", {"image.exposure.time_s=0.06", "camera=none", "image.gain=0", "world=x"});
  EXPECT_EQ(mistakes.size(), 4u);
  EXPECT_THAT(mistakes, Contains(AllOf(HasSubstr("image.exposure.time_s"), HasSubstr("0.06 s"))));
}

TEST_F(ScenarioTest, ALensThatLetsNoLightThroughIsRefused) {
  EXPECT_THAT(Refusal("pose", {"image.lens.rim_px=1"}),
              ElementsAre(AllOf(HasSubstr("image.lens.rim_px: 1 leaves light to 4 of 307200 pixels"),
                                HasSubstr("(319.5, 239.5)"))));
  EXPECT_THAT(Refusal("pose", {"image.lens.reflection_deg=80"}),
              ElementsAre(AllOf(HasSubstr("image.lens.reflection_deg: 80 leaves light to 0 of"))));
  EXPECT_THAT(Refusal("pose", {"image.lens.rim_px=100", "image.lens.reflection_deg=5"}), IsEmpty());
}

TEST_F(ScenarioTest, AFaultMustBeOneAndHaveItsOwnKeysAlone) {
  const auto one = [](const std::string& fault) { return Refusal("pose", {"image.faults=[" + fault + "]"}); };
  EXPECT_THAT(one("{from_s: 3}"),
              ElementsAre(AllOf(HasSubstr("image.faults.0.type"), HasSubstr("must be given"))));
  EXPECT_THAT(one("{type: stock}"),
              ElementsAre(AllOf(HasSubstr("image.faults.0.type"), HasSubstr("did you mean 'stuck'?"))));
  EXPECT_THAT(one("{type: off, delay_s: 2}"),
              ElementsAre(AllOf(HasSubstr("image.faults.0.delay_s"), HasSubstr("unknown key"))));
  EXPECT_THAT(one("{type: off}, {type: off, from_s: 5, until_s: 5}"),
              ElementsAre(AllOf(HasSubstr("image.faults.1.until_s"), HasSubstr("not after from_s = 5"))));
  EXPECT_THAT(one("{type: slow, rate_hz: 20}"),
              ElementsAre(AllOf(HasSubstr("image.faults.0.rate_hz"), HasSubstr("not slower"))));
  EXPECT_THAT(one("{type: slow, rate_hz: 19}, {type: delayed, delay_s: 1}, {type: intermittent, loss: 0.9}"),
              IsEmpty());
  EXPECT_THAT(Refusal("pose", {"mount.vibration=[{from_hz: 90, until_hz: 60}]"}),
              ElementsAre(AllOf(HasSubstr("mount.vibration.0.until_hz"), HasSubstr("below from_hz = 90"))));
}

TEST_F(ScenarioTest, AMissionThatTellsItsTargetByColourNeedsAColourImage) {
  for (const char* mission : {"follow", "avoid"}) {
    EXPECT_THAT(
        Refusal(mission, {"image.colour=false"}),
        ElementsAre(AllOf(HasSubstr("image.colour: false"), HasSubstr(mission), HasSubstr("valid: true"))));
  }
}

TEST_F(ScenarioTest, ATargetMovesInOneWayAndNotThroughTheGround) {
  const auto one = [](const std::string& target) { return Refusal("follow", {"targets=[" + target + "]"}); };
  EXPECT_THAT(one("{position_m: [5, 0, 4], string_m: 3}, {position_m: [5, 0, 0.25]}, {roam_m_s: 1}"),
              IsEmpty());
  for (const char* two : {"{velocity_m_s: [1, 0, 0], string_m: 1}", "{string_m: 1, roam_m_s: 1}",
                          "{velocity_m_s: [0, 0, -1], roam_m_s: 1}"}) {
    EXPECT_THAT(one(std::string("{}, ") + two),
                ElementsAre(AllOf(HasSubstr("targets[1]: moves in several ways"),
                                  HasSubstr("one of velocity_m_s, string_m and roam_m_s"))));
  }
  EXPECT_THAT(one("{position_m: [5, 0, 4], diameter_m: 1, string_m: 3.7}"),
              ElementsAre(AllOf(HasSubstr("targets[0].position_m"), HasSubstr("0.2 m into the ground"),
                                HasSubstr("from 4.2 m"))));
}

TEST_F(ScenarioTest, AvoidingAsksNoMoreThanTheAutopilotGives) {
  const std::string text =
      "mission: avoid\nimage: {colour: true}\npad: {name: none}\nmount: {pitch_deg: 90}\n";
  const std::string file = Write("a.yaml", text +
                                               "flight:\n"
                                               "  speed_m_s: 12\n"
                                               "  avoidance:\n"
                                               "    acceleration_m_s2: 15\n"
                                               "    max_bearing_deg: 60\n"
                                               "    hold: {yaw_rate_limit_deg_s: 170, bearing_deg: 70}\n"
                                               "  marks: []\n");
  const auto mistakes = Refusal(file);
  EXPECT_EQ(mistakes.size(), 5u);
  const auto refused = [&](int line, const std::string& key, const std::string& limit) {
    EXPECT_THAT(mistakes, Contains(AllOf(StartsWith(fmt::format("{}:{}: flight.{}", file, line, key)),
                                         HasSubstr(limit), HasSubstr("valid: no more than that"))));
  };
  refused(6, "speed_m_s: 12", "autopilot.speed_limit_m_s is");
  refused(8, "avoidance.acceleration_m_s2: 15", "autopilot.acceleration_limit_m_s2 is");
  refused(10, "avoidance.hold.yaw_rate_limit_deg_s: 170", "autopilot.yaw_rate_limit_deg_s is");
  refused(10, "avoidance.hold.bearing_deg: 70", "flight.avoidance.max_bearing_deg is 60");
  EXPECT_THAT(mistakes,
              Contains(file + ":11: flight.marks: is empty; valid: at least one, or a flight.contrast"));
  EXPECT_THAT(Refusal(Write("b.yaml", text + "flight: {avoidance: {max_bearing_deg: 60, hold: {bearing_deg: "
                                             "60}}}\n")),
              IsEmpty());
}

TEST_F(ScenarioTest, WhatCouldNotBeSeenOrToldApartIsRefused) {
  const auto avoid = [](const std::vector<std::string>& overrides) { return Refusal("avoid", overrides); };
  EXPECT_THAT(
      avoid({"flight.marks.0.colour.min_value=0.9", "flight.marks.0.colour.max_value=0.1"}),
      ElementsAre(AllOf(HasSubstr("flight.marks.0.colour.min_value"), HasSubstr("no pixel can match"))));
  EXPECT_THAT(avoid({"flight.marks.1.colour.hue_deg=275"}),
              ElementsAre(AllOf(HasSubstr("flight.marks.1.colour"), HasSubstr("275 +- 12 overlap"),
                                HasSubstr("mark 0, 300 +- 20"))));
  EXPECT_THAT(avoid({"flight.marks.0.colour.hue_deg=355", "flight.marks.1.colour.hue_deg=5"}),
              ElementsAre(HasSubstr("overlap")));  // across 0
  EXPECT_THAT(avoid({"mount.pitch_deg=0"}),
              ElementsAre(AllOf(HasSubstr("mount.pitch_deg: 0"), HasSubstr("straight ahead"))));
  EXPECT_THAT(Refusal("avoid_contrast", {"flight.contrast.tracker.confirm_sightings=9",
                                         "flight.contrast.tracker.confirm_images=3"}),
              ElementsAre(AllOf(HasSubstr("confirm_sightings: 9"), HasSubstr("confirm_images is 3"))));
  EXPECT_THAT(Refusal("follow", {"flight.balloon.colour.min_value=0.9", "flight.balloon.colour.max_value=0.1",
                                 "autopilot.speed_limit_m_s=0.3"}),
              UnorderedElementsAre(HasSubstr("flight.balloon.colour.min_value"),
                                   AllOf(HasSubstr("flight.gains.speed_limit_m_s"),
                                         HasSubstr("autopilot.speed_limit_m_s is 0.3"))));
}

TEST_F(ScenarioTest, ABalloonIsWantedWithinTheImageAtTimesThatFollowOneAnother) {
  const auto one = [](const std::string& references, const std::string& more = "seed=1") {
    return Refusal("follow", {"flight.reference=[" + references + "]", more});
  };
  EXPECT_THAT(one(""), ElementsAre(HasSubstr("flight.reference: is empty; valid: at least one")));
  // 640 x 480 px, the principal point at (319.5, 239.5).
  EXPECT_THAT(one("{u_px: 289, v_px: 209, diameter_px: 60}"), IsEmpty());
  for (const char* beyond : {"{u_px: 290, diameter_px: 60}", "{v_px: -210, diameter_px: 60}",
                             "{diameter_px: 481}", "{u_px: -1500, diameter_px: 60}"}) {
    EXPECT_THAT(one(std::string("{}, {from_s: 5, u_px: 0}, ") + std::string(beyond).insert(1, "from_s: 9, ")),
                ElementsAre(AllOf(HasSubstr("follow.yaml:"), HasSubstr("flight.reference.2: u_px"),
                                  HasSubstr("640 x 480 px"), HasSubstr("valid: "))));
  }
  EXPECT_THAT(one("{diameter_px: 60}", "mount.pitch_deg=0"),
              ElementsAre(AllOf(HasSubstr("flight.reference.0"), HasSubstr("a camera that looks ahead"))));
  EXPECT_THAT(one("{diameter_px: 60}", "mount.pitch_deg=70"), IsEmpty());
  EXPECT_THAT(one("{}, {from_s: 20}, {from_s: 10}"),
              ElementsAre(AllOf(HasSubstr("flight.reference.2.from_s: 10"), HasSubstr("valid: above 20"))));
}

constexpr char kCamchain[] =
    "cam0:\n  camera_model: pinhole\n  distortion_coeffs: []\n  distortion_model: none\n"
    "  intrinsics: [800, 800, 320, 240]\n  resolution: [640, 480]\n";

TEST_F(ScenarioTest, ACameraMayBeACalibrationFileBesideTheScenario) {
  const std::string camera = Write("flights/cameras/kalibr.yaml", kCamchain);
  const std::string file = Write("flights/a.yaml", "mission: pose\ncamera: cameras/kalibr.yaml\n");
  const LoadedScenario loaded = LoadScenario(file);
  EXPECT_EQ(vision::Parameters(loaded.simulator.camera), Eigen::Vector4d(800, 800, 320, 240));
  // And the resolved scenario means the same file from wherever it lies.
  EXPECT_EQ(loaded.scenario.camera, camera);
  EXPECT_EQ(
      vision::Parameters(LoadScenario(Write("runs/1/again.yaml", ToYaml(loaded.scenario))).simulator.camera),
      vision::Parameters(loaded.simulator.camera));
  EXPECT_THAT(Refusal("pose", {"camera=cameras/none.yaml"}),
              ElementsAre(AllOf(HasSubstr("camera"), HasSubstr("no file 'cameras/none.yaml'"))));
}

TEST_F(ScenarioTest, MistakesInACalibrationFileNameTheParameter) {
  const std::string camera =
      Write("kalibr.yaml",
            "cam0:\n  camera_model: omni\n  distortion_coeffs: []\n  distortion_model: none\n"
            "  intrinsics: [-1, 800, 800, 320, 240]\n  resolution: [640, 480]\n");
  EXPECT_THAT(Refusal("pose", {"camera=" + camera}),
              ElementsAre(AllOf(StartsWith(camera + ":5: cam0.xi: -1 is out of range"))));
}

TEST_F(ScenarioTest, TheVehicleBringsItsKindAndItsAutopilot) {
  const LoadedScenario loaded = LoadScenario("hover", {"vehicle=sr20"});
  EXPECT_EQ(std::get<sim::HelicopterParameters>(loaded.simulator.vehicle).mass_kg, 9.5);
  EXPECT_EQ(loaded.simulator.autopilot.roll.gain, 1.0);
  EXPECT_EQ(loaded.simulator.scene.vehicle.filename(), "sr20.xml");
  EXPECT_TRUE(std::holds_alternative<sim::HelicopterParameters>(
      LoadScenario("landing", {"vehicle=sra1"}).simulator.vehicle));
}

TEST_F(ScenarioTest, AHelicopterMustHaveThePowerToHover) {
  CopyRoot();
  Replace("models/vehicles/sr20/sr20.yaml", "power_w: 1400", "power_w: 900");
  EXPECT_THAT(Refusal("hover", {"vehicle=sr20"}),
              ElementsAre(AllOf(HasSubstr("sr20.yaml"), HasSubstr("drive.power_w: 900 W"))));
  Replace("models/vehicles/sr20/sr20.yaml", "kind: helicopter", "kind: airship");
  EXPECT_THAT(Refusal("hover", {"vehicle=sr20"}),
              Contains(AllOf(HasSubstr("sr20.yaml"), HasSubstr("airship"))));
}

TEST_F(ScenarioTest, MistakesOfTheModelsNameTheirOwnFiles) {
  CopyRoot();
  Replace("models/vehicles/pelican/pelican.yaml", "mass_kg: 1.3", "mass_kg: 1300");
  Replace("models/vehicles/pelican/pelican.yaml", "tilt_limit_deg", "tilt_limt_deg");
  Replace("models/pads/helipad/helipad.yaml", "[1.19, 0.91]", "[1.19]");
  const auto mistakes = Refusal("pose");
  EXPECT_EQ(mistakes.size(), 3u);
  EXPECT_THAT(mistakes, Contains(AllOf(HasSubstr("pelican.yaml:"), HasSubstr("mass_kg: 1300"))));
  EXPECT_THAT(mistakes,
              Contains(AllOf(HasSubstr("pelican.yaml:"), HasSubstr("did you mean 'tilt_limit_deg'?"))));
  EXPECT_THAT(mistakes, Contains(AllOf(HasSubstr("helipad.yaml:"), HasSubstr("size_m"))));
}

TEST_F(ScenarioTest, APadsTextureMustBeAnImage) {
  CopyRoot();
  Write("models/pads/helipad/helipad.png", "no picture");
  EXPECT_THAT(Refusal("pose"),
              ElementsAre(AllOf(HasSubstr("helipad.yaml: texture"), HasSubstr("is not an image"))));
}

TEST_F(ScenarioTest, APadMustBeSeenFromWhereTheFlightBegins) {
  EXPECT_THAT(Refusal("landing", {"start.height_m=40"}),
              ElementsAre(AllOf(HasSubstr("start.height_m: 40, and the camera sees the pad from"),
                                HasSubstr("valid: a height within"))));
}

TEST_F(ScenarioTest, ALandingMustSeeItsPadDownToTheHeightBelowWhichItNeedNot) {
  EXPECT_THAT(Refusal("landing", {"pad.name=tag"}),
              ElementsAre(AllOf(HasSubstr("flight.blind_m: 0.35"),
                                HasSubstr("is lost to the camera below 2.1 m"), HasSubstr("nested"))));
  EXPECT_TRUE(Refusal("landing", {"pad.name=nested"}).empty());
}

TEST_F(ScenarioTest, APadMustFitIntoItsWorld) {
  const auto mistakes = Refusal("pose", {"pad.position_m=[299.9, 0]"});
  ASSERT_EQ(mistakes.size(), 1u);
  EXPECT_THAT(mistakes[0], AllOf(HasSubstr("pad"), HasSubstr("ground")));
}

TEST_F(ScenarioTest, AWorldThatMujocoRefusesIsNamed) {
  CopyRoot();
  Replace("models/worlds/airfield/airfield.xml", "type=\"plane\"", "type=\"plain\"");
  EXPECT_THAT(Refusal("pose"), ElementsAre(HasSubstr("airfield.xml")));
}

TEST_F(ScenarioTest, TheLimitsOfTheCriteriaInTheScenariosAreOfKnownMetrics) {
  const std::vector<std::string> names = KnownMetrics();
  const std::set<std::string> known(names.begin(), names.end());
  EXPECT_EQ(known.size(), names.size());
  for (const std::string& name : ScenarioNames()) {
    const auto loaded = LoadScenario(name);
    EXPECT_FALSE(loaded.scenario.criteria.empty()) << name;
    for (const auto& [metric, limit] : loaded.scenario.criteria)
      EXPECT_TRUE(known.count(metric)) << name << ' ' << metric;
  }
}

}  // namespace
}  // namespace kestrel::flight
