// SPDX-License-Identifier: Apache-2.0
#include "sim/landscape/mesh.h"

namespace kestrel::sim::landscape {

std::string Msh(const Mesh& mesh) {
  const int counts[4] = {static_cast<int>(mesh.vertices.size()), static_cast<int>(mesh.normals.size()),
                         static_cast<int>(mesh.st.size()), static_cast<int>(mesh.faces.size())};
  std::string bytes(reinterpret_cast<const char*>(counts), sizeof counts);
  const auto append = [&](const auto& of) {
    if (!of.empty()) bytes.append(reinterpret_cast<const char*>(of.data()), of.size() * sizeof of[0]);
  };
  append(mesh.vertices);
  append(mesh.normals);
  append(mesh.st);
  append(mesh.faces);
  return bytes;
}

}  // namespace kestrel::sim::landscape
