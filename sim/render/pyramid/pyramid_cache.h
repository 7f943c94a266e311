// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>
#include <xxhash.h>

#include <memory>
#include <vector>

#include "sim/render/pyramid/pyramid.h"

namespace kestrel::sim::ray {

// The pyramids of a model's textures. To make them takes longer than anything else of a renderer, and most
// flights of a process have the same pictures as the one before: those of the last model are kept, and those
// that a new one does not have are dropped before any is made. For several threads.
class PyramidCache {
 public:
  explicit PyramidCache(const mjModel* model);  // which must outlive it
  std::shared_ptr<const Pyramid> Of(int texture) const;

 private:
  const mjModel* model_;
  std::vector<XXH128_hash_t> keys_;  // of each texture: of its picture and form
};

}  // namespace kestrel::sim::ray
