// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/mosaic_report.h"

#include <gmock/gmock.h>

namespace kestrel::app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(MosaicReport, WhatIsInNoMosaicIsNamedWithWhatToDo) {
  MosaicArguments arguments;
  MosaicCount count;
  count.frames = 20, count.placed = 9;
  count.of_state = {{"followed", 9}, {"no_texture", 4}, {"full", 5}, {"lost", 2}};
  const std::string report = MosaicReport(arguments, count, 0.5, {"mosaic 1: 640 x 480 pixels"});
  EXPECT_THAT(report, HasSubstr("20 images, 9 in a mosaic, 9 followed, 5 full, 2 lost, 4 no_texture\n"));
  EXPECT_THAT(report, HasSubstr("4 no_texture: nothing can be followed"));
  EXPECT_THAT(report, HasSubstr("5 full: memory is used up; more --memory-mb"));
  EXPECT_THAT(report, HasSubstr("2 lost: nothing before shows the same"));
  EXPECT_THAT(report, Not(HasSubstr("oblique")));
  EXPECT_THAT(report, HasSubstr("mosaic 1: 640 x 480 pixels\n"));
}

TEST(MosaicReport, OneImageIsTold) {
  MosaicCount count;
  count.frames = count.placed = 1;
  count.of_state = {{"first", 1}};
  const std::string report = MosaicReport({}, count, 0, {});
  EXPECT_THAT(report, HasSubstr("1 image, 1 in a mosaic"));
  EXPECT_THAT(report, HasSubstr("no images were joined: a mosaic of one image is that image"));
  count.placed = 0, count.of_state = {{"no_texture", 1}};
  EXPECT_THAT(MosaicReport({}, count, 0, {}), HasSubstr("no image is in a mosaic, and nothing is written"));
}

TEST(MosaicReport, PosesThatCannotBeAreToldWithTheirOption) {
  MosaicArguments arguments;
  arguments.poses = "poses.csv";
  MosaicCount count;
  count.below_ground = 3, count.against_pose = 1, count.poses_over = 1;
  const std::string report = MosaicReport(arguments, count, 0, {});
  EXPECT_THAT(report, HasSubstr("not above the ground by poses.csv: 3 images, whose poses are not used; "
                                "--ground-down-m is 0"));
  EXPECT_THAT(report, HasSubstr("against poses.csv: 1 image"));
  EXPECT_THAT(report, HasSubstr("left over in poses.csv: 1 pose;"));
}

TEST(MosaicReport, MemoryIsToldBeforehandInPartsOfAMegapixel) {
  vision::MosaicOptions options;
  options.most_bytes = 25'000'000;
  EXPECT_THAT(MosaicMemory(50, options, {640, 480}), HasSubstr("up to 10 images are kept"));
  EXPECT_THAT(MosaicMemory(50, options, {640, 480}), HasSubstr("beyond 0.8 megapixels"));
}

}  // namespace
}  // namespace kestrel::app
