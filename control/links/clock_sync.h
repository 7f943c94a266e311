// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/clock_sync.h"  // cameras have clocks of their own too
