// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cstring>
#include <filesystem>
#include <string>

#include "sim/world/scene.h"

namespace kestrel::sim {

// The Pelican alone, over a plane at height 0, in steps of 2 ms.
inline ModelPtr PelicanOverAPlane() {
  const std::filesystem::path root = KESTREL_SOURCE_DIR;
  const std::string xml = R"(<mujoco><option timestep="0.002" gravity="0 0 -9.80665"/><worldbody>
      <geom type="plane" size="100 100 1"/><include file=")" +
                          (root / "models/vehicles/pelican/pelican.xml").string() +
                          R"("/></worldbody></mujoco>)";
  mjVFS vfs;
  mj_defaultVFS(&vfs);
  mj_makeEmptyFileVFS(&vfs, "world.xml", static_cast<int>(xml.size()) + 1);
  std::memcpy(vfs.filedata[0], xml.c_str(), xml.size() + 1);
  char error[500] = {};
  ModelPtr model(mj_loadXML("world.xml", &vfs, error, sizeof(error)));
  mj_deleteVFS(&vfs);
  EXPECT_TRUE(model) << error;
  return model;
}

}  // namespace kestrel::sim
