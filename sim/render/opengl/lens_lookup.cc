// SPDX-License-Identifier: Apache-2.0
#include "sim/render/opengl/lens_lookup.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace kestrel::sim {
namespace {

// Of GL/gl.h and GL/glext.h, which need not be installed.
constexpr unsigned kTexture2d = 0x0DE1, kTexture2dArray = 0x8C1A, kTexture0 = 0x84C0, kNearest = 0x2600,
                   kMinFilter = 0x2801, kMagFilter = 0x2800, kRgba = 0x1908, kRgba8 = 0x8058,
                   kRgba32i = 0x8D82, kRgbaInteger = 0x8D99, kInt = 0x1404, kUnsignedByte = 0x1401,
                   kBgr = 0x80E0, kFramebuffer = 0x8D40, kReadFramebuffer = 0x8CA8, kDrawFramebuffer = 0x8CA9,
                   kColorAttachment0 = 0x8CE0, kFramebufferComplete = 0x8CD5, kColorBufferBit = 0x4000,
                   kAllAttributes = 0xFFFFFFFF, kDepthTest = 0x0B71, kBlend = 0x0BE2, kCullFace = 0x0B44,
                   kScissorTest = 0x0C11, kLighting = 0x0B50, kFragmentShader = 0x8B30,
                   kVertexShader = 0x8B31, kLinkStatus = 0x8B82, kPackAlignment = 0x0D05,
                   kMultisample = 0x809D, kDither = 0x0BD0;
// Units that MuJoCo leaves alone.
constexpr unsigned kFacesUnit = 4, kPlacesUnit = 5, kSidesUnit = 6;

constexpr const char* kVertices = R"(#version 130
void main() { gl_Position = gl_Vertex; }
)";

// places: of each pixel's patch the first place and the step from one to the next along its first side; sides:
// the step along its second side, how many places each side has, and the face; -1: outside the lens. Places are
// in 65536ths of a pixel of the face. Row 0 of the image is its top.
constexpr const char* kMean = R"(#version 130
uniform sampler2DArray faces;
uniform isampler2D places, sides;

uvec3 Texel(ivec3 at) { return uvec3(texelFetch(faces, at, 0).rgb * 255.0 + 0.5); }

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  ivec4 place = texelFetch(places, pixel, 0), side = texelFetch(sides, pixel, 0);
  int face = side.w;
  if (face < 0) {
    gl_FragColor = vec4(0.0);
    return;
  }
  int n_u = side.z & 255, n_v = side.z >> 8;
  uvec3 sum = uvec3(0u);
  for (int j = 0; j < n_v; ++j) {
    ivec2 at = place.xy + j * side.xy;
    for (int i = 0; i < n_u; ++i, at += place.zw) {
      uvec2 share = uvec2(at >> 8) & 255u, rest = 256u - share;
      ivec3 low = ivec3(at >> 16, face);
      sum += rest.y * (rest.x * Texel(low) + share.x * Texel(low + ivec3(1, 0, 0))) +
             share.y * (rest.x * Texel(low + ivec3(0, 1, 0)) + share.x * Texel(low + ivec3(1, 1, 0)));
    }
  }
  uint all = uint(n_u * n_v) << 16;
  gl_FragColor = vec4(vec3((sum + all / 2u) / all) / 255.0, 1.0);
}
)";

}  // namespace

struct LensLookup::Gl {
  // A function, whatever its type.
  struct Found {
    void* function;
    template <class Function>
    operator Function*() const {
      return reinterpret_cast<Function*>(function);
    }
  };
  Found Find(const char* name) const {
    if (void* const function = context.Function(name)) return {function};
    throw std::runtime_error(fmt::format("{} has no {}: lenses that are no pinholes need OpenGL 3.0.",
                                         context.RendererName(), name));
  }

  const GlContext& context;
  void (*GenTextures)(int, unsigned*) = Find("glGenTextures");
  void (*DeleteTextures)(int, const unsigned*) = Find("glDeleteTextures");
  void (*ActiveTexture)(unsigned) = Find("glActiveTexture");
  void (*BindTexture)(unsigned, unsigned) = Find("glBindTexture");
  void (*TexParameteri)(unsigned, unsigned, int) = Find("glTexParameteri");
  void (*TexImage2D)(unsigned, int, int, int, int, int, unsigned, unsigned,
                     const void*) = Find("glTexImage2D");
  void (*TexImage3D)(unsigned, int, int, int, int, int, int, unsigned, unsigned,
                     const void*) = Find("glTexImage3D");
  void (*CopyTexSubImage3D)(unsigned, int, int, int, int, int, int, int, int) = Find("glCopyTexSubImage3D");
  void (*GenFramebuffers)(int, unsigned*) = Find("glGenFramebuffers");
  void (*DeleteFramebuffers)(int, const unsigned*) = Find("glDeleteFramebuffers");
  void (*BindFramebuffer)(unsigned, unsigned) = Find("glBindFramebuffer");
  void (*FramebufferTexture2D)(unsigned, unsigned, unsigned, unsigned, int) = Find("glFramebufferTexture2D");
  unsigned (*CheckFramebufferStatus)(unsigned) = Find("glCheckFramebufferStatus");
  void (*BlitFramebuffer)(int, int, int, int, int, int, int, int, unsigned,
                          unsigned) = Find("glBlitFramebuffer");
  unsigned (*CreateShader)(unsigned) = Find("glCreateShader");
  void (*ShaderSource)(unsigned, int, const char* const*, const int*) = Find("glShaderSource");
  void (*CompileShader)(unsigned) = Find("glCompileShader");
  void (*DeleteShader)(unsigned) = Find("glDeleteShader");
  unsigned (*CreateProgram)() = Find("glCreateProgram");
  void (*AttachShader)(unsigned, unsigned) = Find("glAttachShader");
  void (*LinkProgram)(unsigned) = Find("glLinkProgram");
  void (*GetProgramiv)(unsigned, unsigned, int*) = Find("glGetProgramiv");
  void (*GetProgramInfoLog)(unsigned, int, int*, char*) = Find("glGetProgramInfoLog");
  void (*DeleteProgram)(unsigned) = Find("glDeleteProgram");
  void (*UseProgram)(unsigned) = Find("glUseProgram");
  int (*GetUniformLocation)(unsigned, const char*) = Find("glGetUniformLocation");
  void (*Uniform1i)(int, int) = Find("glUniform1i");
  void (*PushAttrib)(unsigned) = Find("glPushAttrib");
  void (*PopAttrib)() = Find("glPopAttrib");
  void (*Disable)(unsigned) = Find("glDisable");
  void (*Viewport)(int, int, int, int) = Find("glViewport");
  void (*ColorMask)(unsigned char, unsigned char, unsigned char, unsigned char) = Find("glColorMask");
  void (*Rectf)(float, float, float, float) = Find("glRectf");
  void (*PixelStorei)(unsigned, int) = Find("glPixelStorei");
  void (*ReadPixels)(int, int, int, int, unsigned, unsigned, void*) = Find("glReadPixels");

  unsigned Texture(unsigned kind, unsigned unit) {
    unsigned name = 0;
    GenTextures(1, &name);
    ActiveTexture(kTexture0 + unit);
    BindTexture(kind, name);
    TexParameteri(kind, kMinFilter, static_cast<int>(kNearest));
    TexParameteri(kind, kMagFilter, static_cast<int>(kNearest));
    return name;
  }

  unsigned Program() {
    const unsigned program = CreateProgram();
    for (const auto& [kind, source] :
         {std::pair(kVertexShader, kVertices), std::pair(kFragmentShader, kMean)}) {
      const unsigned shader = CreateShader(kind);
      ShaderSource(shader, 1, &source, nullptr);
      CompileShader(shader);
      AttachShader(program, shader);
      DeleteShader(shader);
    }
    LinkProgram(program);
    int linked = 0;
    GetProgramiv(program, kLinkStatus, &linked);
    if (linked == 0) {
      std::array<char, 2000> why{};
      GetProgramInfoLog(program, static_cast<int>(why.size()), nullptr, why.data());
      throw std::runtime_error(fmt::format("{} refuses the program that puts a lens together: {}",
                                           context.RendererName(), why.data()));
    }
    UseProgram(program);
    for (const auto& [name, unit] :
         {std::pair("faces", kFacesUnit), std::pair("places", kPlacesUnit), std::pair("sides", kSidesUnit)})
      Uniform1i(GetUniformLocation(program, name), static_cast<int>(unit));
    UseProgram(0);
    return program;
  }
};

LensLookup::LensLookup(const GlContext& context, const LensFaces& lens) : gl_(new Gl{context}), lens_(lens) {
  int width = 1, height = 1;
  for (const Face& face : lens.faces) {
    width = std::max(width, face.camera.width_px);
    height = std::max(height, face.camera.height_px);
  }
  std::vector<std::array<std::int32_t, 4>> places, sides;
  for (const Patch& p : lens.patches) {
    const int n_u = p.across_u, n_v = p.across_v;
    const int u_x = p.u_x / n_u, u_y = p.u_y / n_u, v_x = p.v_x / n_v, v_y = p.v_y / n_v;
    places.push_back({p.x - (u_x * (n_u - 1) + v_x * (n_v - 1)) / 2,
                      p.y - (u_y * (n_u - 1) + v_y * (n_v - 1)) / 2, u_x, u_y});
    sides.push_back({v_x, v_y, n_u | n_v << 8, p.face == Patch::kOutside ? -1 : p.face});
  }
  program_ = gl_->Program();
  faces_ = gl_->Texture(kTexture2dArray, kFacesUnit);
  gl_->TexImage3D(kTexture2dArray, 0, kRgba8, width, height, static_cast<int>(lens.faces.size()), 0, kRgba,
                  kUnsignedByte, nullptr);
  places_ = gl_->Texture(kTexture2d, kPlacesUnit);
  gl_->TexImage2D(kTexture2d, 0, kRgba32i, lens.width_px, lens.height_px, 0, kRgbaInteger, kInt,
                  places.data());
  sides_ = gl_->Texture(kTexture2d, kSidesUnit);
  gl_->TexImage2D(kTexture2d, 0, kRgba32i, lens.width_px, lens.height_px, 0, kRgbaInteger, kInt,
                  sides.data());
  gl_->ActiveTexture(kTexture0);
  image_ = gl_->Texture(kTexture2d, 0);
  gl_->TexImage2D(kTexture2d, 0, kRgba8, lens.width_px, lens.height_px, 0, kRgba, kUnsignedByte, nullptr);
  gl_->BindTexture(kTexture2d, 0);
  gl_->GenFramebuffers(1, &target_);
  gl_->BindFramebuffer(kFramebuffer, target_);
  gl_->FramebufferTexture2D(kFramebuffer, kColorAttachment0, kTexture2d, image_, 0);
  if (gl_->CheckFramebufferStatus(kFramebuffer) != kFramebufferComplete)
    throw std::runtime_error(fmt::format("{} cannot draw a lens's image of {} x {} pixels.",
                                         context.RendererName(), lens.width_px, lens.height_px));
}

LensLookup::~LensLookup() {
  gl_->DeleteFramebuffers(1, &target_);
  for (const unsigned* texture : {&faces_, &places_, &sides_, &image_}) gl_->DeleteTextures(1, texture);
  gl_->DeleteProgram(program_);
}

void LensLookup::Take(std::size_t face, const mjrContext& drawn) {
  const int width = lens_.faces[face].camera.width_px, height = lens_.faces[face].camera.height_px;
  if (drawn.offSamples > 0) {
    gl_->BindFramebuffer(kReadFramebuffer, drawn.offFBO);
    gl_->BindFramebuffer(kDrawFramebuffer, drawn.offFBO_r);
    gl_->BlitFramebuffer(0, 0, width, height, 0, 0, width, height, kColorBufferBit, kNearest);
  }
  gl_->BindFramebuffer(kReadFramebuffer, drawn.offSamples > 0 ? drawn.offFBO_r : drawn.offFBO);
  gl_->ActiveTexture(kTexture0 + kFacesUnit);
  gl_->CopyTexSubImage3D(kTexture2dArray, 0, 0, 0, static_cast<int>(face), 0, 0, width, height);
  gl_->ActiveTexture(kTexture0);
}

void LensLookup::Fill(int first, int end, cv::Mat& image) {
  gl_->BindFramebuffer(kFramebuffer, target_);
  gl_->PushAttrib(kAllAttributes);
  for (const unsigned what : {kDepthTest, kBlend, kCullFace, kScissorTest, kLighting, kMultisample, kDither})
    gl_->Disable(what);
  gl_->ColorMask(1, 1, 1, 1);
  gl_->Viewport(0, first, lens_.width_px, end - first);
  gl_->UseProgram(program_);
  gl_->Rectf(-1, -1, 1, 1);
  gl_->UseProgram(0);
  gl_->PixelStorei(kPackAlignment, 1);
  gl_->ReadPixels(0, first, lens_.width_px, end - first, kBgr, kUnsignedByte, image.ptr(first));
  gl_->PopAttrib();
}

}  // namespace kestrel::sim
