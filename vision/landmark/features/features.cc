// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/features/features.h"

#include <algorithm>
#include <opencv2/features2d.hpp>
#include <opencv2/flann.hpp>
#include <stdexcept>

#ifndef KESTREL_WITHOUT_DLIB
#include "vision/landmark/features/surf.h"
#endif

namespace kestrel::vision {
namespace {

constexpr std::uint64_t kForestSeed = 12345;
constexpr int kTrees = 4;    // of the forest, among which the best bins are shared
constexpr int kLeaves = 96;  // that a search looks at

// FLANN draws from OpenCV's generator of this thread: it starts from a fixed seed, and is put back.
class FixedSeed {
 public:
  FixedSeed() : kept_(cv::theRNG()) { cv::theRNG() = cv::RNG(kForestSeed); }
  ~FixedSeed() { cv::theRNG() = kept_; }
  FixedSeed(const FixedSeed&) = delete;
  FixedSeed& operator=(const FixedSeed&) = delete;

 private:
  cv::RNG kept_;
};

// For each row of a the two nearest of b, the nearest first; fewer where b has fewer.
std::vector<std::vector<cv::DMatch>> NearestTwo(const cv::Mat& a, const cv::Mat& b, FeatureMatcher matcher) {
  std::vector<std::vector<cv::DMatch>> nearest;
  const bool bits = a.depth() == CV_8U;
  if (matcher == FeatureMatcher::kBruteForce || b.rows < 2) {
    cv::BFMatcher(bits ? cv::NORM_HAMMING : cv::NORM_L2).knnMatch(a, b, nearest, 2);
    return nearest;
  }
  const FixedSeed fixed;
  cv::Ptr<cv::flann::IndexParams> index;
  if (bits)
    index = cv::makePtr<cv::flann::LshIndexParams>(12, 20, 2);
  else
    index = cv::makePtr<cv::flann::KDTreeIndexParams>(kTrees);
  cv::FlannBasedMatcher(index, cv::makePtr<cv::flann::SearchParams>(kLeaves)).knnMatch(a, b, nearest, 2);
  return nearest;
}

}  // namespace

const std::vector<std::string>& FeatureDetectorNames() {
  static const std::vector<std::string> names = {"sift", "surf", "orb", "akaze"};
  return names;
}

std::optional<FeatureDetector> FeatureDetectorNamed(const std::string& name) {
  const auto& names = FeatureDetectorNames();
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) return std::nullopt;
  return static_cast<FeatureDetector>(at - names.begin());
}

const std::string& NameOf(FeatureDetector detector) {
  return FeatureDetectorNames()[static_cast<std::size_t>(detector)];
}

bool IsAvailable([[maybe_unused]] FeatureDetector detector) {
#ifdef KESTREL_WITHOUT_DLIB
  return detector != FeatureDetector::kSurf;
#else
  return true;
#endif
}

Features Detect(const cv::Mat& grey, const FeatureOptions& options) {
  if (!IsAvailable(options.detector)) throw std::invalid_argument("this build has no dlib, and so no SURF");
  cv::Ptr<cv::Feature2D> detector;
  switch (options.detector) {
    case FeatureDetector::kSurf:
#ifndef KESTREL_WITHOUT_DLIB
      return DetectSurf(grey, options.max_features);
#endif
      break;
    case FeatureDetector::kSift:
      detector = cv::SIFT::create(options.max_features);
      break;
    case FeatureDetector::kOrb:
      detector = cv::ORB::create(options.max_features);
      break;
    case FeatureDetector::kAkaze:
      detector = cv::AKAZE::create();
      break;
  }
  Features found;
  if (options.detector != FeatureDetector::kAkaze) {
    detector->detectAndCompute(grey, cv::noArray(), found.points, found.descriptors);
    return found;
  }
  // It has no limit of its own.
  detector->detect(grey, found.points);
  cv::KeyPointsFilter::retainBest(found.points, options.max_features);
  detector->compute(grey, found.points, found.descriptors);
  return found;
}

std::vector<Match> MatchFeatures(const Features& a, const Features& b, const MatchOptions& options) {
  std::vector<Match> matches;
  if (a.points.empty() || b.points.empty()) return matches;
  std::vector<int> back;  // for each of b the nearest of a
  if (options.mutual) {
    back.assign(b.points.size(), -1);
    for (const auto& nearest : NearestTwo(b.descriptors, a.descriptors, options.matcher)) {
      if (!nearest.empty()) back[nearest[0].queryIdx] = nearest[0].trainIdx;
    }
  }
  for (const auto& nearest : NearestTwo(a.descriptors, b.descriptors, options.matcher)) {
    if (nearest.empty()) continue;
    const cv::DMatch& best = nearest[0];
    if (options.ratio < 1 && (nearest.size() < 2 || !(best.distance < options.ratio * nearest[1].distance)))
      continue;
    if (options.mutual && back[best.trainIdx] != best.queryIdx) continue;
    matches.push_back({best.queryIdx, best.trainIdx, best.distance});
  }
  return matches;
}

}  // namespace kestrel::vision
