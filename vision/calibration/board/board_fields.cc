// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numbers>

#include "base/overloaded.h"
#include "base/yaml/fields.h"
#include "base/yaml/yaml_fields.h"
#include "vision/calibration/board/board.h"
#include "vision/tag/tag_family.h"

namespace kestrel::vision {
namespace {

std::vector<std::string> Dictionaries() {
  std::vector<std::string> names = TagFamilyNames();
  std::erase_if(names, [](const std::string& name) { return !name.starts_with("DICT_"); });
  return names;
}

void CheckCharuco(const CharucoBoard& b, const Place& where, Mistakes& mistakes) {
  if (!(b.marker_m < 0.95 * b.square_m) || !(b.marker_m > 0.3 * b.square_m)) {
    mistakes.Add(where, "markerSize", fmt::format("{:g} m in a square of {:g} m", b.marker_m, b.square_m),
                 fmt::format("valid: {:g} to {:g}", 0.3 * b.square_m, 0.95 * b.square_m));
  }
  const std::vector<std::string> names = Dictionaries();
  if (std::find(names.begin(), names.end(), b.dictionary) == names.end()) return;  // a mistake already
  const int markers = static_cast<int>(Markers(b).size()), count = TagFamilyOf(b.dictionary).count;
  if (markers > count) {
    mistakes.Add(where, "squareCols",
                 fmt::format("{} x {} squares want {} markers, and {} has {}", b.cols, b.rows, markers,
                             b.dictionary, count),
                 "valid: fewer squares, or a larger dictionary");
  }
}

// The file's form of either board.
struct TargetFile {
  std::string target_type;
  Chessboard chessboard;
  AprilGrid april_grid;
  CharucoBoard charuco;
  CircleGrid circles;
};

const std::vector<std::string> kTargetTypes = {"checkerboard", "aprilgrid", "charuco", "circlegrid"};

// Which keys a file may have: of its kind alone, of all kinds if it has none.
void Fields(FieldVisitor& v, TargetFile& f) {
  v(Required("target_type", "kind of calibration board, as in a target file of Kalibr; charuco is of ours"),
    f.target_type, kTargetTypes);
  const bool any = f.target_type.empty();
  if (any || f.target_type == "checkerboard") {
    v(Required("targetCols", "inner corners in a row of the chessboard"), f.chessboard.cols, 3, 100);
    v(Required("targetRows", "inner corners in a column of the chessboard"), f.chessboard.rows, 3, 100);
    v(Required("colSpacingMeters", "distance between the corners of a row"), f.chessboard.col_m, 1e-4, 10.0);
    v(Required("rowSpacingMeters", "distance between the rows of corners"), f.chessboard.row_m, 1e-4, 10.0);
  }
  if (any || f.target_type == "aprilgrid") {
    v(Required("tagCols", "number of AprilTags in a row"), f.april_grid.cols, 1, 100);
    v(Required("tagRows", "number of AprilTags in a column"), f.april_grid.rows, 1, 100);
    v(Required("tagSize", "side of a tag's black square, in m"), f.april_grid.tag_m, 1e-4, 10.0);
    v(Required("tagSpacing", "gap between two tags over the side of a tag"), f.april_grid.spacing, 0.1, 2.0);
  }
  if (any || f.target_type == "charuco") {
    v(Required("squareCols", "squares in a row of the Charuco board"), f.charuco.cols, 3, 100);
    v(Required("squareRows", "squares in a column of the Charuco board"), f.charuco.rows, 3, 100);
    v(Required("squareSize", "side of a square, in m"), f.charuco.square_m, 1e-4, 10.0);
    v(Required("markerSize", "side of a marker's black square, in m"), f.charuco.marker_m, 1e-4, 10.0);
    v(Required("dictionary", "of ArUco, from which the markers are, from number 0 on"), f.charuco.dictionary,
      Dictionaries());
    v({"legacyPattern", "whether it is drawn as by OpenCV before 4.6: the lower left square is black"},
      f.charuco.legacy);
  }
  if (f.target_type == "circlegrid") {
    v(Required("targetCols", "circles in a row"), f.circles.cols, 2, 100);
    v(Required("targetRows", "circles in a column"), f.circles.rows, 3, 100);
  }
  if (any || f.target_type == "circlegrid") {
    v(Required("spacingMeters",
               "distance between the rows of circles; of an asymmetric grid half of that between the circles "
               "of a row"),
      f.circles.spacing_m, 1e-4, 10.0);
    v(Required("circleDiameter", "of a circle, in m"), f.circles.diameter_m, 1e-4, 10.0);
    v({"asymmetricGrid", "whether every second row is shifted"}, f.circles.asymmetric);
  }
}

}  // namespace

Board LoadBoard(const std::filesystem::path& file, Mistakes& mistakes) {
  const Config config = LoadConfig(file, {}, mistakes);
  TargetFile target;
  for (const auto& [key, node] : config.root.members) {
    // Of a board that is not known, no other key can be judged.
    if (key != "target_type" || node.kind != ConfigNode::Kind::kText) continue;
    if (std::find(kTargetTypes.begin(), kTargetTypes.end(), node.text) == kTargetTypes.end()) {
      mistakes.Add(node.where, key, fmt::format("'{}' is not valid", node.text),
                   fmt::format("valid: {}", fmt::join(kTargetTypes, ", ")));
      return {};
    }
  }
  Read(config, target, mistakes);
  const Place where = config.root.where.file.empty() ? Place(file.string()) : config.root.where;
  if (target.target_type == "aprilgrid" || target.target_type == "charuco") {
#ifdef KESTREL_WITHOUT_APRILTAG
    mistakes.Add(file.string(), "target_type",
                 target.target_type +
                     ", and this build has no AprilTag; valid: checkerboard, circlegrid, or build anew "
                     "with Debian's libapriltag-dev");
#endif
  }
  if (target.target_type == "aprilgrid") {
    const AprilGrid& grid = target.april_grid;
    if (grid.cols * grid.rows > kTagCount) {
      mistakes.Add(where, "tagCols",
                   fmt::format("{} x {} tags are more than the {} of the family 36h11", grid.cols, grid.rows,
                               kTagCount));
    }
    return grid;
  }
  if (target.target_type == "charuco") {
    CheckCharuco(target.charuco, where, mistakes);
    return target.charuco;
  }
  if (target.target_type == "circlegrid") {
    const CircleGrid& circles = target.circles;
    const double apart = circles.asymmetric ? std::numbers::sqrt2 * circles.spacing_m : circles.spacing_m;
    if (!(circles.diameter_m < 0.9 * apart)) {
      mistakes.Add(where, "circleDiameter",
                   fmt::format("{:g} m, and the middles are {:g} m apart: the circles would touch",
                               circles.diameter_m, apart),
                   fmt::format("valid: less than {:g}", 0.9 * apart));
    }
    return circles;
  }
  return target.chessboard;
}

std::string ToKalibr(const Board& board) {
  TargetFile target;
  std::visit(Overloaded{[&](const Chessboard& b) {
                          target.target_type = "checkerboard";
                          target.chessboard = b;
                        },
                        [&](const AprilGrid& b) {
                          target.target_type = "aprilgrid";
                          target.april_grid = b;
                        },
                        [&](const CharucoBoard& b) {
                          target.target_type = "charuco";
                          target.charuco = b;
                        },
                        [&](const CircleGrid& b) {
                          target.target_type = "circlegrid";
                          target.circles = b;
                        }},
             board);
  return ToYaml(target);
}

}  // namespace kestrel::vision
