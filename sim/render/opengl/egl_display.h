// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel::sim {

// An initialised EGL display that needs no screen: the first graphics card that EGL lists as a device
// (EGL_EXT_platform_device, NVIDIA's and Mesa's), or, where there is none, Mesa's surfaceless one, which draws with
// the processor. library: libEGL, as dlopen gives it. Throws std::runtime_error with the reason.
void* OpenEglDisplay(void* library);

}  // namespace kestrel::sim
