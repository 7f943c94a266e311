// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel::app {

// Of every program: 0 and 1 are results, of which the output tells.
enum ExitStatus { kMet = 0, kNotMet = 1, kBadInput = 2, kBrokeOff = 3 };

// The last thing that main does: gives the exit status back, kBrokeOff in place of a result that could not be
// printed (a full disk), with a word. Where a camera's thread hangs within its
// library, the program ends here and now with that status, its output flushed: exit handlers would take the
// library down beneath the thread.
int ExitWith(int status);

}  // namespace kestrel::app
