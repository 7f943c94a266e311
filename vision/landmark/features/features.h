// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

// Features of an image, and pairs of those that look alike, thesis 3.2.2. Both depend on nothing but what they
// are given: the same images give the same bits, on any number of threads.
namespace kestrel::vision {

enum class FeatureDetector {
  kSift,   // Lowe 2004: 128 numbers a feature
  kSurf,   // Bay et al. 2006, by dlib: 64 numbers
  kOrb,    // Rublee et al. 2011: 256 bits
  kAkaze,  // Alcantarilla et al. 2013: 486 bits
};

// Their names in files, "sift" and so on, in the order above.
const std::vector<std::string>& FeatureDetectorNames();
// None: no such name.
std::optional<FeatureDetector> FeatureDetectorNamed(const std::string& name);
const std::string& NameOf(FeatureDetector detector);
// Whether this build has it: SURF needs dlib.
bool IsAvailable(FeatureDetector detector);

struct FeatureOptions {
  FeatureDetector detector = FeatureDetector::kSift;
  int max_features = 1000;  // the strongest
};

struct Features {
  std::vector<cv::KeyPoint> points;  // px
  cv::Mat descriptors;               // a row each; CV_32F, or CV_8U for bits
};

// The features of an image, CV_8UC1. Throws std::invalid_argument for a detector that this build lacks.
Features Detect(const cv::Mat& grey, const FeatureOptions& options);

enum class FeatureMatcher {
  kBruteForce,  // compares every pair
  kKdTree,  // of a and b: best bin first (Beis and Lowe 1997), which may miss the nearest; of bits, by hashes
};

struct MatchOptions {
  FeatureMatcher matcher = FeatureMatcher::kBruteForce;
  float ratio = 0.8F;   // a match's distance is below this share of the second nearest's (Lowe); 1: any
  bool mutual = false;  // each must be the nearest of the other
};

struct Match {
  int a, b;  // which of the features
  float distance;
  friend bool operator==(const Match&, const Match&) = default;
};

// For each feature of a the nearest of b, where it is distinct; in the order of a. The detector of both is the
// same.
std::vector<Match> MatchFeatures(const Features& a, const Features& b, const MatchOptions& options);

}  // namespace kestrel::vision
