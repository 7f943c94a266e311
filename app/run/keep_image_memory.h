// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <malloc.h>

namespace kestrel::app {

// Images come and go with each frame: their memory is kept, not given back and faulted in again.
inline void KeepImageMemory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 25);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
}

}  // namespace kestrel::app
