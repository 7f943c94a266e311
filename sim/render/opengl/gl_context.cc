// SPDX-License-Identifier: Apache-2.0
#include "sim/render/opengl/gl_context.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <array>
#include <initializer_list>
#include <mutex>
#include <stdexcept>

#include "sim/render/opengl/egl_display.h"
#include "sim/render/opengl/shared_library.h"

namespace kestrel::sim {
namespace {

// Of GL/gl.h, GL/osmesa.h and EGL/egl.h, which need not be installed.
constexpr unsigned kGlRgba = 0x1908, kGlUnsignedByte = 0x1401, kGlRenderer = 0x1F01, kGlVersion = 0x1F02;
constexpr int kEglNone = 0x3038, kEglSurfaceType = 0x3033, kEglPbufferBit = 0x0001,
              kEglRenderableType = 0x3040, kEglOpenGlBit = 0x0008;
constexpr unsigned kEglOpenGlApi = 0x30A2;

constexpr unsigned kGlTextureFilterControl = 0x8500, kGlTextureLodBias = 0x8501;

using GetString = const unsigned char* (*)(unsigned);
using TexEnvf = void (*)(unsigned, unsigned, float);

void* OpenLibrary(std::initializer_list<const char*> names, int flags) {
  std::string why;
  for (const char* const name : names) {
    if (void* const library = dlopen(name, RTLD_NOW | flags)) return library;
    why += fmt::format("{}{}", why.empty() ? "" : "; ", dlerror());
  }
  throw std::runtime_error(why);
}

std::string NameOf(std::string_view backend, GetString get_string) {
  const auto text = [&](unsigned what) {
    const unsigned char* const s = get_string(what);
    return std::string(s == nullptr ? "unknown" : reinterpret_cast<const char*>(s));
  };
  const std::string version = text(kGlVersion);  // "4.5 (Compatibility Profile) Mesa 22.3.6"
  const std::size_t mesa = version.find("Mesa");
  return fmt::format("{}: {}, {}", backend, text(kGlRenderer),
                     mesa == std::string::npos ? "OpenGL " + version : version.substr(mesa));
}

class OsMesa final : public GlContext {
 public:
  OsMesa() {
    // MuJoCo looks for OpenGL's functions first by eglGetProcAddress, then OSMesaGetProcAddress, then GLX,
    // among the symbols that all libraries of the process see. So this library is opened for all to see; EGL
    // below is not, or its functions, which know nothing of OSMesa, would be taken here.
    static void* const library =
        OpenLibrary({"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}, RTLD_GLOBAL);
    const auto create = Find<void* (*)(unsigned, int, int, int, void*)>(library, "OSMesaCreateContextExt");
    get_ = Find<void* (*)(const char*)>(library, "OSMesaGetProcAddress");
    make_current_ = Find<MakeCurrent>(library, "OSMesaMakeCurrent");
    destroy_ = Find<void (*)(void*)>(library, "OSMesaDestroyContext");
    get_string_ = reinterpret_cast<GetString>(get_("glGetString"));
    tex_env_ = reinterpret_cast<TexEnvf>(get_("glTexEnvf"));
    context_ = create(kGlRgba, 24, 8, 0, nullptr);
    if (context_ == nullptr) throw std::runtime_error("OSMesaCreateContextExt failed");
    if (!make_current_(context_, window_.data(), kGlUnsignedByte, kSide, kSide)) {
      destroy_(context_);
      throw std::runtime_error("OSMesaMakeCurrent failed");
    }
  }
  ~OsMesa() override {
    make_current_(nullptr, nullptr, 0, 0, 0);
    destroy_(context_);
  }
  OsMesa(const OsMesa&) = delete;
  OsMesa& operator=(const OsMesa&) = delete;

  std::string RendererName() const override { return NameOf("osmesa", get_string_); }
  void BlurTextures(double octaves) override {
    tex_env_(kGlTextureFilterControl, kGlTextureLodBias, static_cast<float>(octaves));
  }
  void* Function(const char* name) const override { return get_(name); }

 private:
  using MakeCurrent = unsigned char (*)(void*, void*, unsigned, int, int);
  static constexpr int kSide = 16;  // the window: never drawn to, but a context cannot be current without one

  void* context_ = nullptr;
  MakeCurrent make_current_ = nullptr;
  void (*destroy_)(void*) = nullptr;
  void* (*get_)(const char*) = nullptr;
  GetString get_string_ = nullptr;
  TexEnvf tex_env_ = nullptr;
  std::array<unsigned char, 4 * kSide * kSide> window_{};
};

class Egl final : public GlContext {
 public:
  Egl() {
    static void* const library = OpenLibrary({"libEGL.so.1", "libEGL.so"}, RTLD_LOCAL);
    get_ = Find<void* (*)(const char*)>(library, "eglGetProcAddress");
    const auto bind_api = Find<unsigned (*)(unsigned)>(library, "eglBindAPI");
    const auto choose = Find<unsigned (*)(void*, const int*, void**, int, int*)>(library, "eglChooseConfig");
    const auto create = Find<void* (*)(void*, void*, void*, const int*)>(library, "eglCreateContext");
    const auto error = Find<int (*)()>(library, "eglGetError");
    make_current_ = Find<MakeCurrent>(library, "eglMakeCurrent");
    destroy_ = Find<unsigned (*)(void*, void*)>(library, "eglDestroyContext");
    release_thread_ = Find<unsigned (*)()>(library, "eglReleaseThread");
    get_string_ = reinterpret_cast<GetString>(get_("glGetString"));
    tex_env_ = reinterpret_cast<TexEnvf>(get_("glTexEnvf"));
    // One display serves the whole process and is never terminated: that would end the contexts of other
    // threads.
    static void* const display = OpenEglDisplay(library);
    display_ = display;
    const std::array<int, 5> wanted{kEglSurfaceType, kEglPbufferBit, kEglRenderableType, kEglOpenGlBit,
                                    kEglNone};
    void* config = nullptr;
    int count = 0;
    if (!bind_api(kEglOpenGlApi) || !choose(display_, wanted.data(), &config, 1, &count) || count < 1)
      throw std::runtime_error(fmt::format("it offers no OpenGL, error {:#x}", error()));
    context_ = create(display_, config, nullptr, nullptr);
    if (context_ == nullptr)
      throw std::runtime_error(fmt::format("eglCreateContext failed with error {:#x}", error()));
    if (!make_current_(display_, nullptr, nullptr, context_)) {
      const int code = error();
      destroy_(display_, context_);
      throw std::runtime_error(fmt::format("eglMakeCurrent failed with error {:#x}", code));
    }
  }
  ~Egl() override {
    make_current_(display_, nullptr, nullptr, nullptr);
    destroy_(display_, context_);
    release_thread_();
  }
  Egl(const Egl&) = delete;
  Egl& operator=(const Egl&) = delete;

  std::string RendererName() const override { return NameOf("egl", get_string_); }
  void BlurTextures(double octaves) override {
    tex_env_(kGlTextureFilterControl, kGlTextureLodBias, static_cast<float>(octaves));
  }
  void* Function(const char* name) const override { return get_(name); }

 private:
  using MakeCurrent = unsigned (*)(void*, void*, void*, void*);

  void* display_ = nullptr;
  void* context_ = nullptr;
  MakeCurrent make_current_ = nullptr;
  unsigned (*destroy_)(void*, void*) = nullptr;
  unsigned (*release_thread_)() = nullptr;
  void* (*get_)(const char*) = nullptr;
  GetString get_string_ = nullptr;
  TexEnvf tex_env_ = nullptr;
};

}  // namespace

std::unique_ptr<GlContext> MakeGlContext(std::string_view backend) {
  if (backend != "auto" && backend != "osmesa" && backend != "egl")
    throw std::runtime_error(
        fmt::format("There is no OpenGL backend \"{}\": use \"auto\", \"osmesa\" or \"egl\".", backend));
  // MuJoCo keeps one table of OpenGL functions for the process, filled by what it finds first.
  static std::mutex mutex;
  static std::string chosen;
  const std::lock_guard lock(mutex);
  if (!chosen.empty() && backend != "auto" && backend != chosen)
    throw std::runtime_error(
        fmt::format("This process draws with {} already: {} needs a process of its own.", chosen, backend));
  if (!chosen.empty()) backend = chosen;
  std::string osmesa_failure, egl_failure;
  if (backend != "egl") {
    try {
      auto context = std::make_unique<OsMesa>();
      chosen = "osmesa";
      return context;
    } catch (const std::runtime_error& e) {
      osmesa_failure = fmt::format("OSMesa ({}; Debian package libosmesa6)", e.what());
    }
  }
  if (backend != "osmesa") {
    try {
      auto context = std::make_unique<Egl>();
      chosen = "egl";
      return context;
    } catch (const std::runtime_error& e) {
      egl_failure = fmt::format("EGL ({}; Debian packages libegl1 and libegl-mesa0)", e.what());
    }
  }
  throw std::runtime_error(fmt::format("No off-screen OpenGL: tried {}{}{}.", osmesa_failure,
                                       osmesa_failure.empty() || egl_failure.empty() ? "" : ", then ",
                                       egl_failure));
}

}  // namespace kestrel::sim
