// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "bench/render/render_world.h"
#include "records/figures.h"
#include "sim/render/rendering.h"

namespace kestrel::bench {

// How far the two renderers are apart away from the edges of things, in grey levels of 255, and how far each is from
// what a pixel shows by definition: the mean over its square.
void BenchAgreement(const BenchCamera& bench, World& world, const sim::RenderOptions& by_opengl,
                    std::uint64_t first_seed, std::uint64_t last_seed, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
