// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/format/format.h"

#include "flight/dataset/format/euroc_format.h"
#include "flight/dataset/format/kitti_format.h"
#include "flight/dataset/format/tum_format.h"

namespace kestrel::flight {

std::vector<std::string> FormatNames() { return {"euroc", "tum", "kitti"}; }

std::unique_ptr<Format> MakeFormat(const std::string& name) {
  if (name == "tum") return std::make_unique<TumFormat>();
  if (name == "kitti") return std::make_unique<KittiFormat>();
  return std::make_unique<EurocFormat>();
}

}  // namespace kestrel::flight
