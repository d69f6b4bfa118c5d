// Grey images by libpng.
#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstring>

#include "library/terrain/height_formats.h"

namespace cdb::terrain {
namespace {

/// All that the functions below change; plain, as libpng leaves them by longjmp.
struct Reading {
  const char* next;
  std::size_t left;
  char why[80];
  std::uint32_t columns, rows;
  int depth, channels;
  int transparent;  ///< a grey level, or -1
};

[[noreturn]] void OnPngError(png_structp png, png_const_charp why) {
  auto& reading = *static_cast<Reading*>(png_get_error_ptr(png));
  std::strncpy(reading.why, why, sizeof reading.why - 1);
  png_longjmp(png, 1);
}

void OnPngWarning(png_structp, png_const_charp) {}

void ReadBytes(png_structp png, png_bytep to, std::size_t count) {
  auto& reading = *static_cast<Reading*>(png_get_io_ptr(png));
  if (count > reading.left) png_error(png, "the file is cut off");
  std::memcpy(to, reading.next, count);
  reading.next += count;
  reading.left -= count;
}

/// False after an error.
bool ReadHead(png_structp png, png_infop info, Reading& reading) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_read_info(png, info);
  reading.columns = png_get_image_width(png, info);
  reading.rows = png_get_image_height(png, info);
  const int bits = png_get_bit_depth(png, info), colour = png_get_color_type(png, info);
  png_color_16p transparent = nullptr;
  if (colour == PNG_COLOR_TYPE_GRAY &&
      png_get_tRNS(png, info, nullptr, nullptr, &transparent) != 0 && transparent != nullptr)
    reading.transparent = transparent->gray * (bits < 8 ? 255 / ((1 << bits) - 1) : 1);
  if (colour == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (colour == PNG_COLOR_TYPE_GRAY && bits < 8) png_set_expand_gray_1_2_4_to_8(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  reading.depth = png_get_bit_depth(png, info);
  reading.channels = png_get_channels(png, info);
  return true;
}

/// `rows`: as many pointers as rows, for an interlaced image is read as a whole.
bool ReadRows(png_structp png, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

struct Png {
  explicit Png(Reading& reading)
      : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading, OnPngError, OnPngWarning)),
        info(png_create_info_struct(png)) {
    png_set_read_fn(png, &reading, ReadBytes);
  }
  ~Png() { png_destroy_read_struct(&png, &info, nullptr); }
  Png(const Png&) = delete;
  png_structp png;
  png_infop info;
};

}  // namespace

Raster ReadPng(std::string_view bytes, std::string_view name) {
  Reading reading = {bytes.data(), bytes.size(), "", 0, 0, 0, 0, -1};
  const auto check = [&](bool is_read) {
    if (!is_read)
      RefuseFile(name,
                 fmt::format("byte {}: not a sound PNG file ({})", bytes.size() - reading.left,
                             reading.why),
                 "download or export it again");
  };
  const Png png(reading);
  check(ReadHead(png.png, png.info, reading));
  CheckSize(reading.columns, reading.rows, name);
  const std::size_t depth_bytes = static_cast<std::size_t>(reading.depth / 8),
                    channels = static_cast<std::size_t>(reading.channels),
                    width = reading.columns * depth_bytes * channels;
  std::vector<unsigned char> pixels(width * reading.rows);
  std::vector<png_bytep> rows;
  for (std::size_t row = 0; row < reading.rows; ++row) rows.push_back(&pixels[row * width]);
  check(ReadRows(png.png, rows.data()));
  Raster raster;
  raster.columns = reading.columns;
  raster.rows = reading.rows;
  raster.is_image = true;
  raster.heights.reserve(raster.columns * raster.rows);
  // Grey levels may be stored as equal colours; an even number of channels ends with the opacity.
  const int opaque = depth_bytes == 2 ? 65535 : 255;
  for (std::size_t i = 0; i < pixels.size(); i += depth_bytes * channels) {
    const auto channel = [&](std::size_t number) {
      const unsigned char* at = &pixels[i + number * depth_bytes];
      return depth_bytes == 2 ? at[0] << 8 | at[1] : at[0];
    };
    const int grey = channel(0);
    const bool is_missing =
        grey == reading.transparent || (channels % 2 == 0 && channel(channels - 1) != opaque);
    if (!is_missing && channels > 2 && (channel(1) != grey || channel(2) != grey))
      RefuseFile(
          name,
          fmt::format("the pixel in row {}, column {} is no grey: heights are levels of grey",
                      raster.heights.size() / raster.columns + 1,
                      raster.heights.size() % raster.columns + 1),
          CommandFor("convert it: `convert {0} -colorspace Gray -depth 16 {1}_grey.png`", name));
    raster.heights.push_back(is_missing ? kNoData : grey);
  }
  return raster;
}

}  // namespace cdb::terrain
