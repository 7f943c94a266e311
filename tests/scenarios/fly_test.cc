// SPDX-License-Identifier: Apache-2.0
#include "scenarios/fly.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "config/stopwatch.h"
#include "tests/control/fake_link.h"
#include "tests/scenarios/temporary_folder.h"

namespace kestrel {
namespace {

using ::testing::HasSubstr;

void Sleep(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

// Grey images, so many; then none comes any more.
class DyingSource final : public ImageSource {
 public:
  explicit DyingSource(int images) : left_(images) {}
  bool Open() override { return true; }
  std::optional<Grabbed> Grab() override {
    Sleep(0.02);
    if (left_-- > 0) return Grabbed{cv::Mat(480, 640, CV_8UC1, cv::Scalar(128)), {}, {}};
    Sleep(0.5);
    return std::nullopt;
  }

 private:
  int left_;
};

class FlyTest : public InTemporaryFolder {};

TEST_F(FlyTest, TheRecordsTellOfTheReactionToACameraThatDied) {
  const LoadedPlan plan = LoadPlan("landing");
  bool made = false;
  LiveCamera camera([&made] { return std::make_unique<DyingSource>(std::exchange(made, true) ? 0 : 5); }, {});
  FakeLink link;
  FlyOptions options;
  options.folder = folder_ / "run";
  options.video = false;
  options.limits.image_s = 0.2;
  options.limits.patience_s = 0.5;
  options.most_s = 30;
  std::atomic<bool> interrupted = false;
  options.interrupted = &interrupted;
  std::vector<Reaction> shown;
  options.progress = [&](const VehicleState&, const Decision&, const SafetyChange& change) {
    shown.push_back(change.reaction);
    if (change.reaction == Reaction::kSink) interrupted = true;
  };
  const FlyReport report = FlyAircraft(plan, camera, link, options);
  EXPECT_EQ(report.error, "");
  EXPECT_EQ(report.outcome, "interrupted");  // not by its time: the reaction was told while no image came
  EXPECT_THAT(shown, ::testing::Contains(Reaction::kSink));
  std::ifstream in(folder_ / "run/events.log");
  std::ostringstream text;
  text << in.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("safety: image stale, hold"));
  EXPECT_THAT(text.str(), HasSubstr("safety: image stale, sink"));
  EXPECT_THAT(text.str(), HasSubstr("s of the monotonic clock"));
}

}  // namespace
}  // namespace kestrel
