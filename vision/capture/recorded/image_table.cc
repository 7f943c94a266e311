// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/image_table.h"

#include <fmt/format.h>

#include "base/user_file.h"
#include "vision/capture/recorded/stamp.h"
#include "vision/capture/recorded/stamped_table.h"

namespace kestrel::vision {
namespace {

namespace fs = std::filesystem;

constexpr const char* kThere = "an image that is there; where it is lost, the table without its row";

// Of rows "stamp, name of an image in this folder".
std::vector<StampedImage> ReadImageTable(const fs::path& table, const TableForm& form, const fs::path& folder,
                                         Mistakes& mistakes) {
  std::vector<StampedImage> images;
  ReadTable(table, form, mistakes, [&](std::int64_t stamp_ns, const std::vector<std::string>& cells) {
    images.push_back({stamp_ns, folder / cells[1]});
    const fs::path& file = images.back().file;
    return IsFile(file) ? "" : fmt::format("its image is missing: {}", NoSuchFile(file));
  });
  return images;
}

}  // namespace

std::vector<StampedImage> ReadEurocTable(const fs::path& camera_folder, Mistakes& mistakes) {
  return ReadImageTable(camera_folder / "data.csv",
                        {.between = ',',
                         .least_cells = 2,
                         .most_cells = 2,
                         .stamp = StampOfNanoseconds,
                         .row = "rows of a stamp in ns, a comma, and the name of an image in data/",
                         .rest = kThere},
                        camera_folder / "data", mistakes);
}

std::vector<StampedImage> ReadTumTable(const fs::path& table, Mistakes& mistakes) {
  return ReadImageTable(table,
                        {.between = ' ',
                         .least_cells = 2,
                         .most_cells = 2,
                         .stamp = StampOfSeconds,
                         .row = "rows of a stamp in s, a space, and the path of an image",
                         .rest = kThere},
                        table.parent_path(), mistakes);
}

std::vector<StampedImage> ReadKittiTable(const fs::path& table, const std::vector<fs::path>& images,
                                         Mistakes& mistakes) {
  const std::size_t before = mistakes.all().size();
  std::vector<StampedImage> stamped;
  std::size_t rows = 0;
  ReadTable(table,
            {.between = ' ',
             .least_cells = 1,
             .most_cells = 1,
             .stamp = StampOfSeconds,
             .row = "rows of a stamp in s"},
            mistakes, [&](std::int64_t stamp_ns, const std::vector<std::string>&) {
              if (rows < images.size()) stamped.push_back({stamp_ns, images[rows]});
              ++rows;
              return std::string();
            });
  if (mistakes.all().size() == before && rows != images.size())
    mistakes.Add(table.string(), "", fmt::format("it has {} stamps for {} images", rows, images.size()),
                 "valid: one for each");
  return stamped;
}

}  // namespace kestrel::vision
