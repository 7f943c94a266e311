// SPDX-License-Identifier: Apache-2.0
#include "base/version.h"

namespace kestrel {

const char* Version() { return KESTREL_VERSION; }

}  // namespace kestrel
