// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/canvas/geotiff.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

namespace kestrel::vision {
namespace {

// Tags of GeoTIFF that libtiff does not know by itself.
constexpr ttag_t kModelPixelScale = 33550, kModelTiepoint = 33922, kGeoKeyDirectory = 34735,
                 kGeoAscii = 34737;

TIFFExtendProc next_extender = nullptr;

void AddTags(TIFF* tiff) {
  static std::array<char[24], 4> names = {"ModelPixelScale", "ModelTiepoint", "GeoKeyDirectory",
                                          "GeoAsciiParams"};
  static const std::array<TIFFFieldInfo, 4> fields = {
      TIFFFieldInfo{kModelPixelScale, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, names[0]},
      TIFFFieldInfo{kModelTiepoint, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, names[1]},
      TIFFFieldInfo{kGeoKeyDirectory, -1, -1, TIFF_SHORT, FIELD_CUSTOM, 1, 1, names[2]},
      TIFFFieldInfo{kGeoAscii, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, names[3]}};
  TIFFMergeFieldInfo(tiff, fields.data(), static_cast<std::uint32_t>(fields.size()));
  if (next_extender) next_extender(tiff);
}

struct Closer {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};

// Blue, green, red or grey, with what was seen as alpha.
cv::Mat WithAlpha(const MosaicPicture& picture) {
  cv::Mat rgba;
  cv::cvtColor(picture.image, rgba, picture.image.channels() == 1 ? cv::COLOR_GRAY2RGBA : cv::COLOR_BGR2RGBA);
  cv::insertChannel(picture.shown, rgba, 3);
  return rgba;
}

void WriteTags(TIFF* tiff, const MosaicPicture& picture, const Eigen::Matrix3d& ground) {
  const auto n_of = [&](double x,
                        double y) {  // of a place of the picture, whose first pixel's middle is (0, 0)
    const Eigen::Vector2d at = picture.origin + picture.scale * Eigen::Vector2d(x, y);
    return Eigen::Vector3d(ground * Eigen::Vector3d(at.x(), at.y(), 1));
  };
  const Eigen::Vector3d corner = n_of(-0.5, -0.5), east = n_of(0.5, -0.5), south = n_of(-0.5, 0.5);
  const std::array<double, 3> scale = {east.y() - corner.y(), corner.x() - south.x(), 0};
  const std::array<double, 6> tiepoint = {0, 0, 0, corner.y(), corner.x(), 0};
  // Version 1.1.0 and the number of keys; then key, where its value is, how many, value.
  static const char kCitation[] =
      "Kestrel N: metres, x east, y north of where the autopilot was switched on|";
  const auto characters = static_cast<std::uint16_t>(sizeof(kCitation) - 1);
  constexpr std::uint16_t kUserDefined = 32767, kPixelIsArea = 1, kMetre = 9001;
  const std::vector<std::uint16_t> keys = {1,    1,         1,          4,             //
                                           1024, 0,         1,          kUserDefined,  // GTModelType
                                           1025, 0,         1,          kPixelIsArea,  // GTRasterType
                                           1026, kGeoAscii, characters, 0,             // GTCitation
                                           3076, 0,         1,          kMetre};       // ProjLinearUnits
  TIFFSetField(tiff, kModelPixelScale, static_cast<int>(scale.size()), scale.data());
  TIFFSetField(tiff, kModelTiepoint, static_cast<int>(tiepoint.size()), tiepoint.data());
  TIFFSetField(tiff, kGeoKeyDirectory, static_cast<int>(keys.size()), keys.data());
  TIFFSetField(tiff, kGeoAscii, kCitation);
}

}  // namespace

bool GeoTiffIsAvailable() { return true; }

void WriteGeoTiff(const std::filesystem::path& file, const MosaicPicture& picture,
                  const Eigen::Matrix3d& ground) {
  static const bool extended = [] {
    next_extender = TIFFSetTagExtender(AddTags);
    return true;
  }();
  static_cast<void>(extended);
  const std::filesystem::path partial = file.string() + ".part";
  const auto fail = [&](const char* why) {
    std::error_code none;
    std::filesystem::remove(partial, none);
    return std::runtime_error(fmt::format("{}: {}", file.string(), why));
  };
  {
    const std::unique_ptr<TIFF, Closer> tiff(TIFFOpen(partial.c_str(), "w"));
    if (!tiff) throw fail("cannot be written");
    const cv::Mat rgba = WithAlpha(picture);
    TIFFSetField(tiff.get(), TIFFTAG_IMAGEWIDTH, rgba.cols);
    TIFFSetField(tiff.get(), TIFFTAG_IMAGELENGTH, rgba.rows);
    TIFFSetField(tiff.get(), TIFFTAG_SAMPLESPERPIXEL, 4);
    TIFFSetField(tiff.get(), TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff.get(), TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
    TIFFSetField(tiff.get(), TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff.get(), TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    TIFFSetField(tiff.get(), TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
    TIFFSetField(tiff.get(), TIFFTAG_ROWSPERSTRIP, 64);
    const std::uint16_t alpha = EXTRASAMPLE_UNASSALPHA;
    TIFFSetField(tiff.get(), TIFFTAG_EXTRASAMPLES, 1, &alpha);
    WriteTags(tiff.get(), picture, ground);
    std::vector<std::uint8_t> row(static_cast<std::size_t>(rgba.cols) * 4);
    for (int y = 0; y < rgba.rows; ++y) {
      std::copy_n(rgba.ptr<std::uint8_t>(y), row.size(), row.data());
      if (TIFFWriteScanline(tiff.get(), row.data(), static_cast<std::uint32_t>(y)) < 0)
        throw fail("cannot be written to its end");
    }
    if (TIFFFlush(tiff.get()) == 0) throw fail("cannot be written to its end");
  }
  std::error_code error;
  std::filesystem::rename(partial, file, error);
  if (error) throw fail(error.message().c_str());
}

}  // namespace kestrel::vision
