// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <iosfwd>

namespace kestrel::bench {

// How another program has this one time its work, in turn with others (timed_program.h). Greets with a line of JSON:
// {"kestrel_timings": 1, "version": ..., "machine": {...}, "work": [names]}. Then answers each line, the name of a work
// (timed_work.h), by doing a block of it: "PROCESSOR_MS WALL_MS PIECES", or "! why not". Until the input ends.
void ServeTimings(std::istream& in, std::ostream& out);

}  // namespace kestrel::bench
