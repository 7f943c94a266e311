// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "mission/mission_type.h"

// A plug-in is a shared object with missions of its own, which the programs load by --plugin FILE or
// KESTREL_PLUGINS. One of its files says what it adds:
//
//   KESTREL_PLUGIN { kestrel::mission::AddMission<CircleFlight>(); }
//
// It is built by CMake's target kestrel::plugin, which names the version, and is loaded by that version alone.

static_assert(EIGEN_MAX_STATIC_ALIGN_BYTES == 16,
              "what holds matrices is laid out as in the program; build with kestrel::plugin");

#ifdef __clang__
#define KESTREL_COMPILER_ "clang++ " KESTREL_TEXT_(__clang_major__)
#else
#define KESTREL_COMPILER_ "g++ " KESTREL_TEXT_(__GNUC__)
#endif
#define KESTREL_TEXT_(macro) KESTREL_QUOTED_(macro)
#define KESTREL_QUOTED_(text) #text

// What stands in the file before the version and the compiler it was built with, and is read before any of its
// code runs.
#define KESTREL_PLUGIN_MARK_ "Kestrel plug-in of "

#define KESTREL_PLUGIN                                                 \
  [[gnu::used]] static const char kestrel_plugin_mark[] =              \
      KESTREL_PLUGIN_MARK_ KESTREL_VERSION ", " KESTREL_COMPILER_;     \
  extern "C" [[gnu::visibility("default")]] void kestrel_add_plugin(); \
  extern "C" void kestrel_add_plugin()
