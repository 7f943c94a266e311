// SPDX-License-Identifier: Apache-2.0
#include "sim/world/mjcf.h"

#include <cstring>
#include <mutex>
#include <sstream>
#include <string_view>

namespace kestrel::sim {
namespace {

// MuJoCo's message as part of a sentence: it has a line with the fault, then one with the place. The numbers
// in it count in a model that nobody sees.
std::string OneSentence(const std::string& message) {
  std::istringstream lines(message);
  std::string sentence;
  for (std::string line; std::getline(lines, line);) {
    for (const char* const number : {" in texture id = ", ", id = ", ", line ", ", column "})
      line = line.substr(0, line.find(number));
    for (const std::string_view label : {"XML Error: ", "Error: ", "Object name = "})
      if (line.starts_with(label)) line.erase(0, label.size());
    if (!line.empty()) sentence += (sentence.empty() ? "" : ", ") + line;
  }
  return sentence;
}

void AddFile(mjVFS* files, const std::string& name, const std::string& bytes) {
  mj_makeEmptyFileVFS(files, name.c_str(), static_cast<int>(bytes.size()));
  std::memcpy(files->filedata[mj_findFileVFS(files, name.c_str())], bytes.data(), bytes.size());
}

}  // namespace

CompiledModel CompileMjcf(const std::string& mjcf, std::map<std::string, std::string> files) {
  static std::mutex parser;  // MuJoCo keeps the last parsed model in a global variable,
  const std::lock_guard lock(parser);

  constexpr const char* kName = "composed scene.xml";
  const auto in_memory = std::make_unique<mjVFS>();
  mj_defaultVFS(in_memory.get());
  AddFile(in_memory.get(), kName, mjcf);
  while (!files.empty()) {  // which are large, and MuJoCo makes two copies more
    const auto file = files.extract(files.begin());
    AddFile(in_memory.get(), file.key(), file.mapped());
  }
  char message[1000] = "";
  CompiledModel compiled{ModelPtr(mj_loadXML(kName, in_memory.get(), message, sizeof message)), ""};
  mj_deleteVFS(in_memory.get());
  mj_freeLastXML();  // with all of its textures
  if (!compiled.model) compiled.message = OneSentence(message);
  return compiled;
}

}  // namespace kestrel::sim
