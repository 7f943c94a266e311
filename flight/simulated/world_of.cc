// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/world_of.h"

#include <fmt/format.h>

#include "base/user_file.h"
#include "base/yaml/yaml_fields.h"
#include "sim/world/world_file.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;

void FindFile(std::string& name, const std::string& key, const fs::path& beside, const Place& where,
              Mistakes& mistakes) {
  for (const fs::path& candidate : {beside / name, fs::path(name)}) {
    if (!IsFile(candidate)) continue;
    name = fs::absolute(candidate).lexically_normal().string();
    return;
  }
  mistakes.Add(
      where, key, NoSuchFile(name),
      fmt::format("valid: a file beside {}", beside.empty() ? "the working directory" : beside.string()));
}

}  // namespace

void FindAdditions(std::vector<sim::MeshParameters>& meshes, std::optional<sim::GroundPhotoParameters>& photo,
                   const fs::path& beside, const Config& config, const Place& file, Mistakes& mistakes) {
  for (std::size_t i = 0; i < meshes.size(); ++i)
    FindFile(meshes[i].file, fmt::format("meshes[{}].file", i), beside, WhereOf(config, "meshes", file),
             mistakes);
  if (photo)
    FindFile(photo->file, "ground_photo.file", beside, WhereOf(config, "ground_photo", file), mistakes);
}

std::optional<LoadedWorld> WorldOf(std::string name, const fs::path& beside, Mistakes& mistakes) {
  Mistakes none;
  const auto file = ModelFile(Model::kWorld, name, beside, "", none);
  if (!file) return std::nullopt;
  if (file->extension() == ".xml") return LoadedWorld{*file, std::nullopt, {}};
  sim::WorldFile w;
  const Config config = LoadConfig(*file, {}, mistakes);
  Read(config, w, mistakes);
  const fs::path folder = file->parent_path();
  FindAdditions(w.meshes, w.ground_photo, folder, config, file->string(), mistakes);
  LoadedWorld world{*file, w.landscape, {std::move(w.meshes), std::move(w.ground_photo), w.endless}};
  if (!w.model.empty()) {
    FindFile(w.model, "model", folder, WhereOf(config, "model", file->string()), mistakes);
    world.file = w.model;
    world.landscape.reset();
  }
  return world;
}

std::vector<std::string> LandscapeNames() {
  std::vector<std::string> names;
  Mistakes none;
  for (const std::string& name : ModelNames(Model::kWorld))
    if (const auto world = WorldOf(name, "", none); world && world->landscape) names.push_back(name);
  return names;
}

}  // namespace kestrel::flight
