// SPDX-License-Identifier: Apache-2.0
#include "bench/limits/frame_bounds.h"

#include <gtest/gtest.h>

#include "bench/limits/frame_stages.h"
#include "bench/timings/timed_scene.h"

namespace kestrel::bench {
namespace {

MachineRates Machine() {
  return {.instruction_set = "",
          .multiply_adds_gflop_s = 43,
          .divisions_per_ns = 1,
          .memory = {{"near", 1 << 20, 100, 1000}, {"far", 1 << 28, 10, 10}}};
}

TEST(FrameBounds, AreBytesPlacesAndOperationsByWhatTheMachineGives) {
  // A million pixels of 15 bytes and 43 operations: from far memory, for so many bytes are not near.
  const FrameBounds plain = BoundsOf({.pixels = 1e6}, Machine());
  EXPECT_NEAR(plain.memory_ms, 1.5, 1e-9);
  EXPECT_NEAR(plain.random_ms, 0, 1e-9);
  EXPECT_NEAR(plain.arithmetic_ms, 1, 1e-9);
  EXPECT_EQ(plain.Least(), plain.memory_ms);
  // Texels are 3 bytes, found at two places for each pixel.
  const FrameBounds textured = BoundsOf({.pixels = 1e6, .textured = 1e6}, Machine());
  EXPECT_NEAR(textured.memory_ms, 1.8, 1e-9);
  EXPECT_NEAR(textured.random_ms, 2, 1e-9);
  EXPECT_GT(textured.arithmetic_ms, plain.arithmetic_ms);
  EXPECT_EQ(textured.Least(), textured.arithmetic_ms);
  // An edge costs arithmetic alone.
  const FrameBounds edged = BoundsOf({.pixels = 1e6, .at_edges = 1e5}, Machine());
  EXPECT_EQ(edged.memory_ms, plain.memory_ms);
  EXPECT_GT(edged.arithmetic_ms, plain.arithmetic_ms);
}

TEST(MachineRates, OfABufferAreThoseOfTheNextLargerOne) {
  EXPECT_EQ(RateFor(Machine(), 1000).level, "near");
  EXPECT_EQ(RateFor(Machine(), 1 << 20).level, "near");
  EXPECT_EQ(RateFor(Machine(), (1 << 20) + 1).level, "far");
  EXPECT_EQ(RateFor(Machine(), 1e12).level, "far");
}

TEST(StagedRenderer, DrawsWhatTheRayRendererDraws) {
  const vision::CameraModel camera = vision::Pinhole{100, 75, 82, 82, 49.5, 36.8};
  const StagedFrame staged = StagedRenderer("hover_ground_camera", camera).Draw(PathPose(3, 1));
  TimedScene scene("hover_ground_camera", camera);
  EXPECT_EQ(cv::norm(staged.picture, scene.Draw(PathPose(3, 1)), cv::NORM_INF), 0);
  EXPECT_EQ(staged.content.pixels, 100 * 75);
  EXPECT_GT(staged.content.at_edges, 0);
  EXPECT_GT(staged.content.textured, 0);
}

}  // namespace
}  // namespace kestrel::bench
