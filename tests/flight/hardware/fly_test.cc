// SPDX-License-Identifier: Apache-2.0
#include "flight/hardware/fly.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/stopwatch.h"
#include "base/yaml/yaml_fields.h"
#include "flight/hardware/aircraft.h"
#include "flight/hardware/pre_flight.h"
#include "records/recording.h"
#include "records/summary.h"
#include "tests/control/link/fake_link.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::HasSubstr;

void Sleep(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

// Grey images, so many; then none comes any more.
class DyingSource final : public vision::ImageSource {
 public:
  explicit DyingSource(int images) : left_(images) {}
  bool Open() override { return true; }
  std::optional<vision::Grabbed> Grab() override {
    Sleep(0.02);
    if (left_-- > 0) return vision::Grabbed{cv::Mat(480, 640, CV_8UC1, cv::Scalar(128)), {}, {}};
    Sleep(0.5);
    return std::nullopt;
  }

 private:
  int left_;
};

// A camera that sees noise.
class NoiseSource final : public vision::ImageSource {
 public:
  explicit NoiseSource(cv::Size size) : size_(size) {}
  bool Open() override { return true; }
  std::optional<vision::Grabbed> Grab() override {
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
    vision::Grabbed grabbed{cv::Mat(size_, CV_8UC1), MonotonicNow_s(), std::nullopt};
    cv::randu(grabbed.image, 0, 256);
    return grabbed;
  }

 private:
  cv::Size size_;
};

class FlyTest : public InTemporaryFolder {
 protected:
  static vision::ImageSourceMaker Noise(cv::Size size = {640, 480}) {
    return [size] { return std::make_unique<NoiseSource>(size); };
  }
  static std::string Text(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
  const CheckItem& Item(const std::string& name) const {
    for (const CheckItem& item : items_)
      if (item.name == name) return item;
    ADD_FAILURE() << "no item " << name;
    return items_.front();
  }
  void Check(cv::Size size = {640, 480}) {
    vision::LiveCamera camera(Noise(size), {});
    items_ = PreFlight(plan_, camera, link_, {.watch_s = 0.5, .wait_s = 1});
  }
  FlyOptions Options() const {
    FlyOptions options;
    options.max_s = 1.5;  // some images, on a busy machine too
    options.video = false;
    options.release = {.still_s = 0.05, .max_s = 0.3};
    return options;
  }

  LoadedPlan plan_ = LoadPlan("hover", {"image.rate_hz=20"});
  control::FakeLink link_;
  std::vector<CheckItem> items_;
};

TEST_F(FlyTest, TheCheckListIsMetByWhatIsRight) {
  Check();
  EXPECT_TRUE(AllOk(items_)) << items_[0].found;
  EXPECT_EQ(items_.size(), 6u);
}

TEST_F(FlyTest, AnImageOfAnotherSizeThanTheCalibrationsIsNotFlownBy) {
  Check({320, 240});
  EXPECT_FALSE(Item("image against calibration").ok);
  EXPECT_THAT(Item("image against calibration").found, HasSubstr("320 x 240"));
}

TEST_F(FlyTest, ACameraThatIsTooSlowIsNotFlownBy) {
  plan_.plan.image.rate_hz = 100;
  Check();
  EXPECT_FALSE(Item("camera rate").ok);
}

TEST_F(FlyTest, ACameraThatIsTooFastIsNotFlownByAndTheRemedyIsSaid) {
  plan_.plan.image.rate_hz = 10;  // the camera gives 25
  Check();
  EXPECT_FALSE(Item("camera rate").ok);
  EXPECT_THAT(Item("camera rate").found, HasSubstr("?rate=10"));
}

TEST_F(FlyTest, AnInterruptEndsTheCheckList) {
  const std::atomic<bool> interrupted = true;
  vision::LiveCamera camera(Noise(), {});
  const double begun_s = MonotonicNow_s();
  PreFlight(plan_, camera, link_, {.watch_s = 60, .wait_s = 60, .interrupted = &interrupted});
  EXPECT_LT(MonotonicNow_s() - begun_s, 10);
}

TEST_F(FlyTest, AColourThatTheFlightNeedsIsMissed) {
  plan_.plan.image.colour = true;
  Check();
  EXPECT_FALSE(Item("colour").ok);
}

TEST_F(FlyTest, ALinkWithoutAStateIsNotFlownBy) {
  link_.Set([](control::VehicleState&, control::LinkHealth& health) { health.state_age_s.reset(); });
  Check();
  EXPECT_FALSE(Item("link").ok);
}

TEST_F(FlyTest, AnErrorOfTheLinkIsAReasonNotToFly) {
  link_.Set([](control::VehicleState&, control::LinkHealth& health) { health.error = "battery at 9.8 V"; });
  Check();
  EXPECT_FALSE(Item("link").ok);
  EXPECT_THAT(Item("link").found, HasSubstr("9.8 V"));
}

TEST_F(FlyTest, AStateThatCannotBeIsNotFlownBy) {
  link_.Set([](control::VehicleState& state, control::LinkHealth&) {
    state.R_NB = Eigen::Quaterniond(0, 1, 0, 0);
  });
  Check();
  EXPECT_FALSE(Item("state").ok);
}

TEST_F(FlyTest, ASwitchThatIsOffOrNotToldIsNotFlownBy) {
  link_.Set([](control::VehicleState&, control::LinkHealth& health) { health.pilot_allows = false; });
  Check();
  EXPECT_FALSE(Item("pilot's switch").ok);
  link_.Set([](control::VehicleState&, control::LinkHealth& health) { health.pilot_allows.reset(); });
  Check();
  EXPECT_FALSE(Item("pilot's switch").ok);
  EXPECT_THAT(Item("pilot's switch").found, HasSubstr("--pilot-untold"));
}

TEST_F(FlyTest, TheSwitchOfAnAutopilotThatIsNotHeardIsUnknownAndNoneIsAskedToPassItOver) {
  link_.Set([](control::VehicleState&, control::LinkHealth& health) {
    health.state_age_s.reset();
    health.pilot_allows.reset();
    health.open = false;
    health.error = "no autopilot heard";
  });
  Check();
  EXPECT_FALSE(Item("pilot's switch").ok);
  EXPECT_THAT(Item("pilot's switch").found, HasSubstr("not heard"));
  EXPECT_THAT(Item("pilot's switch").found, ::testing::Not(HasSubstr("--pilot-untold")));
}

TEST_F(FlyTest, AnAutopilotThatIsThereAndTellsNoStateIsNotSaidToBeUnheard) {
  link_.Set([](control::VehicleState&, control::LinkHealth& health) {
    health.open = true;
    health.state_age_s.reset();
    health.pilot_allows = true;
    health.error = "no position comes (LOCAL_POSITION_NED)";
  });
  Check();
  EXPECT_FALSE(Item("link").ok);
  EXPECT_THAT(Item("link").found,
              ::testing::AllOf(HasSubstr("of the autopilot that is heard"), HasSubstr("LOCAL_POSITION_NED")));
  EXPECT_TRUE(Item("pilot's switch").ok);
  for (const CheckItem& item : items_) EXPECT_THAT(item.found, ::testing::Not(HasSubstr("not heard")));
}

TEST_F(FlyTest, AnImageThatCameAndCannotBeFlownByIsNotSaidToBeNone) {
  class Other final : public vision::ImageSource {
    bool Open() override { return true; }
    std::optional<vision::Grabbed> Grab() override { return std::nullopt; }
    std::string Error() const override { return "an image of 320x240 came"; }
  };
  vision::LiveCamera camera([] { return std::make_unique<Other>(); }, {});
  std::vector<std::string> told;
  double waited_s = 0;
  items_ = PreFlight(plan_, camera, link_,
                     {.watch_s = 0.2, .wait_s = 0.3, .waits = [&](const std::string& what, double s) {
                        told.push_back(what), waited_s = s;
                      }});
  EXPECT_EQ(told.back(), "the camera's first image: an image of 320x240 came");
  EXPECT_LT(waited_s, 0.4);
  EXPECT_FALSE(Item("camera").ok);
  EXPECT_THAT(Item("camera").found, HasSubstr("an image of 320x240 came"));
  EXPECT_THAT(Item("camera").found, ::testing::Not(HasSubstr("no image")));
}

TEST_F(FlyTest, CameraAndStateAreEachWaitedForAndWhatWasWaitedForIsSaidOnce) {
  class Late final : public vision::ImageSource {
   public:
    bool Open() override { return MonotonicNow_s() > from_s_; }
    std::optional<vision::Grabbed> Grab() override {
      std::this_thread::sleep_for(std::chrono::milliseconds(40));
      return vision::Grabbed{cv::Mat(480, 640, CV_8UC1, cv::Scalar(128)), MonotonicNow_s(), std::nullopt};
    }

   private:
    const double from_s_ = MonotonicNow_s() + 0.6;
  };
  link_.Set([](control::VehicleState&, control::LinkHealth& health) {
    health.state_age_s.reset();
    health.error = "no position comes (LOCAL_POSITION_NED)";
  });
  vision::LiveCameraOptions often;
  often.reopen_first_s = often.reopen_max_s = 0.1;
  std::set<std::string> waits;
  double waited_s = 0;
  const auto wait = [&](const std::string& what, double s) { waits.insert(what), waited_s = s; };
  {
    vision::LiveCamera camera([late = std::make_shared<Late>()] { return std::make_unique<Late>(*late); },
                              often);
    const double begun_s = MonotonicNow_s();
    items_ = PreFlight(plan_, camera, link_, {.watch_s = 0.3, .wait_s = 2, .waits = wait});
    EXPECT_GT(MonotonicNow_s() - begun_s, 0.6 + 0.3 + 2 - 0.1);  // the state has all of its own time
  }
  EXPECT_TRUE(waits.contains("the camera's first image"));
  EXPECT_TRUE(waits.contains("the autopilot's state: no position comes (LOCAL_POSITION_NED)"));
  EXPECT_NEAR(waited_s, 2, 0.2);
  EXPECT_THAT(Item("link").found,
              HasSubstr("no state in 2 s of the autopilot that is heard: no position comes"));
}

TEST_F(FlyTest, ACameraThatIsNotThereIsSaidToBe) {
  class Absent final : public vision::ImageSource {
    bool Open() override { return false; }
    std::optional<vision::Grabbed> Grab() override { return std::nullopt; }
  };
  vision::LiveCamera camera([] { return std::make_unique<Absent>(); }, {});
  items_ = PreFlight(plan_, camera, link_, {.watch_s = 0.2, .wait_s = 0.2});
  EXPECT_FALSE(Item("camera").ok);
}

TEST_F(FlyTest, WhatBecomesOfTheLinkInFlightIsSaidAndOnRecord) {
  FlyOptions options = Options();
  options.folder = folder_;
  std::vector<std::string> told;
  options.told = [&](const std::string& text) { told.push_back(text); };
  int frames = 0;
  options.seen = [&](const vision::Frame&) {
    link_.Set([&, n = ++frames](control::VehicleState&, control::LinkHealth& health) {
      health.error = n >= 4 && n < 8 ? "tcp://a:1: the other end has closed the connection" : "";
    });
  };
  vision::LiveCamera camera(Noise(), {});
  FlyAircraft(plan_, camera, link_, options);
  ASSERT_GT(frames, 8);
  EXPECT_EQ(told, (std::vector<std::string>{"link: tcp://a:1: the other end has closed the connection",
                                            "link: in order again"}));
  EXPECT_THAT(Text(folder_ / "events.log"), HasSubstr("link: tcp://a:1: the other end has closed"));
}

TEST_F(FlyTest, AFlightLeavesItsRecords) {
  FlyOptions options = Options();
  options.folder = folder_;
  options.images = true;
  vision::LiveCamera camera(Noise(), {});
  const FlyReport report = FlyAircraft(plan_, camera, link_, options);
  EXPECT_EQ(report.outcome, "time is up");
  EXPECT_FALSE(report.accomplished);
  EXPECT_EQ(report.error, "");
  ASSERT_GT(report.frames, 2);
  EXPECT_GT(link_.sends(), 2);
  EXPECT_TRUE(link_.silent());
  EXPECT_THAT(Text(folder_ / "events.log"), HasSubstr("mode: LIVE"));
  EXPECT_THAT(Text(folder_ / "summary.json"), HasSubstr("\"mode\": \"LIVE\""));
  const records::Recording recording(folder_);
  EXPECT_EQ(static_cast<std::int64_t>(recording.frames().size()), report.frames - report.records_dropped);
  // Its plan is a plan again, and its images give the same decisions.
  const LoadedPlan plan = LoadPlan((folder_ / "scenario.yaml").string());
  const auto mission = plan.plan.flight->Make(plan.parts);
  for (std::size_t i = 0; i < recording.frames().size(); ++i) {
    const records::RecordedDecision now = records::Recorded(
        mission->Step(recording.At(i), recording.frames()[i].state), plan.plan.flight.type());
    EXPECT_EQ(now.numbers, recording.frames()[i].decision.numbers) << i;
  }
}

TEST_F(FlyTest, ADryRunSendsNothing) {
  FlyOptions options = Options();
  options.dry_run = true;
  options.folder = folder_;
  vision::LiveCamera camera(Noise(), {});
  const FlyReport report = FlyAircraft(plan_, camera, link_, options);
  EXPECT_GT(report.frames, 2);
  EXPECT_EQ(link_.sends(), 0);
  EXPECT_THAT(Text(folder_ / "events.log"), HasSubstr("DRY RUN"));
}

TEST_F(FlyTest, TheRecordsSayWhatItWasFlownWithAndWhatWasSent) {
  const std::string file = folder_ / "aircraft.yaml";
  Mistakes mistakes;
  Aircraft aircraft = LoadAircraft("", {"safety.speed_m_s=1.25"}, mistakes);
  aircraft.mavlink.take_control = true;
  mistakes.ThrowIfAny();
  link_.Set(
      [](control::VehicleState& state, control::LinkHealth&) { state.landed = false, state.p_NB.z() = -3; });
  FlyOptions options = Options();
  options.folder = folder_;
  options.aircraft = ToYaml(aircraft);
  options.flown_with = {{"camera", "v4l2:/dev/video3"}, {"check", "ok link"}};
  vision::LiveCamera camera(Noise(), {});
  FlyAircraft(plan_, camera, link_, options);
  const Aircraft again = LoadAircraft(file, {}, mistakes);
  mistakes.ThrowIfAny();
  EXPECT_EQ(again.safety.speed_m_s, 1.25);
  EXPECT_TRUE(again.mavlink.take_control);
  const std::string events = Text(folder_ / "events.log");
  EXPECT_THAT(events, HasSubstr("camera: v4l2:/dev/video3"));
  EXPECT_LT(events.find("check: ok link"), events.find("phase:"));

  std::istringstream table(Text(folder_ / "telemetry.csv"));
  const auto cells = [&] {
    std::string line, cell;
    std::getline(table, line);
    std::istringstream words(line);
    std::vector<std::string> all;
    while (std::getline(words, cell, ',')) all.push_back(cell);
    return all;
  };
  const std::vector<std::string> names = cells();
  const auto column = [&](const char* name) {
    return std::find(names.begin(), names.end(), name) - names.begin();
  };
  ASSERT_LT(column("safe_vx_m_s"), std::ssize(names));
  int flown = 0;
  for (auto row = cells(); !row.empty(); row = cells()) {
    ASSERT_EQ(row.size(), names.size());
    if (row[column("safety_reaction")] == "fly") {
      ++flown;
      EXPECT_NE(row[column("safe_vx_m_s")], "");
    }
  }
  EXPECT_GT(flown, 0);
}

TEST_F(FlyTest, AFlightThatWasNotFlownLeavesARecordOfWhy) {
  FlyOptions options = Options();
  options.folder = folder_;
  options.flown_with = {{"check", "NOT link no autopilot heard"}};
  RecordNotFlown(plan_, options, "the check list is not met");
  const std::string events = Text(folder_ / "events.log");
  EXPECT_THAT(events, HasSubstr("check: NOT link no autopilot heard"));
  EXPECT_THAT(events, HasSubstr("end: not flown: the check list is not met"));
  EXPECT_FALSE(records::ReadSummary(folder_ / "summary.json").passed);
}

TEST_F(FlyTest, WhatHappenedIsOnDiskWhileTheFlightGoesOn) {
  FlyOptions options = Options();
  options.folder = folder_;
  options.max_s = 60;
  std::atomic<bool> interrupted = false;
  options.interrupted = &interrupted;
  options.progress = [&](const control::VehicleState&, const mission::Decision&,
                         const control::SafetyChange&) {
    const std::string during = Text(folder_ / "events.log.part");
    interrupted = during.find("mode: ") != std::string::npos && during.find("safety: ") != std::string::npos;
  };
  vision::LiveCamera camera(Noise(), {});
  EXPECT_EQ(FlyAircraft(plan_, camera, link_, options).outcome, "interrupted");
}

TEST_F(FlyTest, ADryRunPassesIfTheCheckListWasMetAndNothingWasLost) {
  FlyOptions options = Options();
  options.dry_run = true;
  vision::LiveCamera camera(Noise(), {});
  const FlyReport report = FlyAircraft(plan_, camera, link_, options);
  EXPECT_TRUE(report.accomplished);
  EXPECT_EQ(report.outcome, "computed, nothing flown: time is up");
}

TEST_F(FlyTest, ADryRunWhoseCheckListWasNotMetDoesNotPass) {
  FlyOptions options = Options();
  options.dry_run = true;
  options.checked = false;
  vision::LiveCamera camera(Noise(), {});
  const FlyReport report = FlyAircraft(plan_, camera, link_, options);
  EXPECT_FALSE(report.accomplished);
  EXPECT_THAT(report.outcome, HasSubstr("the check list was not met"));
}

TEST_F(FlyTest, ADryRunThatLostImagesOrTheStateDoesNotPass) {
  FlyOptions options = Options();
  options.dry_run = true;
  options.limits.image_s = 0.2;
  {
    bool made = false;
    vision::LiveCamera camera(
        [&made] { return std::make_unique<DyingSource>(std::exchange(made, true) ? 0 : 5); }, {});
    const FlyReport report = FlyAircraft(plan_, camera, link_, options);
    EXPECT_FALSE(report.accomplished);
    EXPECT_EQ(report.outcome, "computed, nothing flown: time is up; images were lost");
  }
  link_.Set([](control::VehicleState&, control::LinkHealth& health) { health.state_age_s = 3; });
  vision::LiveCamera camera(Noise(), {});
  const FlyReport report = FlyAircraft(plan_, camera, link_, options);
  EXPECT_FALSE(report.accomplished);
  EXPECT_EQ(report.outcome, "computed, nothing flown: time is up; the state was lost");
}

TEST_F(FlyTest, AStateThatWasNeverHeardIsNotTakenForLanded) {
  link_.Set([](control::VehicleState&, control::LinkHealth& health) { health.state_age_s.reset(); });
  const LoadedPlan plan = LoadPlan("landing", {"image.rate_hz=20"});
  FlyOptions options = Options();
  options.dry_run = true;
  options.folder = folder_;
  options.max_s = 1.6;  // a landing ends a second after the touch-down
  std::vector<std::string> phases;
  options.progress = [&](const control::VehicleState&, const mission::Decision& decision,
                         const control::SafetyChange&) { phases.emplace_back(decision.phase); };
  vision::LiveCamera camera(Noise(), {});
  const FlyReport report = FlyAircraft(plan, camera, link_, options);
  EXPECT_FALSE(report.accomplished);
  EXPECT_THAT(phases, ::testing::Not(::testing::Contains("landed")));
  const std::string events = Text(folder_ / "events.log");
  EXPECT_THAT(events, HasSubstr("autopilot: its state is not heard"));
  EXPECT_THAT(events, ::testing::Not(HasSubstr("landed")));
}

// In the air, and flying as it is told.
void Obedient(control::FakeLink& link) {
  link.Set([](control::VehicleState& state, control::LinkHealth&) {
    state.landed = false, state.mode = control::FlightMode::kVelocity;
    state.v_N = {0, 0, 1};
  });
  link.Answer([](const control::Setpoint& setpoint, control::VehicleState& state) {
    if (const auto* velocity = std::get_if<control::VelocitySetpoint>(&setpoint)) state.v_N = velocity->v_H;
  });
}

TEST_F(FlyTest, HoweverItEndsTheAircraftStandsStillBeforeTheWireFallsSilent) {
  const std::atomic<bool> interrupted = true;
  for (const std::string end : {"time is up", "interrupted"}) {
    control::FakeLink link;
    Obedient(link);
    FlyOptions options = Options();
    options.folder = folder_ / end;
    options.max_s = 0.4;
    if (end == "interrupted") options.interrupted = &interrupted;
    vision::LiveCamera camera(Noise(), {});
    const FlyReport report = FlyAircraft(plan_, camera, link, options);
    EXPECT_EQ(report.outcome, end);
    EXPECT_THAT(report.release, HasSubstr("held"));
    EXPECT_THAT(Text(folder_ / end / "events.log"), HasSubstr("release: held"));
    ASSERT_TRUE(link.last() && std::holds_alternative<control::VelocitySetpoint>(*link.last()));
    EXPECT_TRUE(std::get<control::VelocitySetpoint>(*link.last()).v_H.isZero());
    EXPECT_TRUE(link.State().v_N.isZero());
    EXPECT_TRUE(link.silent());
  }
}

TEST_F(FlyTest, AnAircraftThatDoesNotStandStillIsLetGoAfterATimeAndThatIsSaid) {
  Obedient(link_);
  link_.Answer({});
  vision::LiveCamera camera(Noise(), {});
  const FlyReport report = FlyAircraft(plan_, camera, link_, Options());
  EXPECT_THAT(report.release, HasSubstr("not obeyed"));
  EXPECT_TRUE(link_.silent());
}

TEST_F(FlyTest, WhatIsThePilotsIsNotHeldAtTheEnd) {
  Obedient(link_);
  link_.Set([](control::VehicleState&, control::LinkHealth& health) { health.pilot_allows = false; });
  vision::LiveCamera camera(Noise(), {});
  const FlyReport report = FlyAircraft(plan_, camera, link_, Options());
  EXPECT_THAT(report.release, HasSubstr("the pilot's"));
  EXPECT_EQ(link_.sends(), 0);
}

TEST_F(FlyTest, AServedSimulatorIsNotTakenForAnAircraft) {
  link_.Set([](control::VehicleState&, control::LinkHealth& health) { health.simulated = true; });
  FlyOptions options = Options();
  options.folder = folder_;
  vision::LiveCamera camera(Noise(), {});
  FlyAircraft(plan_, camera, link_, options);
  EXPECT_THAT(Text(folder_ / "events.log"), HasSubstr("mode: LIVE, SIMULATED AIRCRAFT"));
}

TEST_F(FlyTest, AMissionThatDoesNotDeclareItsTargetIsNotFlown) {
  class Undeclared final : public mission::Mission {
    mission::Decision Step(const vision::Frame&, const control::VehicleState&) override { return {}; }
    void Draw(cv::Mat&) const override {}
  };
  Mistakes mistakes;
  CheckDeclared(Undeclared(), "sketch", mistakes);
  ASSERT_EQ(mistakes.Texts().size(), 1u);
  EXPECT_THAT(mistakes.Texts()[0], ::testing::AllOf(HasSubstr("'sketch'"), HasSubstr("Mission::Target")));
}

std::unique_ptr<mission::Mission> Made(const LoadedPlan& plan) { return plan.plan.flight->Make(plan.parts); }

TEST_F(FlyTest, EveryMissionOfOursDeclaresWhetherItNeedsItsTarget) {
  for (const auto& [name, need] : {std::pair{"pose", mission::TargetNeed::kInSight},
                                   {"hover", mission::TargetNeed::kInSight},
                                   {"landing", mission::TargetNeed::kInSight},
                                   {"follow", mission::TargetNeed::kInSight},
                                   {"attitude_1", mission::TargetNeed::kNone},
                                   {"gyro_failure", mission::TargetNeed::kNone},
                                   {"avoid", mission::TargetNeed::kNone},
                                   {"vicon_1", mission::TargetNeed::kNone},
                                   {"stabilise", mission::TargetNeed::kNone},
                                   {"survey", mission::TargetNeed::kNone},
                                   {"panorama", mission::TargetNeed::kNone}})
    EXPECT_EQ(Made(LoadPlan(name))->Target(), need) << name;
}

// A source of noise shows no pad.
TEST_F(FlyTest, ATargetThatIsNeverSeenIsLost) {
  Obedient(link_);
  FlyOptions options = Options();
  options.folder = folder_;
  options.max_s = 1.5;
  options.limits.target_s = 0.3;
  vision::LiveCamera camera(Noise(), {});
  FlyAircraft(plan_, camera, link_, options);
  EXPECT_THAT(Text(folder_ / "events.log"), HasSubstr("safety: target lost, hold"));
}

TEST_F(FlyTest, AFlightThatThePilotTookDoesNotPass) {
  link_.Set([](control::VehicleState& state, control::LinkHealth& health) {
    state.landed = false;
    health.pilot_allows = false;
  });
  vision::LiveCamera camera(Noise(), {});
  const FlyReport report = FlyAircraft(plan_, camera, link_, Options());
  EXPECT_FALSE(report.accomplished);
  EXPECT_EQ(report.outcome, "ended by the pilot");
}

TEST_F(FlyTest, AFlightWhoseLinkDiedIsNotSaidToBeThePilots) {
  link_.Set([](control::VehicleState& state, control::LinkHealth& health) {
    state.landed = false;
    health.state_age_s = 5;
    health.pilot_allows.reset();  // nothing is told of the switch either
  });
  vision::LiveCamera camera(Noise(), {});
  const FlyReport report = FlyAircraft(plan_, camera, link_, Options());
  EXPECT_FALSE(report.accomplished);
  EXPECT_EQ(report.outcome, "ended without link");
}

TEST_F(FlyTest, AnInterruptEndsIt) {
  FlyOptions options = Options();
  options.max_s = 60;
  const std::atomic<bool> interrupted = true;
  options.interrupted = &interrupted;
  vision::LiveCamera camera(Noise(), {});
  EXPECT_EQ(FlyAircraft(plan_, camera, link_, options).outcome, "interrupted");
}

TEST_F(FlyTest, AFolderThatCannotBeWrittenDoesNotEndAFlight) {
  // The disk is full from the first image on: a file stands where the images' folder must be.
  FlyOptions options = Options();
  options.folder = folder_;
  options.images = true;
  options.max_s = 60;
  vision::LiveCamera camera(Noise(), {});
  int told = 0;
  std::atomic<bool> enough = false;
  options.interrupted = &enough;
  options.progress = [&](const control::VehicleState&, const mission::Decision&,
                         const control::SafetyChange&) {
    std::filesystem::remove_all(folder_ / "recording");
    enough = ++told > 12;
  };
  const FlyReport report = FlyAircraft(plan_, camera, link_, options);
  EXPECT_EQ(report.outcome, "interrupted");
  EXPECT_THAT(report.error, HasSubstr("recording"));
  EXPECT_GT(report.frames, 5);
}

TEST_F(FlyTest, TheRecordsTellOfTheReactionToACameraThatDied) {
  const LoadedPlan plan = LoadPlan("landing");
  bool made = false;
  vision::LiveCamera camera(
      [&made] { return std::make_unique<DyingSource>(std::exchange(made, true) ? 0 : 5); }, {});
  control::FakeLink link;
  FlyOptions options;
  options.folder = folder_ / "run";
  options.video = false;
  options.limits.image_s = 0.2;
  options.limits.patience_s = 0.5;
  options.max_s = 30;
  std::atomic<bool> interrupted = false;
  options.interrupted = &interrupted;
  std::vector<control::Reaction> shown;
  options.progress = [&](const control::VehicleState&, const mission::Decision&,
                         const control::SafetyChange& change) {
    shown.push_back(change.reaction);
    if (change.reaction == control::Reaction::kSink) interrupted = true;
  };
  const FlyReport report = FlyAircraft(plan, camera, link, options);
  EXPECT_EQ(report.error, "");
  EXPECT_EQ(report.outcome, "interrupted");  // not by its time: the reaction was told while no image came
  EXPECT_THAT(shown, ::testing::Contains(control::Reaction::kSink));
  std::ifstream in(folder_ / "run/events.log");
  std::ostringstream text;
  text << in.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("safety: image stale, hold"));
  EXPECT_THAT(text.str(), HasSubstr("safety: image stale, sink"));
  EXPECT_THAT(text.str(), HasSubstr("s of the monotonic clock"));
}

}  // namespace
}  // namespace kestrel::flight
