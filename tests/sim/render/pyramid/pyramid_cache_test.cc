// SPDX-License-Identifier: Apache-2.0
#include "sim/render/pyramid/pyramid_cache.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sim/world/mjcf.h"

namespace kestrel::sim {
namespace {

// With a texture of these colours, and one that all of them have.
ModelPtr Painted(const char* rgb) {
  CompiledModel compiled = CompileMjcf(
      std::string(
          R"(<mujoco><asset><texture name="own" type="2d" builtin="flat" width="8" height="8" rgb1=")") +
      rgb + R"("/><texture name="common" type="2d" builtin="flat" width="16" height="16" rgb1="0 0 1"/>
      </asset><worldbody/></mujoco>)");
  EXPECT_TRUE(compiled.model) << compiled.message;
  return std::move(compiled.model);
}

TEST(KeptPyramids, TheSamePicturesAreMadeOnce) {
  const ModelPtr first = Painted("1 0 0"), second = Painted("1 0 0");
  const auto made = ray::PyramidCache(first.get()).Of(0);
  EXPECT_EQ(ray::PyramidCache(second.get()).Of(0), made);
  EXPECT_NE(ray::PyramidCache(second.get()).Of(1), made);
}

TEST(KeptPyramids, OtherPicturesAreOthersAndTexelsAreTheirs) {
  const ModelPtr red = Painted("1 0 0"), green = Painted("0 1 0");
  const auto of_red = ray::PyramidCache(red.get()).Of(0), of_green = ray::PyramidCache(green.get()).Of(0);
  EXPECT_NE(of_red, of_green);
  EXPECT_EQ(of_green->texels, ray::MakePyramid(green.get(), 0).texels);
  EXPECT_NE(of_green->texels, of_red->texels);
}

// Of noise in grey, but for the colour of its first texel.
ModelPtr Noise(int colour) {
  ModelPtr model = Painted("0 0 0");
  for (int texel = 0; texel < 64; ++texel)
    std::fill_n(model->tex_rgb + model->tex_adr[0] + 3 * texel, 3, static_cast<mjtByte>(texel * 37 % 256));
  model->tex_rgb[model->tex_adr[0]] = static_cast<mjtByte>(colour);
  return model;
}

TEST(Pyramid, AGreyPictureHasInOneByteTheTexelsThatItHasInColours) {
  const ray::Pyramid grey = ray::MakePyramid(Noise(0).get(), 0), red = ray::MakePyramid(Noise(200).get(), 0);
  EXPECT_TRUE(grey.texels.empty());
  EXPECT_TRUE(red.grey_texels.empty());
  ASSERT_EQ(grey.grey_texels.size(),
            red.texels.size() + 5);  // what may be read beyond the last: 7 bytes, and 2 texels
  for (std::size_t i = 0; i + 2 < red.texels.size(); ++i) {
    EXPECT_EQ(grey.grey_texels[i], red.texels[i].blue) << i;
    EXPECT_EQ(grey.grey_texels[i], red.texels[i].green) << i;
  }
}

// A cube of so many pictures, all of one colour.
ModelPtr Cube(int pictures) {
  CompiledModel compiled = CompileMjcf(
      R"(<mujoco><asset><texture name="own" type="cube" builtin="flat" width="8" height="48" rgb1="0.2 0.4 0.6" rgb2="0.2 0.4 0.6"/>
      </asset><worldbody/></mujoco>)");
  EXPECT_TRUE(compiled.model) << compiled.message;
  compiled.model->tex_height[0] = 8 * pictures;  // the compiler makes six
  return std::move(compiled.model);
}

TEST(Pyramid, ACubeOfOnePictureKeepsItOnce) {
  const ray::Pyramid one = ray::MakePyramid(Cube(1).get(), 0), six = ray::MakePyramid(Cube(6).get(), 0);
  EXPECT_EQ(one.face_stride, 0);
  EXPECT_GT(six.face_stride, 0);
  ASSERT_EQ(6 * (one.texels.size() - 2), six.texels.size() - 2);
  for (std::size_t i = 0; i + 2 < six.texels.size(); ++i)
    EXPECT_EQ(six.texels[i], one.texels[i % (one.texels.size() - 2)]) << i;
}

TEST(Pyramid, BeyondTheRimOfACubeOfOnePictureIsItsNearestTexel) {
  const ModelPtr model = Cube(1);
  for (int i = 0; i < 3 * 64; ++i) model->tex_rgb[model->tex_adr[0] + i] = static_cast<mjtByte>(i * 37 % 256);
  const ray::Pyramid p = ray::MakePyramid(model.get(), 0);
  const auto at = [&](int x, int y) {
    return p.texels[static_cast<std::size_t>(p.offset[0] + y * p.stride[0] + x)];
  };
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(at(-1, i), at(0, i));
    EXPECT_EQ(at(8, i), at(7, i));
    EXPECT_EQ(at(i, -1), at(i, 0));
    EXPECT_EQ(at(i, 8), at(i, 7));
  }
  EXPECT_NE(at(0, 0), at(7, 0));
}

TEST(KeptPyramids, WhatAnotherModelDoesNotHaveIsDropped) {
  const ModelPtr red = Painted("1 0 0"), green = Painted("0 1 0");
  std::weak_ptr<const ray::Pyramid> own, common;
  {
    const ray::PyramidCache kept(red.get());
    own = kept.Of(0), common = kept.Of(1);
  }
  EXPECT_FALSE(own.expired());
  const ray::PyramidCache other(green.get());
  EXPECT_TRUE(own.expired());
  EXPECT_EQ(other.Of(1), common.lock());
}

}  // namespace
}  // namespace kestrel::sim
