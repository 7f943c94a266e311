// SPDX-License-Identifier: Apache-2.0
#include "flight/lockstep/lockstep_session.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "records/summary.h"
#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

class LockstepSessionTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    options_.scenario = "hover";
    options_.sim.seed = 5;
    options_.sim.overrides = {"duration_s=1.3", "start.settle_s=0.5"};
    options_.folder = [this](std::uint64_t) { return folder_ / "flight"; };
    options_.video = false;
    options_.say = [this](const std::string& line) { said_.push_back(line); };
    loaded_ = LoadScenario("hover", {"seed=5", "duration_s=1.3", "start.settle_s=0.5"}, false);
    session_.emplace(options_, *loaded_);
  }

  Json Send(const std::string& text) {
    reply_ = session_->Answer(text);
    return Json::parse(reply_.json);
  }
  // With the token that is due.
  Json Ask(const std::string& request, const std::string& keys = "") {
    const Json reply = Send(R"({"request":")" + request + R"(","token":)" + std::to_string(token_) +
                            (keys.empty() ? "" : ",") + keys + "}");
    token_ = reply["token"];
    return reply;
  }
  Json Hello(const std::string& keys = "") {
    return Ask("hello", R"("version":1)" + std::string(keys.empty() ? "" : ",") + keys);
  }

  LockstepOptions options_;
  std::optional<LoadedScenario> loaded_;
  std::optional<LockstepSession> session_;
  LockstepSession::Reply reply_;
  std::vector<std::string> said_;
  std::uint64_t token_ = 0;
};

constexpr char kForward[] = R"("setpoint":{"kind":"velocity","v_H_m_s":[0.5,0.25,0],"yaw_rate_rad_s":0.125})";

TEST_F(LockstepSessionTest, FliesTheFlightOfASim) {
  Hello();
  Json now = Ask("reset");
  int steps = 0;
  for (; !now["done"]; ++steps) now = Ask("step", kForward);
  EXPECT_GT(steps, 5);
  const Json summary = Ask("summary")["summary"];

  Sim sim("hover", options_.sim);
  Observation o = sim.Reset();
  while (!sim.done()) o = sim.Step(control::VelocitySetpoint{{0.5, 0.25, 0}, 0.125});
  const records::Summary flown = sim.Summarise();
  const Json expected = Json::parse(records::ToJson(flown));
  for (const char* key : {"state_hash", "image_hash", "outcome", "metrics", "criteria", "passed", "complete"})
    EXPECT_EQ(summary[key], expected[key]) << key;
  EXPECT_EQ(now["t_s"], sim.t_s());
  EXPECT_EQ(now["state"]["p_NB_m"], Json({o.state.p_NB.x(), o.state.p_NB.y(), o.state.p_NB.z()}));
}

TEST_F(LockstepSessionTest, LeavesTheFolderOfARun) {
  Hello(R"("client":"a test")");
  Json now = Ask("reset");
  EXPECT_EQ(now["folder"], (folder_ / "flight").string());
  std::size_t frames = 0;
  for (; !now["done"]; now = Ask("step", kForward)) ++frames;
  const records::Summary left = records::ReadSummary(folder_ / "flight/summary.json");
  EXPECT_EQ(Json::parse(records::ToJson(left))["state_hash"], Ask("summary")["summary"]["state_hash"]);
  const std::string telemetry = Content(folder_ / "flight/telemetry.csv");
  EXPECT_EQ(std::count(telemetry.begin(), telemetry.end(), '\n'), frames + 1);
  EXPECT_THAT(telemetry, HasSubstr(",0.5,0.25,0,7.16197244,"));  // the setpoints are in it
  EXPECT_THAT(Content(folder_ / "flight/events.log"), HasSubstr("a test"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "flight/scenario.yaml"));
  EXPECT_EQ(Json::parse(Content(folder_ / "flight/page.json"))["again"], "");  // it was stepped by others
}

TEST_F(LockstepSessionTest, ATokenIsOfOneRequest) {
  EXPECT_THAT(Send(R"({"request":"reset","token":1})")["error"]["message"], "the first request is hello");
  Hello();
  Ask("reset", R"("images":false,"records":false)");
  const std::uint64_t before = token_;
  const double t_s = Ask("advance", R"("duration_s":0.1)")["t_s"];
  const std::uint64_t due = token_;
  const auto step = [&](std::uint64_t token) {
    return Send(R"({"request":"step","token":)" + std::to_string(token) + "}");
  };
  const Json doubled = step(before);
  EXPECT_EQ(doubled["ok"], false);
  EXPECT_EQ(doubled["answers"], before);
  EXPECT_EQ(doubled["token"], due);
  EXPECT_EQ(doubled["error"]["kind"], "token");
  EXPECT_EQ(doubled["error"]["message"], "token " + std::to_string(before) +
                                             " was used before: the last reply gave " + std::to_string(due));
  EXPECT_THAT(step(due + 5)["error"]["message"], HasSubstr("was never given"));
  EXPECT_THAT(Send(R"({"request":"step"})")["error"]["message"], HasSubstr("has no token"));
  EXPECT_EQ(Ask("truth")["now"]["t_s"], t_s);  // nothing was flown
}

TEST_F(LockstepSessionTest, ARefusalChangesNothingAndItsTokenMayBeUsedAgain) {
  Hello();
  Ask("reset", R"("images":false,"records":false)");
  const std::uint64_t due = token_;
  const Json refused = Ask("step", R"("setpoint":{"kind":"velocity","v_H_m_s":[1,2],"yaw_rate_rad_s":0})");
  EXPECT_EQ(refused["error"]["kind"], "value");
  EXPECT_EQ(refused["answers"], due);
  EXPECT_EQ(token_, due);
  EXPECT_EQ(Ask("step")["ok"], true);
}

TEST_F(LockstepSessionTest, AfterTheEndAStepIsRefusedAndAnotherFlightMayBegin) {
  Hello();
  EXPECT_THAT(Ask("step")["error"]["message"], HasSubstr("send reset first"));
  Ask("reset", R"("images":false,"records":false)");
  EXPECT_EQ(Ask("finish", R"("outcome":"landed")")["summary"]["outcome"], "landed");
  const Json late = Ask("step");
  EXPECT_EQ(late["error"]["kind"], "state");
  EXPECT_THAT(late["error"]["message"], HasSubstr("after the end of the flight (landed"));
  const Json again = Ask("reset", R"("images":false,"records":false,"seed":9)");
  EXPECT_EQ(again["done"], false);
  EXPECT_EQ(again["seed"], 9);
}

TEST_F(LockstepSessionTest, GivesImagesInSharedMemoryThatNobodyElseMayWrite) {
  Hello();
  const Json reset = Ask("reset", R"("records":false,"surfaces":true)"), frame = reset["frame"];
  Sim sim("hover", [&] {
    SimOptions options = options_.sim;
    options.surfaces = true;
    return options;
  }());
  const Observation o = sim.Reset();
  const std::string name = reset["memory"];
  const int file = shm_open(name.c_str(), O_RDONLY, 0);
  ASSERT_GE(file, 0);
  struct stat there {};
  ASSERT_EQ(fstat(file, &there), 0);
  EXPECT_EQ(there.st_mode & 0777, 0400u);
  const std::size_t size = reset["memory_bytes"];
  void* memory = mmap(nullptr, size, PROT_READ, MAP_SHARED, file, 0);
  ASSERT_NE(memory, MAP_FAILED);
  const auto expect = [&](const char* name_of, const cv::Mat& picture) {
    const Json& layout = frame[name_of];
    EXPECT_EQ(layout["shape"][0], picture.rows);
    EXPECT_EQ(layout["shape"][1], picture.cols);
    const auto* bytes = static_cast<const unsigned char*>(memory) + layout["offset"].get<std::size_t>();
    EXPECT_EQ(std::memcmp(bytes, picture.data, picture.total() * picture.elemSize()), 0) << name_of;
  };
  ASSERT_TRUE(o.frame->image.isContinuous());
  expect("image", o.frame->image);
  expect("depth", o.surfaces.depth_m);
  expect("geom", o.surfaces.geom);
  EXPECT_EQ(frame["image"]["type"], "uint8");
  EXPECT_EQ(frame["depth"]["type"], "float32");
  munmap(memory, size);
  close(file);
  session_.reset();
  EXPECT_EQ(shm_open(name.c_str(), O_RDONLY, 0), -1);  // its name is gone
}

TEST_F(LockstepSessionTest, GivesImagesBehindTheReplyWhereAsked) {
  Hello(R"("inline":true)");
  const Json reset = Ask("reset", R"("records":false)");
  EXPECT_FALSE(reset.contains("memory"));
  EXPECT_EQ(reset["bytes"], PictureBytes(reply_.pictures));
  Sim sim("hover", options_.sim);
  ASSERT_EQ(reply_.pictures.size(), 1u);
  EXPECT_EQ(cv::norm(reply_.pictures[0], sim.Reset().frame->image, cv::NORM_INF), 0);
}

TEST_F(LockstepSessionTest, GivesReadingsAndFramesOfOtherCamerasWithTheirOwnStamps) {
  options_.sim.overrides.insert(
      options_.sim.overrides.end(),
      {"instruments={imu: {rate_hz: 200}, barometer: {}}",
       "cameras=[{name: ahead, camera: thesis_6mm, mount: {pitch_deg: 90}, image: {rate_hz: 20}}]"});
  session_.emplace(options_, *loaded_);
  Hello();
  Ask("reset", R"("records":false)");
  const Json now = Ask("step");
  Sim sim("hover", options_.sim);
  sim.Reset();
  sim.Step();
  const Json& imu = now["readings"]["imu"];
  ASSERT_EQ(imu.size(), sim.readings().imu.size());
  EXPECT_EQ(imu.size(), 10u);
  EXPECT_EQ(imu[3]["t_ns"], sim.readings().imu[3].t_ns);
  EXPECT_EQ(imu[3]["w_I_rad_s"][1], sim.readings().imu[3].w_I.y());
  EXPECT_GT(now["readings"]["barometer"].size(), 0u);
  ASSERT_EQ(now["frames"].size(), 1u);
  EXPECT_EQ(now["frames"][0]["camera"], "ahead");
  EXPECT_EQ(now["frames"][0]["t_s"], sim.camera_frames()[0].frame.t_s);
  EXPECT_GT(now["frames"][0]["image"]["offset"], now["frame"]["image"]["offset"]);
  EXPECT_EQ(Ask("truth")["imu"].size(), imu.size());
}

TEST_F(LockstepSessionTest, WhoGoesInAFlightLeavesItsRecord) {
  Hello();
  Ask("reset", R"("images":false)");
  Ask("step", kForward);
  session_->Leave("the client is gone");
  const records::Summary left = records::ReadSummary(folder_ / "flight/summary.json");
  EXPECT_EQ(left.outcome, "broke off");
  EXPECT_EQ(left.error, "the client is gone");
  EXPECT_FALSE(left.complete);
  EXPECT_GT(left.sim_s, 0);
}

TEST_F(LockstepSessionTest, AFolderThatCannotBeWrittenEndsTheFlightAndIsTold) {
  std::ofstream(folder_ / "flight") << "a file is in its place";
  Hello();
  const Json refused = Ask("reset");
  EXPECT_EQ(refused["ok"], false);
  EXPECT_THAT(refused["error"]["message"], HasSubstr((folder_ / "flight").string()));
  EXPECT_EQ(Ask("step")["error"]["kind"], "state");
  EXPECT_EQ(Ask("reset", R"("records":false)")["ok"], true);
}

}  // namespace
}  // namespace kestrel::flight
