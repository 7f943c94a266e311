// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/mosaic_files.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <filesystem>

#include "vision/enhance/canvas/geotiff.h"
#include "vision/write_image.h"

namespace kestrel::app {

std::string MosaicFile(const std::string& file, int i) {
  if (i == 0) return file;
  const std::filesystem::path path(file);
  return (path.parent_path() / fmt::format("{}_{}{}", path.stem().string(), i + 1, path.extension().string()))
      .string();
}

WrittenMosaic WriteMosaic(const vision::Mosaic& mosaic, int i, const vision::CompositionOptions& options,
                          const std::string& picture_file, const std::string& geotiff_file) {
  const vision::MosaicPicture picture = vision::Compose(mosaic, options);
  if (picture.image.empty()) return {};
  WrittenMosaic written{
      fmt::format("mosaic {}: {} x {} pixels", i + 1, picture.image.cols, picture.image.rows)};
  if (picture.scale > 1) written.sentence += fmt::format(", scaled down to 1:{:g}", picture.scale);
  if (!picture_file.empty()) {
    vision::WriteImage(MosaicFile(picture_file, i), picture.image);
    written.sentence += fmt::format(", {}", MosaicFile(picture_file, i));
  }
  const auto ground = mosaic.GroundFromSurface();
  if (geotiff_file.empty()) return written;
  written.whole = ground.has_value();
  if (!ground) {
    written.sentence += "; no GeoTIFF: none of its images has a pose above the ground";
    return written;
  }
  vision::WriteGeoTiff(MosaicFile(geotiff_file, i), picture, *ground);
  written.sentence += fmt::format(", {}", MosaicFile(geotiff_file, i));
  return written;
}

std::string MosaicTable(const vision::MosaicSeries& series, const std::vector<double>& times_s,
                        const std::string& device) {
  std::string table =
      "frame,t_s,mosaic,state,keyframe,is_keyframe,agreed,rms_px,shared,loops,adjusted,u_px,v_px,north_m,"
      "east_m,device\n";
  for (std::size_t i = 0; i < series.places().size(); ++i) {
    const auto& place = series.places()[i];
    table +=
        fmt::format("{},{:.9f},{},{},", i, times_s[i], place.mosaic + 1, vision::NameOf(place.step.state));
    if (!vision::IsPlaced(place.step.state)) {
      table += fmt::format(",,,,,,,,,,,{}\n", device);
      continue;
    }
    const vision::Mosaic& mosaic = series.mosaic(place.mosaic);
    const cv::Size size = mosaic.projection().image_size();
    const auto at = mosaic.PlaceOf(place.number, {(size.width - 1) / 2.0, (size.height - 1) / 2.0});
    table += fmt::format("{},{:d},{},{:.3f},{:.3f},{},{:d},", place.step.keyframe, place.step.is_keyframe,
                         place.step.agreed, place.step.rms_px, place.step.shared, place.step.loops,
                         place.step.adjusted);
    table += at ? fmt::format("{:.3f},{:.3f},", at->x(), at->y()) : ",,";
    const auto ground = mosaic.GroundFromSurface();
    if (at && ground) {
      const Eigen::Vector3d N = *ground * Eigen::Vector3d(at->x(), at->y(), 1);
      table += fmt::format("{:.4f},{:.4f},{}\n", N.x(), N.y(), device);
    } else {
      table += fmt::format(",,{}\n", device);
    }
  }
  return table;
}

}  // namespace kestrel::app
