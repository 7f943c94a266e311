// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/render/ray/kernel.h"

// Light from sun and sky: what the model's lights alone do not make of a picture that is drawn. A pass of its own over
// what each pixel's ray meets, after all rows of the picture are drawn, without shadows:
// - the sun is a disc, of which things hide a part: shadows with soft edges, sharp where they touch;
// - light from the sky falls less where things stand close, and less from below;
// - what is green and level has blades and tufts, as fine as a pixel shows.
// The sun is the strongest parallel light; other lights shine as they did. Pictures of a landscape have their light
// painted in: of these only shadows and closeness are new.
namespace kestrel::sim::ray {

// The rows [begin, end) of one row of tiles.
void LightRows(const Slice& slice, int begin, int end, const Canvas& canvas);

}  // namespace kestrel::sim::ray
