// SPDX-License-Identifier: Apache-2.0
#include "records/page/flight_page.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "base/file/files.h"
#include "base/html/html.h"
#include "base/user_file.h"
#include "records/page/flight_data.h"
#include "records/page/flight_json.h"
#include "records/page/page_media.h"

namespace kestrel::records {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kOwn = "records/page/web";

// In the order in which they need each other.
constexpr const char* kScripts[] = {"flight.js",      "clock.js",         "video.js",        "quantities.js",
                                    "charts.js",      "chart_marks.js",   "events.js",       "player.js",
                                    "verdict.js",     "compare.js",       "scene_poses.js",  "scene_model.js",
                                    "scene_paths.js", "scene_marks.js",   "scene_views.js",  "scene.js",
                                    "keyboard.js",    "live_pictures.js", "live_changes.js", "live.js",
                                    "main.js"};

// three.js, version 111, of libjs-three (MIT), with what reads glTF and turns the view.
std::string Three() {
  const fs::path folder = "/usr/share/javascript/three";
  std::string all;
  for (const auto& [file, says] : std::initializer_list<std::pair<const char*, const char*>>{
           {"three.min.js", "REVISION=\"111\""},
           {"examples/js/controls/OrbitControls.js", "OrbitControls"},
           {"examples/js/loaders/GLTFLoader.js", "GLTFLoader"}})
    all += LibraryFile({folder / file, "libjs-three", {says}}) + '\n';
  return all;
}

// flights: elements of a list of JSON; connect: with whom it may speak, as a Content-Security-Policy says it.
std::string PageOf(const std::string& title, const std::string& flights, std::string media,
                   std::string connect) {
  const fs::path shared = "base/html/web";
  std::vector<fs::path> scripts = {shared / "numbers.js", shared / "dom.js", shared / "theme.js"};
  for (const char* name : kScripts) scripts.push_back(fs::path(kOwn) / name);
  std::map<std::string_view, std::string> parts;
  parts["title"] = Escaped(title + " – Kestrel");
  parts["style"] = PageFile(shared / "page.css") + PageFile(fs::path(kOwn) / "flight.css") +
                   PageFile(fs::path(kOwn) / "live.css");
  parts["data"] = InScript("{\"flights\":[" + flights + "]}");
  parts["media"] = std::move(media);
  parts["connect"] = std::move(connect);
  parts["chart"] = LibraryFile(ChartLibrary());
  parts["mit"] = PageFile("base/html/web/mit.txt");
  parts["three"] = Three();
  parts["script"] = PageScript(scripts);
  return Filled(PageFile(fs::path(kOwn) / "flight.html"), parts);
}

std::string TitleOf(const std::string& flight) { return Json::parse(flight).at("title"); }

}  // namespace

std::string FlightPage(const fs::path& folder, const std::optional<fs::path>& second) {
  std::string flights = FlightData(folder), title = TitleOf(flights), media = MediaElements(folder, "");
  if (second) {
    const std::string other = FlightData(*second);
    title += " | " + TitleOf(other);
    flights += ',' + other;
    media += MediaElements(*second, "-b");
  }
  return PageOf(title, flights, std::move(media), "'none'");
}

std::string LiveFlightPage(const FlightSubject& subject, const std::string& scene_glb) {
  return PageOf(subject.title, LiveJson(subject).dump(-1, ' ', false, Json::error_handler_t::replace),
                MediaElement("scene", scene_glb), "'self'");
}

void WriteFlightPage(const fs::path& folder) { WriteFile(folder / "report.html", FlightPage(folder)); }

}  // namespace kestrel::records
