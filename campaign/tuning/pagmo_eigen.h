// SPDX-License-Identifier: Apache-2.0
#pragma once

// Before anything of pagmo's. Its algorithms hold matrices of Eigen's, some of them made in its library,
// which Debian builds for 16 bytes of alignment and plain malloc, and freed in our code, which is built for
// 32: so the Eigen that its headers see is as its library's, and under a name of its own, apart from ours.
#ifdef EIGEN_CORE_H
#error Eigen was included before
#endif
#undef EIGEN_MAX_ALIGN_BYTES
#define EIGEN_MAX_ALIGN_BYTES 16
#define EIGEN_MALLOC_ALREADY_ALIGNED 1
#define Eigen EigenOfPagmo
