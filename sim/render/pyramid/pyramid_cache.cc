// SPDX-License-Identifier: Apache-2.0
#include "sim/render/pyramid/pyramid_cache.h"

#include <algorithm>
#include <mutex>

namespace kestrel::sim::ray {
namespace {

struct Kept {
  XXH128_hash_t key;
  std::shared_ptr<const Pyramid> pyramid;
};
std::mutex mutex;
std::vector<Kept> kept;

XXH128_hash_t KeyOf(const mjModel* m, int texture) {
  const int form[] = {m->tex_type[texture], m->tex_width[texture], m->tex_height[texture]};
  const std::size_t bytes = 3 * static_cast<std::size_t>(form[1]) * static_cast<std::size_t>(form[2]);
  return XXH3_128bits_withSeed(m->tex_rgb + m->tex_adr[texture], bytes, XXH3_64bits(form, sizeof form));
}

bool Same(const XXH128_hash_t& a, const XXH128_hash_t& b) { return XXH128_isEqual(a, b) != 0; }

}  // namespace

PyramidCache::PyramidCache(const mjModel* model) : model_(model) {
  for (int t = 0; t < model->ntex; ++t) keys_.push_back(KeyOf(model, t));
  const std::lock_guard lock(mutex);
  std::erase_if(kept, [&](const Kept& k) {
    return std::none_of(keys_.begin(), keys_.end(), [&](const auto& key) { return Same(key, k.key); });
  });
}

std::shared_ptr<const Pyramid> PyramidCache::Of(int texture) const {
  const XXH128_hash_t& key = keys_[static_cast<std::size_t>(texture)];
  const std::lock_guard lock(mutex);
  for (const Kept& k : kept)
    if (Same(k.key, key)) return k.pyramid;
  return kept.emplace_back(Kept{key, std::make_shared<const Pyramid>(MakePyramid(model_, texture))}).pyramid;
}

}  // namespace kestrel::sim::ray
