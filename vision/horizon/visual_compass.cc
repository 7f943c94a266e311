// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/visual_compass.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "geometry/tait_bryan.h"

namespace kestrel::vision {

namespace {
constexpr double kMinSeen = 0.08;  // share of the azimuths
constexpr double kSlack = 0.03;    // rad
}  // namespace

const char* NameOf(NoHeading reason) {
  switch (reason) {
    case NoHeading::kNoVertical:
      return "no_vertical";
    case NoHeading::kTooLittle:
      return "too_little_seen";
    case NoHeading::kNothingMatches:
      return "nothing_matches";
    case NoHeading::kAmbiguous:
      return "ambiguous";
  }
  return "";
}

VisualCompass::VisualCompass(const CameraModel& camera, const Eigen::Matrix3d& R_BC, const cv::Mat& forbidden,
                             const CompassOptions& options)
    : maker_(camera, R_BC, forbidden), options_(options) {}

void VisualCompass::Forget() {
  keyframes_.clear();
  last_.reset();
  current_ = next_other_ = 0;
  total_ = 0;
}

VisualCompass::Guess VisualCompass::Compare(const Keyframe& k, const StripReference& now,
                                            const std::optional<Expected>& expected) const {
  const std::vector<float> likeness = TurnLikeness(k.reference, now);
  const auto n = static_cast<int>(likeness.size());
  const double per = 2 * M_PI / n;
  Guess guess;
  const double reach = expected ? 3 * std::hypot(expected->sigma, std::sqrt(k.variance)) + kSlack : 0;
  int best = 0;
  double best_score = -2;
  for (int i = 0; i < n; ++i) {
    const auto score = static_cast<double>(likeness[static_cast<std::size_t>(i)]);
    if (expected && std::abs(WrapAngle(i * per + k.heading - expected->turn)) > reach) continue;
    if (score > best_score) best_score = score, best = i;
  }
  guess.likeness = best_score;
  guess.turn = WrapAngle(best * per);
  if (!expected)
    for (int i = 0; i < n; ++i) {
      const int off = std::min((i - best + n) % n, (best - i + n) % n);
      if (off * per > Radians(12) && static_cast<double>(likeness[static_cast<std::size_t>(i)]) >
                                         options_.ambiguous_share * guess.likeness)
        guess.ambiguous = true;
    }
  return guess;
}

std::vector<std::size_t> VisualCompass::ToCompare() {
  std::vector<std::size_t> out{current_};
  const auto most =
      std::min<std::size_t>(keyframes_.size(), static_cast<std::size_t>(options_.matched_each_frame));
  if (out.size() < most && current_ != 0) out.push_back(0);  // the one that knows the heading without error
  for (std::size_t tried = 0; out.size() < most && tried < keyframes_.size(); ++tried) {
    next_other_ = (next_other_ + 1) % keyframes_.size();
    if (std::find(out.begin(), out.end(), next_other_) == out.end()) out.push_back(next_other_);
  }
  return out;
}

void VisualCompass::Learn(const StripReference& now, double heading, double variance) {
  if (keyframes_.size() >= static_cast<std::size_t>(options_.max_keyframes)) {
    // Gives up the least certain, but never the first.
    const auto worst =
        std::max_element(keyframes_.begin() + 1, keyframes_.end(),
                         [](const Keyframe& a, const Keyframe& b) { return a.variance < b.variance; });
    keyframes_.erase(worst);
  }
  keyframes_.push_back({now, heading, variance});
  current_ = keyframes_.size() - 1;
}

CompassResult VisualCompass::Turn(const cv::Mat& image, const std::optional<Eigen::Vector3d>& down_C,
                                  const std::optional<Expected>& expected) {
  if (!down_C) return NoHeading::kNoVertical;
  last_strip_ = maker_.Make(image, *down_C);
  if (last_strip_.seen < kMinSeen) return NoHeading::kTooLittle;
  StripReference now = MakeReference(last_strip_);
  CompassHeading heading;
  if (keyframes_.empty()) {
    Learn(now, 0, 0);
    last_ = Keyframe{std::move(now), 0, 0};
    heading.likeness = 1;
    heading.learnt = true;
    return heading;
  }
  Guess best;
  double best_sigma = 1e9, most_alike = -1;
  bool ambiguous = false;
  for (const std::size_t k : ToCompare()) {
    Guess guess = Compare(keyframes_[k], now, expected);
    guess.keyframe = k;
    most_alike = std::max(most_alike, guess.likeness);
    if (guess.likeness < options_.lost_below) continue;
    if (guess.ambiguous) {
      ambiguous = true;
      continue;
    }
    // What the heading by this keyframe is worth: the keyframe's own error and that of the comparison.
    const double matched = Radians(0.1 + 2 * (1 - guess.likeness));
    const double sigma = std::sqrt(keyframes_[k].variance + matched * matched);
    if (sigma < best_sigma) best_sigma = sigma, best = guess;
  }
  const Keyframe* k = best.likeness < 0 ? nullptr : &keyframes_[best.keyframe];
  TurnFit fit;
  if (k) fit = RefineTurn(k->reference, now, best.turn);
  if (!fit.good || fit.likeness < options_.lost_below) {
    const Guess guess = Compare(*last_, now, expected);
    ambiguous |= guess.ambiguous && guess.likeness >= options_.lost_below;
    if (guess.likeness < options_.lost_below || guess.ambiguous)
      return ambiguous ? NoHeading::kAmbiguous : NoHeading::kNothingMatches;
    k = &*last_;
    fit = RefineTurn(k->reference, now, guess.turn);
    if (!fit.good || fit.likeness < options_.lost_below) return NoHeading::kNothingMatches;
    most_alike = -1;
  } else {
    current_ = best.keyframe;
  }
  const double about = expected ? expected->turn : total_;  // which of the whole turns
  total_ = about + WrapAngle(k->heading + fit.turn - about);
  heading.turned = total_;
  heading.variance = k->variance + fit.variance;
  heading.likeness = fit.likeness;
  heading.keyframe = static_cast<int>(current_);
  if (k == &*last_ || std::max(most_alike, fit.likeness) < options_.new_keyframe_below) {
    // Where both err on their own way, a keyframe is better by both.
    double learnt = total_, variance = heading.variance;
    if (expected) {
      const double share = variance / (variance + expected->sigma * expected->sigma);
      learnt += share * WrapAngle(expected->turn - total_);
      variance *= 1 - share / 2;  // but the expected heading comes from this compass too
    }
    Learn(now, learnt, variance);
    heading.learnt = true;
  }
  last_ = Keyframe{std::move(now), total_, heading.variance};
  return heading;
}

}  // namespace kestrel::vision
