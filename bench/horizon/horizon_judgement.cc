// SPDX-License-Identifier: Apache-2.0
#include "bench/horizon/horizon_judgement.h"

#include <algorithm>
#include <cmath>

#include "base/statistics.h"

namespace kestrel::bench {
namespace {

constexpr double kOutlier_deg = 5;

// Ranges between limits, the last one included.
Factor Between(const std::string& name, const std::string& unit, const std::vector<double>& limits,
               const std::function<double(const JudgedStill&)>& value) {
  Factor factor{name, {}, {}};
  for (std::size_t k = 0; k + 1 < limits.size(); ++k) {
    std::string range = std::to_string(std::lround(limits[k])) + " to " +
                        std::to_string(std::lround(limits[k + 1])) + " " + unit;
    factor.ranges.push_back(range);
  }
  factor.of = [limits, value](const JudgedStill& s) {
    const auto above = std::upper_bound(limits.begin() + 1, limits.end() - 1, value(s));
    return static_cast<int>(above - limits.begin()) - 1;
  };
  return factor;
}

Factor Named(const std::string& name, const std::vector<std::string>& names,
             const std::function<std::string(const JudgedStill&)>& value) {
  return {name, names, [names, value](const JudgedStill& s) {
            const auto found = std::find(names.begin(), names.end(), value(s));
            return found == names.end() ? -1 : static_cast<int>(found - names.begin());
          }};
}

}  // namespace

bool Answer::Outlier() const { return fix() && std::hypot(roll_error_deg, pitch_error_deg) > kOutlier_deg; }

Answer Judge(const vision::SkylineResult& result, const Eigen::Matrix3d& R_BC, const Pose& X_NB) {
  Answer answer;
  if (const auto* reason = std::get_if<vision::NoSkyline>(&result)) {
    answer.result = vision::NameOf(*reason);
    return answer;
  }
  const auto& fix = std::get<vision::SkylineFix>(result);
  const Eigen::Vector3d down_B = R_BC * fix.down_C;
  const vision::RollPitch measured =
      vision::RollPitchFromDown(down_B, R_BC * fix.covariance * R_BC.transpose());
  const TaitBryan truth = TaitBryanFromRotation(X_NB.R.toRotationMatrix());
  const Eigen::Vector3d true_down_B = X_NB.R.conjugate() * Eigen::Vector3d::UnitZ();
  answer.result = "fix";
  answer.roll_error_deg = Degrees(WrapAngle(measured.roll - truth.roll));
  answer.pitch_error_deg = Degrees(measured.pitch - truth.pitch);
  answer.roll_sigma_deg = Degrees(std::sqrt(measured.covariance(0, 0)));
  answer.pitch_sigma_deg = Degrees(std::sqrt(measured.covariance(1, 1)));
  answer.error_deg = Degrees(std::atan2(down_B.cross(true_down_B).norm(), down_B.dot(true_down_B)));
  answer.circle_seen = fix.circle_seen;
  answer.agreement = fix.agreement;
  answer.contrast = fix.contrast;
  answer.rival = fix.rival;
  answer.dip_deg = Degrees(fix.dip);
  return answer;
}

std::vector<Factor> Factors() {
  std::vector<Factor> factors;
  factors.push_back(Named("world", {"autumn_clear", "winter_cloudy", "winter_sunset", "summer_sun"},
                          [](const JudgedStill& s) { return s.landscape.world; }));
  factors.push_back(Between("height", "m", {2, 6, 20, 60, 200, 500},
                            [](const JudgedStill& s) { return s.still.height_m; }));
  factors.push_back(
      Between("tilt", "deg", {0, 15, 30, 45, 60}, [](const JudgedStill& s) { return s.tilt_deg; }));
  Factor ridge = Between("ridge", "deg", {-90, 0, 3, 6, 10},
                         [](const JudgedStill& s) { return s.ridge_deg > 0 ? s.ridge_deg : -1; });
  ridge.ranges[0] = "none";
  factors.push_back(ridge);
  factors.push_back(Between("haze", "km", {0, 5, 15, 40, 105},
                            [](const JudgedStill& s) { return s.landscape.parameters.haze_m / 1000; }));
  factors.push_back(
      Named("sun", {"in view", "outside", "overcast"}, [](const JudgedStill& s) { return s.sun; }));
  return factors;
}

Statistics StatisticsOf(const std::vector<JudgedStill>& all, Way way,
                        const std::function<bool(const JudgedStill&)>& among) {
  Statistics s;
  std::vector<double> errors;
  double roll = 0, pitch = 0, roll2 = 0, pitch2 = 0;
  int within = 0;
  for (const JudgedStill& still : all) {
    if (!among(still)) continue;
    ++s.stills;
    const Answer& a = still.answers[way];
    if (!a.fix()) {
      ++s.refused[a.result];
      continue;
    }
    ++s.fixes;
    s.outliers += a.Outlier();
    roll += a.roll_error_deg, roll2 += a.roll_error_deg * a.roll_error_deg;
    pitch += a.pitch_error_deg, pitch2 += a.pitch_error_deg * a.pitch_error_deg;
    within += std::abs(a.roll_error_deg) <= 2 * a.roll_sigma_deg;
    within += std::abs(a.pitch_error_deg) <= 2 * a.pitch_sigma_deg;
    errors.push_back(a.error_deg);
  }
  const double n = std::max(s.fixes, 1);
  s.roll_bias_deg = roll / n, s.pitch_bias_deg = pitch / n;
  s.roll_rmse_deg = std::sqrt(roll2 / n), s.pitch_rmse_deg = std::sqrt(pitch2 / n);
  s.median_deg = Quantile(errors, 0.5), s.p95_deg = Quantile(errors, 0.95);
  s.within_2_sigma = within / (2 * n);
  return s;
}

}  // namespace kestrel::bench
