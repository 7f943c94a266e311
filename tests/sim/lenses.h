// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "geometry/tait_bryan.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

// One lens of each kind, for tests that hold for all. No two focal lengths or middles alike.
struct Lens {
  std::string name;
  vision::CameraModel camera;
};
inline std::ostream& operator<<(std::ostream& out, const Lens& lens) { return out << lens.name; }
inline std::string NameOfLens(const ::testing::TestParamInfo<Lens>& info) { return info.param.name; }

inline std::vector<Lens> Lenses() {
  vision::Unified hyperbolic{320, 240, 80, 80, 161.3, 118.2, 0.9}, parabolic{320, 240, 105, 106, 158, 121, 1};
  hyperbolic.max_angle_rad = Radians(105);
  parabolic.max_angle_rad = Radians(95);
  vision::KannalaBrandt fisheye{320, 240, 120, 119, 160.4, 118.9, -0.01, 0.002, -0.001, 0.0001};
  fisheye.max_angle_rad = Radians(95);
  return {{"pinhole", vision::Pinhole{320, 240, 400, 400, 152.1, 130.2}},
          {"oblong_pinhole", vision::Pinhole{320, 240, 400, 370, 163.2, 115.4}},
          {"brown_conrady", vision::BrownConrady{320, 240, 229, 228, 165, 122, -0.28, 0.07, 2e-4, 2e-5, 0}},
          {"hyperbolic_mirror", hyperbolic},
          {"parabolic_mirror", parabolic},
          {"fisheye", fisheye},
          {"double_sphere", vision::DoubleSphere{320, 240, 90, 91, 159, 121, -0.2, 0.55}}};
}

inline vision::CameraModel LensNamed(const std::string& name) {
  for (const Lens& lens : Lenses())
    if (lens.name == name) return lens.camera;
  ADD_FAILURE() << "no lens " << name;
  return {};
}

}  // namespace kestrel::sim
