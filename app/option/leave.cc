// SPDX-License-Identifier: Apache-2.0
#include "app/option/leave.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "base/process/aside.h"
#include "vision/capture/live_camera.h"

namespace kestrel {

int LeaveWith(int status) {
  // A full disk may show only now. What a write before failed of, nobody knows any more.
  const bool failed_before = std::ferror(stdout) != 0;
  if ((std::fflush(stdout) != 0 || failed_before) && status < kBadInput) {
    Aside("kestrel: what was to be printed could not be written{}\n",
          failed_before ? "" : fmt::format(": {}", std::strerror(errno)));
    status = kBrokeOff;
  }
  if (LiveCamera::LeftBehind() == 0) return status;
  std::fflush(nullptr);
  std::_Exit(status);
}

}  // namespace kestrel
