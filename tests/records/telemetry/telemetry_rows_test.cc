// SPDX-License-Identifier: Apache-2.0
// What a telemetry.csv of ours says comes back, to the digits that it has.
#include "records/telemetry/telemetry_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "base/diagnostics.h"
#include "geometry/tait_bryan.h"
#include "records/recorder.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::records {
namespace {

using ::testing::HasSubstr;

mission::LogRow RowAt(double t_s) {
  mission::LogRow row;
  row.sequence = 4;
  row.exposure.t_s = t_s - 0.05, row.now.t_s = row.estimate.t_s = t_s;
  row.now.X_NB = {HeadingRotation(0.7), {t_s, 2, -3}};
  row.now.v_N = {1, 0, 0.5};
  row.now.wind_N = {4, 5, 6};
  row.exposure.X_NB = {HeadingRotation(0.7), {t_s - 0.05, 2, -3}};
  row.exposure.X_NT = {HeadingRotation(0.2), {8, 9, 0}};
  row.estimate.p_NB = {1, 2, 3};
  row.estimate.R_NB = Eigen::Quaterniond(RotationFromTaitBryan({0.3, -0.1, 0.2}));
  row.decision.phase = "descend";
  row.decision.fix = mission::TargetFix{.p_TB = {0.1, 0.2, -3}, .yaw_TB = 0.4};
  row.decision.setpoint = control::AttitudeSetpoint{0.1, 0.2, 0.3, 0.6};
  return row;
}

class TelemetryRowsTest : public InTemporaryFolder {
 protected:
  std::filesystem::path file() const { return folder_ / "telemetry.csv"; }
  void Write(const std::string& text) const { std::ofstream(file()) << text; }
  std::string Refusal() const {
    try {
      ReadTelemetry(file(), {});
    } catch (const InputError& e) {
      return e.what();
    }
    return "read";
  }
};

TEST_F(TelemetryRowsTest, AreThoseThatWereWritten) {
  Write(TelemetryHeader() + '\n' + TelemetryLine(RowAt(1)) + '\n' + TelemetryLine(RowAt(1.1)) + '\n');
  const Pose X_BC{HeadingRotation(0.1), {0, 0, 0.05}};
  const TelemetryRows read = ReadTelemetry(file(), X_BC);
  EXPECT_TRUE(read.truth);
  ASSERT_EQ(read.rows.size(), 2u);
  const mission::LogRow &row = read.rows[1], was = RowAt(1.1);
  EXPECT_EQ(row.sequence, 4);
  EXPECT_EQ(row.now.t_s, 1.1);
  EXPECT_EQ(row.decision.phase, "descend");
  EXPECT_LT((row.now.X_NB.p - was.now.X_NB.p).norm(), 1e-8);
  EXPECT_LT(row.now.X_NB.R.angularDistance(was.now.X_NB.R), 1e-8);
  EXPECT_LT(row.estimate.R_NB.angularDistance(was.estimate.R_NB), 1e-8);
  EXPECT_EQ(row.now.wind_N, was.now.wind_N);
  ASSERT_TRUE(row.decision.fix);
  EXPECT_NEAR(row.decision.fix->yaw_TB, 0.4, 1e-8);
  ASSERT_TRUE(row.decision.setpoint);
  const auto* attitude = std::get_if<control::AttitudeSetpoint>(&*row.decision.setpoint);
  ASSERT_TRUE(attitude);
  EXPECT_NEAR(attitude->roll, 0.1, 1e-8);
  EXPECT_NEAR(attitude->yaw_rate, 0.3, 1e-8);
  EXPECT_NEAR(attitude->thrust, 0.6, 1e-8);
  // Between the two rows, and by the target there.
  EXPECT_LT((row.exposure.X_NB.p - was.exposure.X_NB.p).norm(), 1e-8);
  EXPECT_LT((row.exposure.X_NC.p - (was.exposure.X_NB * X_BC).p).norm(), 1e-8);
  EXPECT_LT((row.exposure.X_NT.p - was.exposure.X_NT.p).norm(), 1e-7);
}

TEST_F(TelemetryRowsTest, OfARealAircraftThereIsNoTruth) {
  const TelemetryOptions real = {.truth = false, .safety = true};
  mission::LogRow unheard = RowAt(1), heard = RowAt(1.1);
  unheard.heard = false;
  Write(TelemetryHeader(real) + '\n' + TelemetryLine(unheard, real) + '\n' + TelemetryLine(heard, real) +
        '\n');
  const TelemetryRows read = ReadTelemetry(file(), {});
  EXPECT_FALSE(read.truth);
  ASSERT_EQ(read.rows.size(), 2u);
  EXPECT_FALSE(read.rows[0].heard);
  EXPECT_TRUE(read.rows[1].heard);
  EXPECT_EQ(read.rows[1].estimate.p_NB, heard.estimate.p_NB);
}

TEST_F(TelemetryRowsTest, WhatIsWrongIsRefusedWithItsLine) {
  EXPECT_THAT(Refusal(), HasSubstr("telemetry.csv"));
  Write("a,b,c\n1,2,3\n");
  EXPECT_THAT(Refusal(), HasSubstr("is no telemetry"));
  const std::string header = TelemetryHeader() + '\n', line = TelemetryLine(RowAt(1)) + '\n';
  Write(header + TelemetryLine(RowAt(1.5)) + '\n' + line);
  EXPECT_THAT(Refusal(), HasSubstr("telemetry.csv:3: t_s: 1 is before"));
  Write(header + line.substr(0, line.size() / 2) + '\n');
  EXPECT_THAT(Refusal(), HasSubstr("telemetry.csv:2"));
  std::string other = line;
  other.replace(0, 1, "four");
  Write(header + other);
  EXPECT_THAT(Refusal(), HasSubstr("'four' is no number"));
}

}  // namespace
}  // namespace kestrel::records
