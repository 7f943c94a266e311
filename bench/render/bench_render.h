// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// How fast both renderers are beside the usual way to draw with MuJoCo (bench/render/peer_renderer.h), and how
// well they agree with each other and with the camera models: the landing's world with the aircraft in it, a
// pinhole, a fisheye and a catadioptric camera, poses that depend on the seed. Times are the processor's, of
// one thread, taken in turns. opengl: the backend that OpenGL draws by, osmesa or egl.
void BenchRender(std::uint64_t first_seed, std::uint64_t last_seed, const std::string& opengl,
                 std::vector<records::Figure>& table);

}  // namespace kestrel::bench
