// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/lens.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kestrel::sim::ray {
namespace {

TEST(LensOf, OneCameraHasOneThatIsAsItIsMade) {
  const vision::Pinhole camera{40, 30, 33, 34, 19.5, 14.5};
  const auto lens = LensOf(camera);
  EXPECT_EQ(LensOf(camera), lens);
  const Lens made = MakeLens(camera);
  ASSERT_EQ(made.stride, lens->stride);
  EXPECT_TRUE(std::equal(made.x.get(), made.x.get() + 31 * made.stride, lens->x.get()));
  EXPECT_EQ(made.pixel_rad, lens->pixel_rad);
}

TEST(LensOf, OtherNumbersAndOtherModelsAreOtherCameras) {
  const vision::Pinhole pinhole{40, 30, 33, 34, 19.5, 14.5};
  vision::Pinhole narrow = pinhole;
  narrow.max_angle_rad = 0.3;
  const vision::BrownConrady bent{
      .width_px = 40, .height_px = 30, .fx = 33, .fy = 34, .cx = 19.5, .cy = 14.5};
  const auto lens = LensOf(pinhole);
  EXPECT_NE(LensOf(narrow), lens);
  EXPECT_NE(LensOf(bent), lens);
}

}  // namespace
}  // namespace kestrel::sim::ray
