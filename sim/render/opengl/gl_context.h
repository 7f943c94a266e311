// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace kestrel::sim {

// An off-screen OpenGL context. It belongs to the thread that made it: current there, and destroyed there.
// Several threads may hold one each, of either backend.
class GlContext {
 public:
  virtual ~GlContext() = default;
  // The backend, what draws, and its version: "osmesa: llvmpipe (LLVM 15.0.6, 256 bits), Mesa 22.3.6".
  virtual std::string RendererName() const = 0;
  // Textures are taken from pictures that are smaller by so many octaves than OpenGL would choose.
  virtual void BlurTextures(double octaves) = 0;
  // One of OpenGL's, as "glFlush"; null where there is none.
  virtual void* Function(const char* name) const = 0;
};

// Makes a context and makes it current on the calling thread, in place of any other. The libraries are opened
// at run time, so that neither is needed to build. backend: "osmesa" draws in memory with the processor;
// "egl" draws with a graphics card, by Mesa's driver or NVIDIA's, or where there is none with the processor
// (egl_display.h); "auto" is osmesa where it is installed, otherwise egl: osmesa draws the same bits on a
// machine whatever its graphics card and driver. Throws std::runtime_error with what was tried, why it failed
// and what to install.
std::unique_ptr<GlContext> MakeGlContext(std::string_view backend);

}  // namespace kestrel::sim
