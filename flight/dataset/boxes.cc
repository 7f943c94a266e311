// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/boxes.h"

#include <algorithm>
#include <string_view>

namespace kestrel::flight {

BoxFinder::BoxFinder(const mjModel* model) : thing_of_geom_(static_cast<std::size_t>(model->ngeom), -1) {
  for (int body = 1; body < model->nbody; ++body) {
    const char* name = mj_id2name(model, mjOBJ_BODY, body);
    if (!name || (std::string_view(name) != "pad" && !std::string_view(name).starts_with("target ")))
      continue;
    for (int g = 0; g < model->ngeom; ++g)
      if (model->geom_bodyid[g] == body)
        thing_of_geom_[static_cast<std::size_t>(g)] = static_cast<int>(labels_.size());
    labels_.emplace_back(name);
  }
}

std::vector<Box> BoxFinder::Find(const cv::Mat& geom) const {
  std::vector<Box> all(labels_.size());
  for (int v = 0; v < geom.rows; ++v) {
    const int* row = geom.ptr<int>(v);
    for (int u = 0; u < geom.cols; ++u) {
      const int thing = row[u] < 0 ? -1 : thing_of_geom_[static_cast<std::size_t>(row[u])];
      if (thing < 0) continue;
      Box& box = all[static_cast<std::size_t>(thing)];
      if (box.pixels == 0) box = {labels_[static_cast<std::size_t>(thing)], u, v, u, v, 0};
      box.u_min = std::min(box.u_min, u), box.u_max = std::max(box.u_max, u);
      box.v_max = v;
      ++box.pixels;
    }
  }
  std::erase_if(all, [](const Box& box) { return box.pixels == 0; });
  return all;
}

}  // namespace kestrel::flight
