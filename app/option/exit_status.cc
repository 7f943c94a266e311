// SPDX-License-Identifier: Apache-2.0
#include "app/option/exit_status.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "base/process/print_note.h"
#include "vision/capture/live_camera.h"

namespace kestrel::app {

int ExitWith(int status) {
  // A full disk may show only now. What a write before failed of, nobody knows any more.
  const bool failed_before = std::ferror(stdout) != 0;
  if ((std::fflush(stdout) != 0 || failed_before) && status < kBadInput) {
    PrintNote("kestrel: what was to be printed could not be written{}\n",
              failed_before ? "" : fmt::format(": {}", std::strerror(errno)));
    status = kBrokeOff;
  }
  if (vision::LiveCamera::LeftBehind() == 0) return status;
  std::fflush(nullptr);
  std::_Exit(status);
}

}  // namespace kestrel::app
