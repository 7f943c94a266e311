// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel {

// The release, and the commit that the program was built from.
const char* Version();

}  // namespace kestrel
