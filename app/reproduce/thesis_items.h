// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/yaml/fields.h"

// Which flights stand for which tables and figures of the thesis: app/reproduce/thesis.yaml.
namespace kestrel::app {

struct ThesisFlight {
  std::string label;
  std::string scenario;
  std::vector<std::string> set;
};

inline void Fields(FieldVisitor& v, ThesisFlight& f) {
  v({"label", "what the flight is, over its pictures"}, f.label);
  v(Required("scenario", "scenario that is flown"), f.scenario);
  v({"set", "key.path=value, as for kestrel run --set"}, f.set);
}

// A metric of each flight beside what the thesis gives.
struct ThesisValue {
  std::string what, metric;
  std::vector<std::string> thesis;
};

inline void Fields(FieldVisitor& v, ThesisValue& t) {
  v(Required("what", "what the number is"), t.what);
  v(Required("metric", "metric of the flights"), t.metric);
  v({"thesis", "what the thesis gives for each of the flights; empty: nothing"}, t.thesis);
}

// What stands on one card of the page: figures of one flight are shown together.
struct ThesisItem {
  std::vector<std::string> names;
  std::string section, shows, thesis, none, drawing;
  std::vector<std::string> flights, pictures;
  int stills = 0;
  std::vector<ThesisValue> values;
};

inline void Fields(FieldVisitor& v, ThesisItem& i) {
  v(Required("names", "figures and tables of the thesis, such as figure-3.7"), i.names);
  v({"section", "section of the thesis that they are in"}, i.section);
  v({"shows", "what they show"}, i.shows);
  v({"thesis", "what the thesis says of them in words"}, i.thesis);
  v({"none", "why there is no counterpart"}, i.none);
  v({"flights", "flights that stand for them"}, i.flights);
  v({"pictures", "pictures of each flight, by their file in its folder"}, i.pictures);
  v({"stills", "images from each flight's video, evenly spaced"}, i.stills, 0, 20);
  v({"drawing", "what is drawn from each flight's images"}, i.drawing,
    {"", "views", "segmentation", "ellipse", "sphere", "unwrapped", "distance"});
  v({"values", "metrics of the flights beside the thesis's numbers"}, i.values);
}

struct Thesis {
  std::map<std::string, ThesisFlight> flights;
  std::vector<ThesisItem> items;
};

inline void Fields(FieldVisitor& v, Thesis& t) {
  v({"flights", "flights by their names"}, t.flights);
  v({"items", "figures and tables in the order of the thesis"}, t.items);
}

// The file beside this header, or another. Throws InputError with every mistake: a flight or a metric that there
// is not, an item with neither flights nor a reason, or with both.
Thesis LoadThesis(const std::filesystem::path& file);
std::filesystem::path ThesisFile();

// The items that have these names; a number alone is that of a figure. None given: all. Throws InputError with
// the nearest valid name.
std::vector<const ThesisItem*> Chosen(const Thesis& thesis, const std::vector<std::string>& names);

// "Figures 4.12 to 4.17", for people.
std::string TitleOf(const ThesisItem& item);
// kestrel run pose --seed 1 --set ...
std::string CommandOf(const ThesisFlight& flight, std::uint64_t seed);

}  // namespace kestrel::app
