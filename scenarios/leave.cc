// SPDX-License-Identifier: Apache-2.0
#include "scenarios/leave.h"

#include <cstdio>
#include <cstdlib>

#include "vision/live_camera.h"

namespace kestrel {

int LeaveWith(int status) {
  if (LiveCamera::LeftBehind() == 0) return status;
  std::fflush(nullptr);
  std::_Exit(status);
}

}  // namespace kestrel
