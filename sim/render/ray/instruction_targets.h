// SPDX-License-Identifier: Apache-2.0
#pragma once

// For files that Highway compiles once for each instruction set; to be included before it. Those are AVX-512, AVX2 and
// SSSE3, and not what lies between or has yet more. Of Highway's bits the better has the lower.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | (HWY_AVX3 - 1))
