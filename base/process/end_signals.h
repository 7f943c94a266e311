// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

namespace kestrel {

// How the program is asked to end, for all verbs alike: the interrupt (SIGINT, Ctrl-C), the request to
// terminate (SIGTERM) and the hang-up of the terminal (SIGHUP), which is as the request to terminate. Under
// nohup a hang-up is of no matter.

// Until the next call; asked is given SIGINT or SIGTERM, runs within the signal's handler and does only what
// may be done there. It may be called more than once: a terminal that goes hangs up more than once.
void OnEndSignals(void (*asked)(int signal));

// The next interrupt or request to terminate ends the program at once. A hang-up does not, and still comes to
// asked: nobody sent it to say that it takes too long. May be called within asked.
void EndOnNextSignal();

// From now on the first signal is a request to end in good order: it sets what is returned, which is false at first;
// a second one ends the program.
const std::atomic<bool>& EndInGoodOrder();

}  // namespace kestrel
