// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bench/horizon/horizon_stills.h"
#include "geometry/pose.h"
#include "vision/horizon/skyline.h"

// The answers to a sweep of stills, beside the truth.
namespace kestrel::bench {

// How a still is measured: by itself, or with "down" and height expected.
enum Way { kAlone, kExpecting };
inline constexpr std::array<const char*, 2> kWays = {"alone", "expecting"};

struct Answer {
  std::string result;  // "fix", or why there is none
  double roll_error_deg = 0, pitch_error_deg = 0;
  double roll_sigma_deg = 0, pitch_sigma_deg = 0;
  double error_deg = 0;  // between the true "down" and the measured
  double circle_seen = 0, agreement = 0, contrast = 0, rival = 0, dip_deg = 0;
  double cpu_ms = 0;
  bool fix() const { return result == "fix"; }
  bool Outlier() const;  // as the flights count them
};
Answer Judge(const vision::SkylineResult& result, const Eigen::Matrix3d& R_BC, const Pose& X_NB);

struct JudgedStill {
  Still still;
  StillLandscape landscape;
  Pose X_NB;             // the truth, at the place that was free
  double tilt_deg = 0;   // from level
  double ridge_deg = 0;  // how high the ridge's crest stands above the horizontal from there; 0: none does
  std::string sun;       // in view, outside, overcast
  std::array<Answer, 2> answers;
};

struct Statistics {
  int stills = 0, fixes = 0, outliers = 0;
  double roll_rmse_deg = 0, pitch_rmse_deg = 0, roll_bias_deg = 0, pitch_bias_deg = 0;
  double median_deg = 0, p95_deg = 0;  // of error_deg
  double within_2_sigma = 0;           // of rolls and pitches
  std::map<std::string, int> refused;
  double Share() const { return static_cast<double>(fixes) / std::max(stills, 1); }
};

// What the answers are sorted by: a still belongs to the range whose index of() tells, or to none (-1).
struct Factor {
  std::string name;
  std::vector<std::string> ranges;
  std::function<int(const JudgedStill&)> of;
};
std::vector<Factor> Factors();

Statistics StatisticsOf(const std::vector<JudgedStill>& all, Way way,
                        const std::function<bool(const JudgedStill&)>& among);

}  // namespace kestrel::bench
