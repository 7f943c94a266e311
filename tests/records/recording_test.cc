// SPDX-License-Identifier: Apache-2.0
#include "records/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "tests/support/temporary_folder.h"

namespace kestrel::records {
namespace {

using ::testing::HasSubstr;

using RecordingTest = InTemporaryFolder;

control::VehicleState SomeState(std::mt19937& random) {
  std::normal_distribution<double> normal(0, 3);
  const auto vector = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
  control::VehicleState s;
  s.t_s = 1000 * normal(random);
  s.p_NB = vector(), s.v_N = vector(), s.w_B = vector();
  s.R_NB =
      Eigen::Quaterniond(Eigen::Vector4d(normal(random), normal(random), normal(random), 1).normalized());
  s.R_NB_inertial = s.R_NB.conjugate();
  return s;
}

// With a column of its own, of some frames.
const mission::MissionType kType{
    .name = "some",
    .summary = "",
    .telemetry = {{"age_s", [](const mission::LogRow& row) -> std::optional<double> {
                     return row.decision.fix ? std::optional(row.decision.fix_age_s / 3) : std::nullopt;
                   }}}};

TEST_F(RecordingTest, ReadsBackToTheSameBits) {
  std::mt19937 random(3);
  std::vector<vision::Frame> frames;
  std::vector<control::VehicleState> states;
  std::vector<mission::Decision> decisions;
  RecordingWriter writer(folder_, kType);
  for (int i = 0; i < 5; ++i) {
    vision::Frame frame{cv::Mat(6, 8, i % 2 ? CV_8UC3 : CV_8UC1), 0.1 * i + 1. / 3, 2 * i};
    cv::randu(frame.image, 0, 256);
    control::VehicleState state = SomeState(random);
    state.mode = static_cast<control::FlightMode>(i);
    state.landed = i == 3, state.saturated = i == 2, state.aided = i == 1;
    if (i == 4) state.R_NB_inertial.reset();
    mission::Decision decision;
    decision.phase = "search", decision.target = i ? "tracked" : "";
    if (i == 1) decision.setpoint = control::VelocitySetpoint{{1. / 3, 0, -0.0}, 1e-17};
    if (i == 2) decision.setpoint = control::PositionSetpoint{{1, 2, 3}, 4};
    if (i == 3) decision.fix = mission::TargetFix{{1, 2, 3}, 4, 5, 6, 7, true};
    writer.Write(frame, state, decision);
    frames.push_back(frame), states.push_back(state), decisions.push_back(decision);
  }
  writer.Close();

  const Recording recording(folder_);
  ASSERT_EQ(recording.frames().size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    const RecordedFrame& got = recording.frames()[i];
    const vision::Frame frame = recording.At(i);
    EXPECT_EQ(frame.t_s, frames[i].t_s);
    EXPECT_EQ(frame.sequence, frames[i].sequence);
    ASSERT_EQ(frame.image.type(), frames[i].image.type());
    EXPECT_EQ(cv::norm(frame.image, frames[i].image, cv::NORM_INF), 0);
    EXPECT_EQ(got.state.t_s, states[i].t_s);
    EXPECT_EQ(got.state.p_NB, states[i].p_NB);
    EXPECT_EQ(got.state.v_N, states[i].v_N);
    EXPECT_EQ(got.state.w_B, states[i].w_B);
    EXPECT_EQ(got.state.R_NB.coeffs(), states[i].R_NB.coeffs());
    ASSERT_EQ(got.state.R_NB_inertial.has_value(), i != 4);
    if (i != 4) {
      EXPECT_EQ(got.state.R_NB_inertial->coeffs(), states[i].R_NB_inertial->coeffs());
    }
    EXPECT_EQ(got.state.mode, states[i].mode);
    EXPECT_EQ(got.state.landed, states[i].landed);
    EXPECT_EQ(got.state.saturated, states[i].saturated);
    EXPECT_EQ(got.state.aided, states[i].aided);
    const RecordedDecision wanted = Recorded(decisions[i], kType);
    EXPECT_EQ(got.decision.phase, wanted.phase);
    EXPECT_EQ(got.decision.target, wanted.target);
    EXPECT_EQ(got.decision.numbers, wanted.numbers);
  }
}

TEST_F(RecordingTest, SaysWhatIsWrongAndWhere) {
  const auto complaint = [&] {
    try {
      Recording recording(folder_);
      if (!recording.frames().empty()) recording.At(0);
      return std::string();
    } catch (const std::runtime_error& e) {
      return std::string(e.what());
    }
  };
  EXPECT_THAT(complaint(), HasSubstr("--images"));
  RecordingWriter writer(folder_, kType);
  writer.Write({cv::Mat::zeros(4, 4, CV_8U), 0, 0}, {}, {});
  writer.Close();
  const auto file = folder_ / "recording" / "frames.csv";
  EXPECT_EQ(complaint(), "");
  std::ofstream(file, std::ios::app) << "1,2,3\n";
  EXPECT_THAT(complaint(), HasSubstr("frames.csv:3: 3 cells"));
  std::filesystem::remove(folder_ / "recording" / "000000.png");
  std::ofstream(file) << "another\n";
  EXPECT_THAT(complaint(), HasSubstr("frames.csv:1"));
}

TEST_F(RecordingTest, OfAFlightThatBrokeOffThereIsWhatWasWritten) {
  {
    RecordingWriter writer(folder_, kType);
    writer.Write({cv::Mat::zeros(4, 4, CV_8U), 0, 0}, {}, {});
    writer.Write({cv::Mat::zeros(4, 4, CV_8U), 1, 1}, {}, {});
  }
  EXPECT_EQ(Recording(folder_).frames().size(), 2u);
}

}  // namespace
}  // namespace kestrel::records
