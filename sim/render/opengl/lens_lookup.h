// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <opencv2/core.hpp>

#include "sim/render/opengl/gl_context.h"
#include "sim/render/opengl/lens_faces.h"

namespace kestrel::sim {

// Puts a lens's image together from its faces where they are drawn, so that of a graphics card's memory only the
// image is read. Each pixel is the mean over its patch: interpolated at as many places as the patch is pixels
// across, in whole numbers, which every driver computes alike. Belongs to a context, which must be current.
class LensLookup {
 public:
  // Throws std::runtime_error with what the context lacks.
  LensLookup(const GlContext& context, const LensFaces& lens);
  ~LensLookup();
  LensLookup(const LensLookup&) = delete;
  LensLookup& operator=(const LensLookup&) = delete;

  // Takes the picture of a face, which MuJoCo has just drawn off screen.
  void Take(std::size_t face, const mjrContext& drawn);
  // Fills the rows from first to before end, in blue, green, red; black outside the lens. Every face that they
  // show must have been taken.
  void Fill(int first, int end, cv::Mat& image);

 private:
  struct Gl;
  std::unique_ptr<Gl> gl_;
  const LensFaces& lens_;
  unsigned program_ = 0, target_ = 0;
  unsigned faces_ = 0, places_ = 0, sides_ = 0, image_ = 0;  // textures
};

}  // namespace kestrel::sim
