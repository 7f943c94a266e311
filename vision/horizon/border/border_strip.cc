// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/border/border_strip.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace kestrel::vision {

namespace {

constexpr int kNeeded = 6;  // px to either side of the line that must be in view
constexpr int kSectors = 6;
constexpr float kMostOdds = 2;  // nats that one sample may say
constexpr float kNoSky2 = 12;   // squared distance from the sky's colours, beyond which it is none
constexpr float kBend = 0.8f;   // nats that a step of 1 px from column to column costs, at most kMostBend
constexpr float kMostBend = 6;
constexpr int kMostStep = 12;  // px from column to column
constexpr float kEdge = 2.0f;  // nats of a plain edge
constexpr double kFloor = 12;  // of the colours' variance

struct Side {
  double n = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  void Add(const cv::Vec3f& c) {
    const Eigen::Vector3d x(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2]));
    n += 1, sum += x, square += x * x.transpose();
  }
  void Add(const Side& o, double share) {
    n += share * o.n, sum += share * o.sum, square += share * o.square;
  }
  Eigen::Vector3d Mean() const { return sum / std::max(n, 1e-3); }
  Eigen::Matrix3d Covariance() const {
    Eigen::Matrix3d out = square / std::max(n, 1e-3) - Mean() * Mean().transpose();
    out.diagonal().array() += kFloor;
    return out;
  }
};

// Log of the odds that a colour is sky.
struct SideJudge {
  Eigen::Vector3f sky, ground;
  Eigen::Matrix3f sky_root, ground_root;
  float offset = 0;
  SideJudge(const Side& above, const Side& below) {
    const auto whitener = [](const Eigen::Matrix3d& covariance, double& log_root) {
      const Eigen::Matrix3d L = covariance.llt().matrixL();
      log_root = L.diagonal().array().log().sum();
      return Eigen::Matrix3f(L.inverse().cast<float>());
    };
    double one = 0, two = 0;
    sky = above.Mean().cast<float>(), ground = below.Mean().cast<float>();
    sky_root = whitener(above.Covariance(), one), ground_root = whitener(below.Covariance(), two);
    offset = static_cast<float>(two - one);
  }
  float Odds(const cv::Vec3f& c) const {
    const Eigen::Vector3f x(c[0], c[1], c[2]);
    return 0.5f * ((ground_root * (x - ground)).squaredNorm() - (sky_root * (x - sky)).squaredNorm()) +
           offset;
  }
};

// Sky as it goes on from above: its colours by height, and how they scatter about that.
struct SkyJudge {
  Eigen::Matrix<double, 3, 2> model = Eigen::Matrix<double, 3, 2>::Zero();
  Eigen::Matrix3f root = Eigen::Matrix3f::Identity();
  bool knows = false;

  // Samples (height, colour) of weight 1.
  void Learn(const std::vector<std::pair<double, Eigen::Vector3d>>& samples) {
    if (samples.size() < 30) return;
    std::vector<double> weights(samples.size(), 1);
    for (int round = 0; round < 4; ++round) {
      Eigen::Matrix2d H = Eigen::Matrix2d::Identity() * 1e-6;
      H(1, 1) += 0.02 * static_cast<double>(samples.size());  // hardly any slope without need
      Eigen::Matrix<double, 3, 2> g = Eigen::Matrix<double, 3, 2>::Zero();
      double n = 0;
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const Eigen::Vector2d row(1, samples[i].first);
        H += weights[i] * row * row.transpose();
        g += weights[i] * samples[i].second * row.transpose();
        n += weights[i];
      }
      model = g * H.inverse();
      Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const Eigen::Vector3d r = samples[i].second - model * Eigen::Vector2d(1, samples[i].first);
        S += weights[i] * r * r.transpose();
      }
      S /= std::max(1.0, n);
      S.diagonal().array() += kFloor / 2;
      root = Eigen::Matrix3f(Eigen::Matrix3d(Eigen::Matrix3d(S.llt().matrixL()).inverse()).cast<float>());
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const Eigen::Vector3d r = samples[i].second - model * Eigen::Vector2d(1, samples[i].first);
        const double m2 = static_cast<double>((root * r.cast<float>()).squaredNorm());
        weights[i] = 1 / (1 + m2 / 4);
      }
    }
    knows = true;
  }
  float Odds(const cv::Vec3f& c, double height) const {
    const Eigen::Vector3f r =
        Eigen::Vector3f(c[0], c[1], c[2]) - (model * Eigen::Vector2d(1, height)).cast<float>();
    return (kNoSky2 - (root * r).squaredNorm()) / 4;
  }
};

}  // namespace

cv::Vec3f MeanColour(const cv::Vec3f* colour, int from, int to) {
  cv::Vec3f sum(0, 0, 0);
  for (int j = from; j <= to; ++j) sum += colour[j];
  return sum * (1.0f / static_cast<float>(to - from + 1));
}

Strip ReadStrip(const cv::Mat& view, const cv::Mat& shown, const SkyBorder& line, int below, int above) {
  const Eigen::Vector2d middle((view.cols - 1) / 2.0, (view.rows - 1) / 2.0);
  const Eigen::Vector2d foot = middle + (line.offset - line.normal.dot(middle)) * line.normal;
  const Eigen::Vector2d along(-line.normal.y(), line.normal.x());
  const int half = static_cast<int>(std::hypot(view.cols, view.rows) / 2) / kStripSpacing + 1;
  Strip strip;
  strip.first = -half * kStripSpacing;
  cv::Mat x(2 * half + 1, below + above + 1, CV_32FC1), y = x.clone();
  for (int i = 0; i < x.rows; ++i)
    for (int j = 0; j < x.cols; ++j) {
      const Eigen::Vector2d p = foot + (strip.first + i * kStripSpacing) * along + (j - below) * line.normal;
      x.at<float>(i, j) = static_cast<float>(p.x()), y.at<float>(i, j) = static_cast<float>(p.y());
    }
  cv::Mat bytes;
  cv::remap(view, bytes, x, y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::remap(shown, strip.shown, x, y, cv::INTER_NEAREST, cv::BORDER_CONSTANT, cv::Scalar(0));
  bytes.convertTo(strip.colour, CV_32FC3);
  cv::blur(strip.colour, strip.colour, {1, 3});
  return strip;
}

std::vector<double> BorderPath(const Strip& strip, int middle, const std::vector<double>& start, int gap,
                               bool of_sky) {
  const int n = strip.colour.rows, m = strip.colour.cols;
  std::vector<char> whole(static_cast<std::size_t>(n));
  int shown = 0;
  for (int i = 0; i < n; ++i) {
    whole[static_cast<std::size_t>(i)] = cv::countNonZero(strip.shown.row(i).colRange(
                                             middle - kNeeded, middle + kNeeded + 1)) == 2 * kNeeded + 1;
    shown += whole[static_cast<std::size_t>(i)];
  }
  std::vector<double> out(static_cast<std::size_t>(n), -1);
  if (shown < kLeastStripColumns) return out;
  // What the two sides look like, in sectors along the line.
  std::vector<std::array<Side, 2>> sectors(kSectors);
  std::array<Side, 2> all;
  std::vector<std::vector<std::pair<double, Eigen::Vector3d>>> skies(kSectors);
  std::vector<int> sector(static_cast<std::size_t>(n));
  int seen = 0;
  for (int i = 0; i < n; ++i) {
    if (!whole[static_cast<std::size_t>(i)]) continue;
    const int s = sector[static_cast<std::size_t>(i)] = seen++ * kSectors / shown;
    const auto* colour = strip.colour.ptr<cv::Vec3f>(i);
    const auto* visible = strip.shown.ptr<uchar>(i);
    for (int j = 0; j < m; ++j) {
      if (!visible[j]) continue;
      const double above = j - start[static_cast<std::size_t>(i)];
      if (std::abs(above) >= gap) sectors[static_cast<std::size_t>(s)][above > 0 ? 0 : 1].Add(colour[j]);
      if (of_sky && above >= gap)
        skies[static_cast<std::size_t>(s)].emplace_back(
            j - middle, Eigen::Vector3d(static_cast<double>(colour[j][0]), static_cast<double>(colour[j][1]),
                                        static_cast<double>(colour[j][2])));
    }
  }
  for (const auto& s : sectors)
    for (std::size_t k = 0; k < 2; ++k) all[k].Add(s[k], 1);
  std::vector<SideJudge> judges;
  std::vector<SkyJudge> sky_judges(kSectors);
  for (int s = 0; s < kSectors; ++s) {
    std::array<Side, 2> wide;
    for (std::size_t k = 0; k < 2; ++k) {
      for (int d = -1; d <= 1; ++d)
        if (s + d >= 0 && s + d < kSectors)
          wide[k].Add(sectors[static_cast<std::size_t>(s + d)][k], d ? 0.5 : 1.0);
      wide[k].Add(all[k], 0.05);
    }
    judges.emplace_back(wide[0], wide[1]);
    if (of_sky) sky_judges[static_cast<std::size_t>(s)].Learn(skies[static_cast<std::size_t>(s)]);
  }
  // Viterbi.
  cv::Mat from(n, m, CV_16SC1, cv::Scalar(0));
  std::vector<float> before(static_cast<std::size_t>(m), 0), value(static_cast<std::size_t>(m));
  int last = -1;
  std::vector<int> order;
  for (int i = 0; i < n; ++i) {
    if (!whole[static_cast<std::size_t>(i)]) continue;
    const auto* colour = strip.colour.ptr<cv::Vec3f>(i);
    const auto* visible = strip.shown.ptr<uchar>(i);
    const SideJudge& judge = judges[static_cast<std::size_t>(sector[static_cast<std::size_t>(i)])];
    const SkyJudge& sky_judge = sky_judges[static_cast<std::size_t>(sector[static_cast<std::size_t>(i)])];
    float sum = 0;
    const Eigen::Vector3f across = judge.sky - judge.ground;
    const float length = std::max(1.0f, across.norm());
    for (int j = 0; j < m; ++j) {  // border below sample j
      float odds = 0, edge = 0;
      if (visible[j]) {
        odds = of_sky && sky_judge.knows ? sky_judge.Odds(colour[j], j - middle) : judge.Odds(colour[j]);
        odds = std::clamp(odds, -kMostOdds, kMostOdds);
      }
      if (j >= 2 && j + 2 <= m && visible[j - 2] && visible[j + 1]) {
        const cv::Vec3f step = MeanColour(colour, j, j + 1) - MeanColour(colour, j - 2, j - 1);
        edge = (step[0] * across[0] + step[1] * across[1] + step[2] * across[2]) / (length * length);
      }
      value[static_cast<std::size_t>(j)] = visible[j] ? -sum + kEdge * std::clamp(edge, -1.0f, 1.0f) : -1e6f;
      sum += 2 * odds;
    }
    if (last >= 0) {
      const float apart = static_cast<float>(i - last);
      std::vector<float> now(static_cast<std::size_t>(m));
      for (int j = 0; j < m; ++j) {
        float best = -1e9f;
        int who = j;
        for (int k = std::max(0, j - kMostStep); k <= std::min(m - 1, j + kMostStep); ++k) {
          const float v = before[static_cast<std::size_t>(k)] -
                          std::min(kMostBend, kBend * static_cast<float>(std::abs(k - j)) / apart);
          if (v > best) best = v, who = k;
        }
        now[static_cast<std::size_t>(j)] = best + value[static_cast<std::size_t>(j)];
        from.at<short>(i, j) = static_cast<short>(who);
      }
      before = now;
    } else {
      before = value;
    }
    last = i;
    order.push_back(i);
  }
  int j = static_cast<int>(std::max_element(before.begin(), before.end()) - before.begin());
  for (std::size_t k = order.size(); k-- > 0;) {
    const int i = order[k];
    out[static_cast<std::size_t>(i)] = j;
    j = from.at<short>(i, j);
  }
  return out;
}

}  // namespace kestrel::vision
