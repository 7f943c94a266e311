// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// What a stream over loopback costs in time: images of 640 x 480 as the landing's camera sees them, 20 a
// second, from CameraServer::Publish until LiveCamera::Next gives them, both in this program.
void BenchStream(std::vector<records::Figure>& table);

}  // namespace kestrel::bench
