// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel {

// The last thing that main does: gives the exit status back. Where a camera's thread hangs within its
// library, the program ends here and now with that status, its output flushed: exit handlers would take the
// library down beneath the thread.
int LeaveWith(int status);

}  // namespace kestrel
