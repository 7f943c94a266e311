// SPDX-License-Identifier: Apache-2.0
#include "sim/render/opengl/egl_display.h"

#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <string_view>

#include "sim/render/opengl/shared_library.h"

namespace kestrel::sim {
namespace {

// Of EGL/egl.h and EGL/eglext.h, which need not be installed.
constexpr unsigned kEglPlatformSurfacelessMesa = 0x31DD, kEglPlatformDevice = 0x313F;
constexpr int kEglExtensions = 0x3055;

struct EglDisplays {
  void* (*get_proc)(const char*);
  void* (*get_platform_display)(unsigned, void*, const int*);
  unsigned (*query_devices)(int, void**, int*);
  const char* (*query_device_string)(void*, int);
  unsigned (*initialize)(void*, int*, int*);
  int (*error)();

  explicit EglDisplays(void* library)
      : get_proc(Find<decltype(get_proc)>(library, "eglGetProcAddress")),
        get_platform_display(Extension<decltype(get_platform_display)>("eglGetPlatformDisplayEXT")),
        query_devices(Extension<decltype(query_devices)>("eglQueryDevicesEXT")),
        query_device_string(Extension<decltype(query_device_string)>("eglQueryDeviceStringEXT")),
        initialize(Find<decltype(initialize)>(library, "eglInitialize")),
        error(Find<decltype(error)>(library, "eglGetError")) {}

  // Null: there is no graphics card, or none that opens.
  void* OfCard() const {
    std::array<void*, 16> devices{};
    int count = 0;
    if (query_devices == nullptr || query_device_string == nullptr ||
        !query_devices(static_cast<int>(devices.size()), devices.data(), &count))
      return nullptr;
    for (int i = 0; i < count; ++i) {
      void* const device = devices[static_cast<std::size_t>(i)];
      const char* const extensions = query_device_string(device, kEglExtensions);
      if (extensions == nullptr ||
          std::string_view(extensions).find("EGL_MESA_device_software") != std::string_view::npos)
        continue;
      void* const display = get_platform_display(kEglPlatformDevice, device, nullptr);
      if (display != nullptr && initialize(display, nullptr, nullptr)) return display;
    }
    return nullptr;
  }

 private:
  template <class Function>
  Function Extension(const char* name) const {
    return reinterpret_cast<Function>(get_proc(name));
  }
};

}  // namespace

void* OpenEglDisplay(void* library) {
  const EglDisplays egl(library);
  if (egl.get_platform_display == nullptr)
    throw std::runtime_error("the library has no eglGetPlatformDisplayEXT");
  if (void* const display = egl.OfCard()) return display;
  void* const display = egl.get_platform_display(kEglPlatformSurfacelessMesa, nullptr, nullptr);
  if (display == nullptr)
    throw std::runtime_error("it has neither a graphics card nor a surfaceless display");
  if (!egl.initialize(display, nullptr, nullptr))
    throw std::runtime_error(fmt::format("eglInitialize failed with error {:#x}", egl.error()));
  return display;
}

}  // namespace kestrel::sim
