// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// `kestrel serve --lockstep` as a program of its own, by its Unix socket: what a round trip takes beside the
// simulator's own time, with images and without, and whether of a million single steps of the physics one is
// lost or done twice. A client in C++, whose own work on the messages is in the time. Throws std::runtime_error
// where the server does not serve.
void BenchLockstep(std::vector<records::Figure>& table);

}  // namespace kestrel::bench
