// SPDX-License-Identifier: Apache-2.0
#include "bench/enhance/mosaic_judgement.h"

#include <gtest/gtest.h>

#include <optional>

#include "bench/enhance/mosaic_drawings.h"
#include "vision/enhance/mosaic/mosaic.h"

namespace kestrel::bench {
namespace {

constexpr std::uint64_t kSeed = 1;

// Of a camera whose poses are known.
struct TrueMosaic {
  DrawnSurvey survey{120, kSeed};
  std::optional<vision::Mosaic> mosaic;
  vision::MosaicPicture picture;
};

const TrueMosaic& True() {
  static const TrueMosaic made = [] {
    TrueMosaic to;
    vision::MosaicOptions options;
    options.camera = kMosaicCamera;
    options.pose_sigma_m = options.pose_sigma_deg = 0.01;
    to.mosaic.emplace(options);
    for (int i = 0; i < to.survey.images(); ++i)
      to.mosaic->Add(to.survey.Draw(i), 0.1 * i, to.survey.X_NC(i));
    to.mosaic->Adjust();
    to.picture = to.mosaic->Picture();
    return to;
  }();
  return made;
}

SurveyErrors Judge(const vision::MosaicPicture& picture) {
  return JudgeSurvey(True().survey, *True().mosaic, picture, false, kSeed);
}

// The corners near its rim too.
TEST(MosaicJudgement, ATruePictureIsFoundTrue) {
  const SurveyErrors errors = Judge(True().picture);
  EXPECT_LT(errors.placed_px, 0.5);
  EXPECT_LT(errors.picture_px, 0.5);
  EXPECT_GE(errors.points, 190);
}

TEST(MosaicJudgement, APictureThatLiesElsewhereIsOffByThat) {
  vision::MosaicPicture picture = True().picture;
  picture.origin += Eigen::Vector2d(6, -8);
  const SurveyErrors errors = Judge(picture);
  EXPECT_LT(errors.placed_px, 0.5);
  EXPECT_NEAR(errors.picture_px, 10, 0.3);
}

TEST(MosaicJudgement, WhatIsNotFoundIsNotLeftOut) {
  vision::MosaicPicture picture = True().picture;
  picture.image = cv::Mat(picture.image.size(), CV_8UC1, cv::Scalar(90));
  const SurveyErrors errors = Judge(picture);
  EXPECT_EQ(errors.points, 0);
  EXPECT_NEAR(errors.picture_px, 40, 1e-9);
}

}  // namespace
}  // namespace kestrel::bench
