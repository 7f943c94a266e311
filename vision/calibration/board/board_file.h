// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/diagnostics.h"
#include "vision/calibration/board/board.h"

namespace kestrel::vision {

// One of models/boards by its name, or a file. where: for the mistakes.
Board LoadBoardNamed(const std::string& name_or_file, const Place& where, Mistakes& mistakes);

}  // namespace kestrel::vision
