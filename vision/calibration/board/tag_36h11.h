// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel::vision {

// A tag of the family 36h11, in cells of its grid: the code, and the black around it.
inline constexpr int kTagCodeCells = 6, kTagBorderCells = 2;
inline constexpr int kTagCells = kTagCodeCells + 2 * kTagBorderCells;

}  // namespace kestrel::vision
