// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/live_camera.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "base/stopwatch.h"

namespace kestrel::vision {
namespace {

void Sleep(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

// What a scripted device does, image by image; the grey level of each image is its number.
struct Script {
  enum class Act { kImage, kFail, kHang, kEnd };
  struct Step {
    Act act = Act::kImage;
    double after_s = 0.002;
    std::optional<std::int64_t> count{};
    std::optional<double> stamp_before_s{};  // the driver's stamp, so long before it is grabbed
    std::optional<double> stamp_s{};         // or itself
  };
  std::vector<Step> steps;
  std::atomic<std::size_t> next = 0;
  std::atomic<int> made = 0, refuse_openings = 0;
  std::atomic<std::size_t> asked = 1000;  // so many images may come: a test that counts them asks for each
  std::atomic<bool> released = false;     // lets those that hang go on
};

class ScriptedSource final : public ImageSource {
 public:
  explicit ScriptedSource(std::shared_ptr<Script> script) : script_(std::move(script)) { ++script_->made; }
  bool Open() override { return script_->refuse_openings-- <= 0; }
  bool Ended() const override { return ended_; }
  std::string Error() const override { return "the script says so"; }
  std::optional<Grabbed> Grab() override {
    const std::size_t i = script_->next++;
    if (i >= script_->steps.size()) {
      ended_ = true;
      return std::nullopt;
    }
    while (i >= script_->asked && !script_->released) Sleep(0.001);
    const Script::Step& step = script_->steps[i];
    Sleep(step.after_s);
    if (step.act == Script::Act::kHang)
      while (!script_->released) Sleep(0.002);
    ended_ = step.act == Script::Act::kEnd;
    if (step.act != Script::Act::kImage) return std::nullopt;
    Grabbed grabbed{cv::Mat(2, 2, CV_8UC1, cv::Scalar(static_cast<double>(i))), {}, step.count};
    if (step.stamp_before_s) grabbed.stamp_s = MonotonicNow_s() - *step.stamp_before_s;
    if (step.stamp_s) grabbed.stamp_s = step.stamp_s;
    return grabbed;
  }

 private:
  std::shared_ptr<Script> script_;
  bool ended_ = false;
};

struct Rig {
  std::shared_ptr<Script> script = std::make_shared<Script>();
  LiveCameraOptions options{.stalled_s = 0.05, .reopen_first_s = 0.004, .reopen_max_s = 0.02};
  ~Rig() { script->released = true; }
  std::optional<Frame> NextOf(LiveCamera& camera) const {
    ++script->asked;
    return camera.Next();
  }
  LiveCamera Camera() {
    return LiveCamera([s = script] { return std::make_unique<ScriptedSource>(s); }, options);
  }
};

int Number(const Frame& frame) { return frame.image.at<std::uint8_t>(0, 0); }

TEST(LiveCamera, GivesEachImageOnceInOrderUntilTheSourceEnds) {
  Rig rig;
  rig.script->steps.resize(5);
  rig.script->asked = 0;
  rig.options.stalled_s = 30;
  LiveCamera camera = rig.Camera();
  for (int i = 0; i < 5; ++i) {
    const auto frame = rig.NextOf(camera);
    ASSERT_TRUE(frame) << i;
    EXPECT_EQ(Number(*frame), i);
    EXPECT_EQ(frame->sequence, i);
  }
  EXPECT_FALSE(camera.Next());
  EXPECT_EQ(camera.Health().state, LiveCameraState::kEnded);
  EXPECT_EQ(camera.Health().overwritten, 0);
}

TEST(LiveCamera, WhoIsSlowGetsTheNewestAndTheOthersAreCounted) {
  Rig rig;
  rig.script->steps.resize(20);
  rig.script->steps.push_back({.act = Script::Act::kHang});
  rig.options.stalled_s = 30;
  LiveCamera camera = rig.Camera();
  while (camera.Health().images < 20) Sleep(0.002);
  const auto frame = camera.Next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(Number(*frame), 19);
  EXPECT_EQ(frame->sequence, 19);
  EXPECT_EQ(camera.Health().overwritten, 19);
  EXPECT_FALSE(camera.Next(0.01));  // nothing newer: the same is not given twice
  rig.script->released = true;  // or the camera would wait for its thread as long as it waits for an image
}

TEST(LiveCamera, ExposuresThatTheDriverCountedAndNobodySawAreAGap) {
  Rig rig;
  for (const int count : {7, 8, 11, 12}) rig.script->steps.push_back({.count = count});
  rig.script->asked = 0;
  rig.options.stalled_s = 30;
  LiveCamera camera = rig.Camera();
  std::vector<std::int64_t> sequences;
  while (const auto frame = rig.NextOf(camera)) sequences.push_back(frame->sequence);
  EXPECT_EQ(sequences, (std::vector<std::int64_t>{0, 1, 4, 5}));
  EXPECT_EQ(camera.Health().missed, 2);
}

TEST(LiveCamera, TheTimeIsTheDriversLessWhatWasCalibrated) {
  Rig rig;
  rig.script->steps.push_back({.stamp_before_s = 2.0});
  rig.options.exposure_before_stamp_s = 0.25;
  LiveCamera camera = rig.Camera();
  const auto frame = camera.Next();
  ASSERT_TRUE(frame);
  EXPECT_NEAR(MonotonicNow_s() - frame->t_s, 2.25, 0.1);
}

TEST(LiveCamera, WithoutTheDriversTimeItIsThatOfTheArrival) {
  Rig rig;
  rig.script->steps.resize(1);
  LiveCamera camera = rig.Camera();
  EXPECT_NEAR(MonotonicNow_s() - camera.Next()->t_s, 0, 0.1);
}

TEST(LiveCamera, ASourceThatFailsIsOpenedAgainAndTheFramesGoOnCounting) {
  Rig rig;
  rig.script->steps = {{}, {.act = Script::Act::kFail}, {}};
  rig.script->asked = 0;
  rig.options.stalled_s = 30;
  LiveCamera camera = rig.Camera();
  EXPECT_EQ(rig.NextOf(camera)->sequence, 0);
  rig.script->asked = 3;
  const auto second = camera.Next();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->sequence, 1);
  EXPECT_EQ(Number(*second), 2);
  EXPECT_EQ(camera.Health().openings, 2);
}

TEST(LiveCamera, ASourceThatIsNotThereIsTriedAgainWithPausesThatGrow) {
  Rig rig;
  rig.script->steps.resize(1);
  rig.script->refuse_openings = 5;
  const double begun_s = MonotonicNow_s();
  LiveCamera camera = rig.Camera();
  EXPECT_EQ(camera.Health().state, LiveCameraState::kOpening);
  EXPECT_FALSE(camera.Health().age_s);
  ASSERT_TRUE(camera.Next());
  EXPECT_EQ(rig.script->made, 6);
  EXPECT_GE(MonotonicNow_s() - begun_s, 0.004 + 0.008 + 0.016 + 0.02 + 0.02);
}

TEST(LiveCamera, ASourceThatHangsIsLeftBehindAndAnotherIsMadeInItsPlace) {
  Rig rig;
  rig.script->steps = {{}, {.act = Script::Act::kHang}, {}};
  rig.script->asked = 0;
  LiveCamera camera = rig.Camera();
  EXPECT_EQ(Number(*rig.NextOf(camera)), 0);
  rig.script->asked = 3;
  const auto frame = camera.Next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(Number(*frame), 2);
  EXPECT_GE(rig.script->made, 2);
}

TEST(LiveCamera, WhileNothingComesItIsStalledAndItsAgeGrows) {
  Rig rig;
  rig.script->steps = {{}, {.act = Script::Act::kHang}};
  rig.options.stalled_s = 0.3;
  LiveCamera camera = rig.Camera();
  ASSERT_TRUE(camera.Next());
  EXPECT_EQ(camera.Health().state, LiveCameraState::kStreaming);
  Sleep(0.31);
  EXPECT_EQ(camera.Health().state, LiveCameraState::kStalled);
  EXPECT_GT(*camera.Health().age_s, 0.3);
}

TEST(LiveCamera, StopEndsTheWaitAtOnceFromAnotherThread) {
  Rig rig;
  rig.script->steps = {{.act = Script::Act::kHang}};
  rig.options.stalled_s = 30;
  LiveCamera camera = rig.Camera();
  std::thread other([&] {
    Sleep(0.02);
    camera.Stop();
  });
  const double begun_s = MonotonicNow_s();
  EXPECT_FALSE(camera.Next());
  EXPECT_LT(MonotonicNow_s() - begun_s, 5);
  other.join();
  rig.script->released = true;
}

// A source that takes its time for an image, and knows whether it is still there.
class SlowSource final : public ImageSource {
 public:
  explicit SlowSource(std::atomic<int>& alive) : alive_(alive) { ++alive_; }
  ~SlowSource() override { --alive_; }
  bool Open() override { return true; }
  std::optional<Grabbed> Grab() override {
    Sleep(0.05);
    return Grabbed{cv::Mat(2, 2, CV_8UC1, cv::Scalar(0)), {}, {}};
  }

 private:
  std::atomic<int>& alive_;
};

TEST(LiveCamera, ItsThreadHasLeftTheSourceOnceTheCameraIsGone) {
  std::atomic<int> alive = 0;
  {
    LiveCamera camera([&] { return std::make_unique<SlowSource>(alive); }, {.stalled_s = 30});
    ASSERT_TRUE(camera.Next());
    ASSERT_EQ(alive, 1);
  }
  EXPECT_EQ(alive, 0);
}

TEST(LiveCamera, ASourceThatHangsToTheEndIsLeftBehindAndCounted) {
  Rig rig;
  rig.script->steps = {{}, {.act = Script::Act::kHang}};
  const int before = LiveCamera::LeftBehind();
  const double begun_s = MonotonicNow_s();
  {
    LiveCamera camera = rig.Camera();
    ASSERT_TRUE(camera.Next());
    while (rig.script->next < 2) Sleep(0.001);
  }
  EXPECT_EQ(LiveCamera::LeftBehind(), before + 1);
  EXPECT_LT(MonotonicNow_s() - begun_s, 5);
}

// What comes of a script whose every image is asked for as soon as the one before was given or refused.
struct Given {
  std::vector<int> numbers;
  std::vector<std::int64_t> sequences;
  std::vector<double> times;
  LiveCameraHealth health;
};

Given Play(Rig& rig) {
  rig.script->asked = 0;
  rig.options.stalled_s = 30;
  LiveCamera camera = rig.Camera();
  Given given;
  for (std::size_t i = 1; i <= rig.script->steps.size(); ++i) {
    ++rig.script->asked;
    const auto settled = [&](const LiveCameraHealth& h) {
      return h.images + h.disordered >= static_cast<std::int64_t>(i);
    };
    const double begun_s = MonotonicNow_s();
    while (!settled(camera.Health()) && MonotonicNow_s() - begun_s < 20) Sleep(0.001);
    while (const auto frame = camera.Next(0)) {
      given.numbers.push_back(Number(*frame));
      given.sequences.push_back(frame->sequence);
      given.times.push_back(frame->t_s);
    }
  }
  given.health = camera.Health();
  return given;
}

using Numbers = std::vector<int>;
using Sequences = std::vector<std::int64_t>;

TEST(LiveCamera, AnImageThatTheDriverCountedBeforeIsNotANewFrame) {
  Rig rig;
  for (const int count : {7, 8, 8, 9, 7, 10}) rig.script->steps.push_back({.count = count});
  const Given given = Play(rig);
  EXPECT_EQ(given.numbers, (Numbers{0, 1, 3, 5}));
  EXPECT_EQ(given.sequences, (Sequences{0, 1, 2, 3}));
  EXPECT_EQ(given.health.disordered, 2);
}

TEST(LiveCamera, OfImagesThatCameInAnotherOrderTheLateOneIsLeftOutAndStaysAGap) {
  Rig rig;
  for (const int count : {1, 2, 4, 3, 5}) rig.script->steps.push_back({.count = count});
  const Given given = Play(rig);
  EXPECT_EQ(given.numbers, (Numbers{0, 1, 2, 4}));
  EXPECT_EQ(given.sequences, (Sequences{0, 1, 3, 4}));
  EXPECT_EQ(given.health.missed, 1);
  EXPECT_EQ(given.health.disordered, 1);
}

TEST(LiveCamera, AStampThatRepeatsOrGoesBackIsNotANewFrame) {
  Rig rig;
  const double base_s = MonotonicNow_s() - 1;
  for (const double stamp_s : {0.0, 0.1, 0.1, 0.05, 0.2})
    rig.script->steps.push_back({.stamp_s = base_s + stamp_s});
  const Given given = Play(rig);
  EXPECT_EQ(given.numbers, (Numbers{0, 1, 4}));
  ASSERT_EQ(given.times.size(), 3u);
  EXPECT_DOUBLE_EQ(given.times[0], base_s);
  EXPECT_DOUBLE_EQ(given.times[2], base_s + 0.2);
  EXPECT_EQ(given.health.disordered, 2);
}

TEST(LiveCamera, TheSameHoldsForStampsOfAnotherClock) {
  Rig rig;
  for (const double stamp_s : {50.0, 50.1, 50.1, 50.05, 50.2})
    rig.script->steps.push_back({.stamp_s = stamp_s + 1e9});
  EXPECT_EQ(Play(rig).numbers, (Numbers{0, 1, 4}));
}

TEST(LiveCamera, StampsOfAnotherClockKeepTheirDistancesOnTheMonotonicOne) {
  Rig rig;
  // The first comes at once; the others are longer on their way than their stamps are apart.
  const double stamp_s = 1.7e9;
  rig.script->steps = {{.stamp_s = stamp_s},
                       {.after_s = 0.06, .stamp_s = stamp_s + 0.01},
                       {.after_s = 0.06, .stamp_s = stamp_s + 0.03}};
  const double begun_s = MonotonicNow_s();
  const Given given = Play(rig);
  ASSERT_EQ(given.times.size(), 3u);
  EXPECT_GE(given.times[0], begun_s);
  EXPECT_LE(given.times[0], MonotonicNow_s() - 0.12);
  EXPECT_NEAR(given.times[1] - given.times[0], 0.01, 1e-6);
  EXPECT_NEAR(given.times[2] - given.times[0], 0.03, 1e-6);
}

TEST(LiveCamera, AClockThatWasSetAnewIsFollowed) {
  Rig rig;
  for (const double stamp_s : {1e9, 1e9 + 0.1, 20.0, 20.1}) rig.script->steps.push_back({.stamp_s = stamp_s});
  const double begun_s = MonotonicNow_s();
  const Given given = Play(rig);
  EXPECT_EQ(given.numbers, (Numbers{0, 1, 2, 3}));
  for (const double t_s : given.times) EXPECT_NEAR(t_s, begun_s, 20);
}

TEST(LiveCamera, NoFrameIsOfTheFutureAndAStampThatIsNoNumberIsNone) {
  Rig rig;
  rig.script->steps = {{.stamp_before_s = 0.0},
                       {.stamp_before_s = -3.0},
                       {.stamp_s = std::numeric_limits<double>::quiet_NaN()},
                       {.stamp_before_s = 0.0}};
  const double begun_s = MonotonicNow_s();
  const Given given = Play(rig);
  EXPECT_EQ(given.numbers, (Numbers{0, 1, 2, 3}));
  for (const double t_s : given.times) {
    EXPECT_GE(t_s, begun_s);
    EXPECT_LE(t_s, MonotonicNow_s());
  }
}

TEST(LiveCamera, ADriverThatGivesTheSameImageAgainAndAgainHasStalledAndIsOpenedAnew) {
  Rig rig;
  rig.script->steps.assign(400, {.count = 5});
  for (int i = 0; i < 3; ++i) rig.script->steps[static_cast<std::size_t>(i)].count = 3 + i;
  rig.options.stalled_s = 0.2;
  LiveCamera camera = rig.Camera();
  const auto both = [](const LiveCameraHealth& h) { return h.openings >= 2 && h.disordered > 0; };
  const double begun_s = MonotonicNow_s();
  while (!both(camera.Health()) && MonotonicNow_s() - begun_s < 20) camera.Next(0.01);
  EXPECT_TRUE(both(camera.Health()));
}

TEST(LiveCamera, UnpluggedInFlightAndBackTheFramesGoOnAndTheReasonIsTold) {
  Rig rig;
  rig.script->steps = {{.count = 900}, {.act = Script::Act::kFail}, {.count = 1}, {.count = 2}};
  rig.script->asked = 0;
  rig.options.stalled_s = 0.1;
  rig.options.reopen_first_s = 0.02;
  LiveCamera camera = rig.Camera();
  const auto before = rig.NextOf(camera);
  ASSERT_TRUE(before);
  EXPECT_EQ(camera.Health().error, "");
  rig.script->refuse_openings = 5;
  ++rig.script->asked;
  const double begun_s = MonotonicNow_s();
  while (camera.Health().state != LiveCameraState::kStalled && MonotonicNow_s() - begun_s < 20) Sleep(0.001);
  EXPECT_EQ(camera.Health().state, LiveCameraState::kStalled);
  EXPECT_EQ(camera.Health().error, "the script says so");
  ++rig.script->asked;
  const auto after = camera.Next();
  ASSERT_TRUE(after);
  EXPECT_EQ(Number(*after), 2);  // whose count begins anew, as a camera's does when it has power again
  EXPECT_EQ(after->sequence, before->sequence + 1);
  EXPECT_GT(after->t_s, before->t_s);
  EXPECT_EQ(camera.Health().missed, 0);
}

}  // namespace
}  // namespace kestrel::vision
