// GeoTIFF and plain TIFF of one band by libtiff.
#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <span>
#include <utility>

#include "library/terrain/height_formats.h"
#include "library/terrain/height_grid.h"

namespace cdb::terrain {
namespace {

constexpr std::string_view kBandRemedy = "take one: `gdal_translate -b 1 {0} {1}_1.tif`";
constexpr std::string_view kBrokenRemedy = "download or export it again";

// Tags of GeoTIFF and GDAL, and keys of the former.
constexpr std::uint32_t kPixelScale = 33550, kTiePoints = 33922, kTransformation = 34264,
                        kGeoKeys = 34735, kGdalMetadata = 42112, kGdalNoData = 42113;
constexpr std::uint16_t kModelType = 1024, kGeographic = 2, kLinearUnits = 3076, kMetre = 9001;

/// A file in memory, and the first error.
struct Source {
  std::string_view bytes;
  std::uint64_t at = 0;
  std::string why = {};
};

tmsize_t ReadSome(thandle_t handle, void* to, tmsize_t count) {
  auto& source = *static_cast<Source*>(handle);
  const std::uint64_t left =
      source.bytes.size() - std::min<std::uint64_t>(source.at, source.bytes.size());
  const auto some = static_cast<std::size_t>(std::min(left, static_cast<std::uint64_t>(count)));
  if (some > 0) std::memcpy(to, source.bytes.data() + source.at, some);
  source.at += some;
  return static_cast<tmsize_t>(some);
}

toff_t Seek(thandle_t handle, toff_t to, int from) {
  auto& source = *static_cast<Source*>(handle);
  source.at = to + (from == SEEK_CUR ? source.at : from == SEEK_END ? source.bytes.size() : 0);
  return source.at;
}

int OnTiffError(TIFF*, void* source, const char*, const char* format, va_list values) {
  std::string& why = static_cast<Source*>(source)->why;
  char text[120];
  std::vsnprintf(text, sizeof text, format, values);
  if (why.empty()) why = text;
  return 1;
}

int OnTiffWarning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

using Tiff = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

Tiff Open(Source& source) {
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), OnTiffError, &source);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), OnTiffWarning, nullptr);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), 8 * tmsize_t{kMaxHeights});
  return {TIFFClientOpenExt(
              "", "rmC", &source, ReadSome, [](thandle_t, void*, tmsize_t) { return tmsize_t{0}; },
              Seek, [](thandle_t) { return 0; },
              [](thandle_t handle) -> toff_t { return static_cast<Source*>(handle)->bytes.size(); },
              nullptr, nullptr, options.get()),
          TIFFClose};
}

class TiffReader {
 public:
  TiffReader(std::string_view bytes, std::string_view name)
      : name_(name), source_{bytes}, tiff_(Open(source_)) {
    if (tiff_ == nullptr) RefuseBroken();
  }

  Raster Read() {
    CheckKind();
    FindMark();
    FindCell();
    ReadBlocks();
    CheckOtherImages();
    return std::move(raster_);
  }

 private:
  template <typename Number>
  Number Tag(std::uint32_t tag, Number otherwise) const {
    Number value = otherwise;
    return TIFFGetFieldDefaulted(tiff_.get(), tag, &value) != 0 ? value : otherwise;
  }
  /// The values of a tag that libtiff does not know; none if it is not there, or of another type.
  template <typename Number>
  std::span<const Number> Values(std::uint32_t tag, TIFFDataType type) const {
    const TIFFField* field = TIFFFindField(tiff_.get(), tag, type);
    if (field == nullptr || TIFFFieldReadCount(field) != TIFF_VARIABLE2) return {};
    std::uint32_t count = 0;
    const Number* values = nullptr;
    if (TIFFGetField(tiff_.get(), tag, &count, &values) == 0 || values == nullptr) return {};
    return {values, count};
  }
  std::span<const double> Reals(std::uint32_t tag) const {
    return Values<double>(tag, TIFF_DOUBLE);
  }
  std::string Text(std::uint32_t tag) const {
    const auto text = Values<char>(tag, TIFF_ASCII);
    return {text.begin(), std::ranges::find(text, '\0')};
  }

  void CheckKind() {
    const std::uint32_t columns = Tag<std::uint32_t>(TIFFTAG_IMAGEWIDTH, 0),
                        rows = Tag<std::uint32_t>(TIFFTAG_IMAGELENGTH, 0);
    bits_ = Tag<std::uint16_t>(TIFFTAG_BITSPERSAMPLE, 1);
    format_ = Tag<std::uint16_t>(TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
    if (const auto bands = Tag<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL, 1); bands != 1)
      RefuseFile(name_, fmt::format("it has {} bands; a height field has one", bands),
                 Command(kBandRemedy));
    // Scanners and old writers leave the tag out, which is no error of libtiff.
    std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
    TIFFGetField(tiff_.get(), TIFFTAG_PHOTOMETRIC, &photometric);
    if (photometric != PHOTOMETRIC_MINISBLACK)
      RefuseFile(name_, "its numbers are colours, not heights", "name the file of heights");
    const bool is_float = format_ == SAMPLEFORMAT_IEEEFP;
    const bool is_whole = format_ == SAMPLEFORMAT_INT || format_ == SAMPLEFORMAT_UINT;
    if (!(is_float && (bits_ == 32 || bits_ == 64)) &&
        !(is_whole && (bits_ == 8 || bits_ == 16 || bits_ == 32)))
      RefuseFile(name_, fmt::format("its numbers have {} bits of format {}", bits_, format_),
                 Command("convert them: `gdal_translate -ot Float32 {0} {1}_new.tif`"));
    if (Tag<std::uint16_t>(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT) != ORIENTATION_TOPLEFT)
      RefuseFile(name_, "its rows do not begin at the top left",
                 Command("turn them: `gdalwarp {0} {1}_new.tif`"));
    const std::string metadata = Text(kGdalMetadata);
    if (metadata.find("role=\"scale\"") != metadata.npos ||
        metadata.find("role=\"offset\"") != metadata.npos)
      RefuseFile(name_, "its numbers have a scale or an offset, which cdb does not apply",
                 Command("apply it: `gdal_translate -unscale -ot Float32 {0} {1}_new.tif`"));
    CheckSize(columns, rows, name_);
    raster_.columns = columns;
    raster_.rows = rows;
  }

  void FindMark() {
    if (const std::string text = Text(kGdalNoData); !text.empty()) {
      const std::size_t begin = std::min(text.find_first_not_of(' '), text.size() - 1);
      mark_ =
          HeightIn(std::string_view(text).substr(begin, text.find_last_not_of(' ') + 1 - begin));
      if (!mark_)
        RefuseFile(name_, fmt::format("GDAL_NODATA is `{}`, not a number", text),
                   Command("set it: `gdal_edit.py -a_nodata -9999 {0}`"));
    }
  }

  void FindCell() {
    const auto scale = Reals(kPixelScale), matrix = Reals(kTransformation), tie = Reals(kTiePoints);
    if (scale.size() >= 2) {
      raster_.cell = {scale[0], scale[1]};
      if (tie.size() >= 6)
        raster_.latitude = tie[4] + (tie[1] - static_cast<double>(raster_.rows) / 2) * scale[1];
    } else if (matrix.size() == 16) {
      if (matrix[1] != 0 || matrix[4] != 0)
        RefuseFile(name_, "its rows do not run from west to east",
                   Command("turn them: `gdalwarp {0} {1}_new.tif`"));
      raster_.cell = {matrix[0], -matrix[5]};
      raster_.latitude = matrix[7] + static_cast<double>(raster_.rows) / 2 * matrix[5];
    } else {
      raster_.unit = "it does not say how large its cells are";
      return;
    }
    if (!raster_.cell->allFinite() || !(raster_.cell->minCoeff() > 0))
      RefuseFile(
          name_,
          raster_.cell->y() < 0 && raster_.cell->x() > 0
              ? "its rows run from the south to the north"
              : fmt::format("its cells are {:g} by {:g}", raster_.cell->x(), raster_.cell->y()),
          Command("turn them: `gdalwarp {0} {1}_new.tif`"));
    if (raster_.latitude && !(std::abs(*raster_.latitude) <= 90)) raster_.latitude.reset();
    const auto keys = Values<std::uint16_t>(kGeoKeys, TIFF_SHORT);
    for (std::size_t i = 4; i + 3 < keys.size(); i += 4) {
      if (keys[i] == kModelType && keys[i + 3] == kGeographic) raster_.is_in_degrees = true;
      if (keys[i] == kLinearUnits && keys[i + 1] == 0 && keys[i + 3] != kMetre)
        raster_.unit = fmt::format("its cells are in {}, not in metres",
                                   keys[i + 3] == 9002 || keys[i + 3] == 9003
                                       ? "feet"
                                       : fmt::format("unit {} of EPSG", keys[i + 3]));
    }
  }

  double NumberAt(const unsigned char* at) const {
    const auto as = [&]<typename Number>(Number number) {
      std::memcpy(&number, at, sizeof number);
      return static_cast<double>(number);
    };
    if (format_ == SAMPLEFORMAT_IEEEFP) return bits_ == 32 ? as(float()) : as(double());
    if (format_ == SAMPLEFORMAT_INT)
      return bits_ == 8 ? as(std::int8_t()) : bits_ == 16 ? as(std::int16_t()) : as(std::int32_t());
    return bits_ == 8    ? as(std::uint8_t())
           : bits_ == 16 ? as(std::uint16_t())
                         : as(std::uint32_t());
  }

  bool IsMark(double number) const {
    if (std::isnan(number)) return true;
    if (!mark_) return false;
    // GDAL writes the mark of single precision with more digits than it has.
    return number == *mark_ || (format_ == SAMPLEFORMAT_IEEEFP && bits_ == 32 &&
                                static_cast<float>(number) == static_cast<float>(*mark_));
  }

  /// Strips are blocks as wide as the image.
  void ReadBlocks() {
    TIFF* tiff = tiff_.get();
    const bool is_tiled = TIFFIsTiled(tiff) != 0;
    const std::size_t bytes = bits_ / 8u;
    const std::size_t width = is_tiled ? Tag<std::uint32_t>(TIFFTAG_TILEWIDTH, 0) : raster_.columns,
                      height = std::min<std::size_t>(
                          Tag<std::uint32_t>(is_tiled ? TIFFTAG_TILELENGTH : TIFFTAG_ROWSPERSTRIP,
                                             0),
                          is_tiled ? SIZE_MAX : raster_.rows);
    const tmsize_t size = is_tiled ? TIFFTileSize(tiff) : TIFFStripSize(tiff);
    // Both factors are below 2^32, so that the product fits.
    if (width == 0 || height == 0 || size <= 0 || width * height > 4 * kMaxHeights ||
        static_cast<std::size_t>(size) < width * height * bytes)
      RefuseBroken();
    std::vector<unsigned char> block(static_cast<std::size_t>(size));
    raster_.heights.resize(raster_.columns * raster_.rows);
    std::uint32_t index = 0;
    for (std::size_t top = 0; top < raster_.rows; top += height)
      for (std::size_t left = 0; left < raster_.columns; left += width, ++index) {
        const std::size_t lines = std::min(height, raster_.rows - top),
                          cells = std::min(width, raster_.columns - left);
        const tmsize_t got = is_tiled ? TIFFReadEncodedTile(tiff, index, block.data(), size)
                                      : TIFFReadEncodedStrip(tiff, index, block.data(), size);
        if (got < 0 || static_cast<std::size_t>(got) < ((lines - 1) * width + cells) * bytes)
          RefuseBroken();
        for (std::size_t line = 0; line < lines; ++line)
          for (std::size_t cell = 0; cell < cells; ++cell) {
            const double number = NumberAt(&block[(line * width + cell) * bytes]);
            raster_.heights[(top + line) * raster_.columns + left + cell] =
                IsMark(number) ? kNoData : number;
          }
      }
  }

  /// After the first, smaller copies are allowed.
  void CheckOtherImages() {
    while (TIFFReadDirectory(tiff_.get()) != 0) {
      const auto kind = Tag<std::uint32_t>(TIFFTAG_SUBFILETYPE, 0);
      if ((kind & FILETYPE_MASK) != 0)
        RefuseFile(name_, "it has a mask of the heights without data, which cdb does not read",
                   Command("write them: `gdal_translate -a_nodata -9999 {0} {1}_new.tif`"));
      if ((kind & FILETYPE_REDUCEDIMAGE) == 0)
        RefuseFile(name_, "it has several images", "name a file with one");
    }
  }

  std::string Command(std::string_view remedy) const { return CommandFor(remedy, name_); }
  [[noreturn]] void RefuseBroken() const {
    RefuseFile(name_,
               fmt::format("byte {}: not a sound TIFF file{}", source_.at,
                           source_.why.empty() ? "" : fmt::format(" ({})", source_.why)),
               std::string(kBrokenRemedy));
  }

  const std::string_view name_;
  Source source_;
  Tiff tiff_;
  std::uint16_t bits_ = 0, format_ = 0;
  std::optional<double> mark_;
  Raster raster_;
};

}  // namespace

Raster ReadTiff(std::string_view bytes, std::string_view name) {
  return TiffReader(bytes, name).Read();
}

}  // namespace cdb::terrain
