#include "library/terrain/height_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "library/scene_error.h"
#include "tests/library/meshes/test_meshes.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using terrain::HeightGrid;
using terrain::HeightOptions;
using terrain::ParseHeights;

std::string RefusedHeights(const std::string& bytes, const std::string& name,
                           const HeightOptions& options = {}) {
  return Refusal([&] { ParseHeights(bytes, name, options); });
}
bool Has(std::string_view text, std::string_view part) { return text.find(part) != text.npos; }

/// The files that the fuzz target starts from, written by GDAL and Pillow.
std::filesystem::path Corpus() { return CDB_HEIGHTS_CORPUS; }
std::string BytesOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
/// The heights of all files of the corpus, but for those without data.
double HeightAt(std::size_t row, std::size_t column) {
  return 10 * static_cast<double>(row) + static_cast<double>(column) +
         (row == 2 && column == 3 ? 50 : 0);
}

TEST(Heights, AreRowsAlongZ) {
  const HeightGrid grid =
      ParseHeights("\xEF\xBB\xBF# a hill\r\n 0, 1 ,0\r\n\n+2,-3.5,4e-1", "hill.csv");
  EXPECT_EQ(grid.columns, 3u);
  EXPECT_EQ(grid.rows, 2u);
  EXPECT_EQ(grid.heights, (std::vector<double>{0, 1, 0, 2, -3.5, 0.4}));
  EXPECT_EQ(grid.scale, Vector3d(1, 1, 1));
}

struct GoodFile {
  const char* name;
  double unit;  ///< of the heights
  Vector3d scale;
  const char* unknown_scale;
};
const GoodFile kGoodFiles[] = {
    {"rows.csv", 1, {1, 1, 1}, ""},
    {"usual.asc", 1, {30, 1, 30}, ""},
    {"wrapped.asc", 1, {30, 1, 20}, ""},
    {"grey16.png", 257, {1, 1, 1}, "an image does not say how large"},
    {"grey16_interlaced.png", 257, {1, 1, 1}, "an image does not say how large"},
    {"grey16_transparent.png", 257, {1, 1, 1}, "an image does not say how large"},
    {"grey8.png", 1, {1, 1, 1}, "an image does not say how large"},
    {"grey_as_colours.png", 1, {1, 1, 1}, "an image does not say how large"},
    {"grey_as_colours_alpha.png", 1, {1, 1, 1}, "an image does not say how large"},
    {"grey_palette.png", 1, {1, 1, 1}, "an image does not say how large"},
    {"int16_strips.tif", 1, {30, 1, 20}, ""},
    {"uint16_lzw.tif", 1, {30, 1, 20}, ""},
    {"byte.tif", 1, {30, 1, 20}, ""},
    {"int32_big_endian.tif", 1, {30, 1, 20}, ""},
    {"float32_tiles_deflate.tif", 1, {30, 1, 20}, ""},
    {"float64_bigtiff.tif", 1, {30, 1, 20}, ""},
    {"degrees.tif", 1, {1, 1, 1}, "its cells are 0.0008333 by 0.0008333 degrees"},
    {"plain.tif", 1, {1, 1, 1}, "it does not say how large its cells are"},
    {"feet.tif", 1, {1, 1, 1}, "its cells are in feet, not in metres"},
};

TEST(Heights, OfEveryFormatAreTheSame) {
  for (const GoodFile& file : kGoodFiles) {
    SCOPED_TRACE(file.name);
    const HeightGrid grid =
        ParseHeights(BytesOf(Corpus() / file.name), file.name, {.no_data = -7.0});
    ASSERT_EQ(grid.columns, 7u);
    ASSERT_EQ(grid.rows, 5u);
    EXPECT_EQ(grid.scale, file.scale);
    EXPECT_TRUE(Has(grid.unknown_scale, file.unknown_scale)) << grid.unknown_scale;
    EXPECT_EQ(grid.unknown_scale.empty(), std::string_view(file.unknown_scale).empty());
    for (std::size_t row = 0; row < 5; ++row)
      for (std::size_t column = 0; column < 7; ++column) {
        const double height = grid.heights[row * 7 + column];
        // 46 in some of the files.
        const bool is_missing = row == 4 && column == 6 &&
                                (Has(file.name, "float32") || Has(file.name, "usual") ||
                                 Has(file.name, "transparent") || Has(file.name, "alpha"));
        EXPECT_EQ(height, is_missing ? -7 : file.unit * HeightAt(row, column))
            << row << " " << column;
      }
  }
}

TEST(Heights, WithoutDataAreNamedOrFilled) {
  const std::string csv = "1,2,3\n4,,nan\n-9999,5,6\n";
  EXPECT_EQ(RefusedHeights(csv, "a.csv"),
            "a.csv: 3 of 9 heights have no data, the first in row 2, column 2; `no_data: lowest` "
            "fills them with the lowest height, `no_data: 0` with this one");
  EXPECT_EQ(ParseHeights(csv, "a.csv", {.no_data = HeightOptions::Lowest()}).heights,
            (std::vector<double>{1, 2, 3, 4, 1, 1, 1, 5, 6}));
  // A real height that looks like a mark can be kept.
  EXPECT_EQ(ParseHeights("1,2\n3,-9999\n", "a.csv", {.no_data = -9999.0}).heights,
            (std::vector<double>{1, 2, 3, -9999}));
  EXPECT_TRUE(Has(RefusedHeights("nan,nan\n,-9999\n", "a.csv"), "a.csv: no height has data"));
  EXPECT_TRUE(Has(RefusedHeights(BytesOf(Corpus() / "usual.asc"), "a.asc"),
                  "a.asc: 1 of 35 heights has no data, the first in row 5, column 7"));
}

TEST(Heights, OfTilesAreBigEndianAndInDegrees) {
  std::string tile(2 * 1201 * 1201, '\0');
  tile[0] = '\x01';
  tile[1] = '\x02';
  tile[2 * 1201] = '\xff';  // the second row
  tile[2 * 1201 + 1] = '\xfe';
  const HeightGrid grid = ParseHeights(tile, "maps/S23W043.hgt");
  EXPECT_EQ(grid.columns, 1201u);
  EXPECT_EQ(grid.heights[0], 258);
  EXPECT_EQ(grid.heights[1201], -2);
  // cos(22.5 degrees) of a sixtieth of a degree of 111.2 km, times 3 / 60.
  EXPECT_EQ(grid.scale_remedy,
            "`scale: (85.61, 1, 92.66)` is about their size at latitude -22.5; or project the file "
            "to metres by `gdalwarp -t_srs`");
  EXPECT_EQ(ParseHeights(tile, "a.hgt", {.scale = Vector3d(85, 1, 92)}).unknown_scale, "");
  tile[2] = '\x80';
  EXPECT_TRUE(Has(RefusedHeights(tile, "a.hgt"), "1 of 1442401 heights has no data"));
  tile.pop_back();
  EXPECT_TRUE(Has(RefusedHeights(tile, "a.hgt"), "a.hgt: it has 2884801 bytes, but a tile"));
}

TEST(Heights, InDegreesAreToldFromMetres) {
  const auto why = [](const std::string& head) {
    return ParseHeights("ncols 2\nnrows 2\n" + head + "\n 400 500\n600 700\n", "a.asc")
        .unknown_scale;
  };
  const std::string degrees = "xllcorner 8.5\nyllcorner 47\ncellsize 0.00083333";
  EXPECT_EQ(why(degrees), "a.asc: its cells are 0.0008333 by 0.0008333 degrees, not metres");
  EXPECT_EQ(why("xllcorner 688000\nyllcorner 247000\ncellsize 0.05"), "");
  EXPECT_EQ(why("cellsize 30"), "");
  // A model of 3 cm on a table.
  EXPECT_EQ(ParseHeights("ncols 2\nnrows 2\ncellsize 0.01\n0 0.01\n0.005 0\n", "a.asc").scale,
            Vector3d(0.01, 1, 0.01));
}

const std::string kHead = "ncols 2\nnrows 2\ncellsize 1\n";

struct BrokenHeights {
  std::string name, text;
  const char* says;
};
class EveryBrokenGrid : public ::testing::TestWithParam<BrokenHeights> {};
INSTANTIATE_TEST_SUITE_P(
    Heights, EveryBrokenGrid,
    ::testing::Values(
        BrokenHeights{"a.csv", "", "a.csv: it has 0 by 0 heights; a height field needs at least"},
        BrokenHeights{"a.csv", "1,2\n", "a.csv: it has 1 by 2 heights"},
        BrokenHeights{"a.csv", "1\n2\n", "a.csv: it has 2 by 1 heights"},
        BrokenHeights{"a.csv", "1,2\n# no\n3\n", "a.csv:3: 1 heights in this row, but 2 in the"},
        BrokenHeights{"a.csv", "1,2\n3,4,\n", "a.csv:2: 3 heights in this row, but 2 in the first"},
        BrokenHeights{"a.csv", "1,x\n", "a.csv:1: `x` is not a height; write numbers, separated"},
        BrokenHeights{"a.csv", "1 2\n", "a.csv:1: `1 2` is not a height"},
        BrokenHeights{"a.doc", "1,2\n", "a.doc: unknown format; its name ends in .csv, .asc,"},
        BrokenHeights{"a.asc", "", "a.asc:1: the header has no ncols"},
        BrokenHeights{"a.asc", "1 2\n3 4\n", "a.asc:1: the header has no ncols"},
        BrokenHeights{"a.asc", "ncols 2\nncols 2\n", "a.asc:2: ncols is there twice"},
        BrokenHeights{"a.asc", "ncols x\n", "a.asc:1: ncols should be a single number"},
        BrokenHeights{"a.asc", "ncols 2 3\n", "a.asc:1: ncols should be a single number"},
        BrokenHeights{"a.asc", "ncol 2\n", "a.asc:1: `ncol` is not a key of an ESRI grid"},
        BrokenHeights{"a.asc", "ncols 2.5\nnrows 2\n1", "a.asc:3: ncols is 2.5; it counts"},
        BrokenHeights{"a.asc", "ncols 1e9\nnrows 1e9\n1", "a.asc: it has 1000000000 by 1000000000"},
        BrokenHeights{"a.asc", "ncols 2\nnrows 1\n1", "a.asc: it has 1 by 2 heights"},
        BrokenHeights{"a.asc", "ncols 2\nnrows 2\n1", "a.asc:3: the header has no cellsize"},
        BrokenHeights{"a.asc", "ncols 2\nnrows 2\ndx 1\n1", "a.asc:4: the header has no cellsize"},
        BrokenHeights{"a.asc", kHead + "dx 1\n1", "a.asc:5: the header has cellsize as well as dx"},
        BrokenHeights{"a.asc", "ncols 2\nnrows 2\ncellsize 0\n1", "size of a cell is not more"},
        BrokenHeights{"a.asc", kHead + "1 2\n3\n", "a.asc:5: the file ends after 3 of 2 by 2"},
        BrokenHeights{"a.asc", kHead + "1 2\n3 4\n5\n", "a.asc:6: more than 2 by 2 heights"},
        BrokenHeights{"a.asc", kHead + "1 2,5\n3 4\n",
                      "a.asc:4: `2,5` is not a height; write "
                      "numbers with a point"},
        BrokenHeights{"a.csv", kHead + "1 2\n3 4\n",
                      "a.csv: is an ESRI grid; let its name end in .asc"},
        BrokenHeights{"a.png", kHead, "a.png: is an ESRI grid; let its name end in .asc"},
        BrokenHeights{"a.png", "no", "a.png: byte 0: not a sound PNG file (the file is cut off)"},
        BrokenHeights{"a.tif", "no", "a.tif: byte 2: not a sound TIFF file"},
        BrokenHeights{"a.asc", "\x89PNG\r\n", "a.asc: is a PNG image; let its name end in .png"},
        BrokenHeights{"a.asc", "version https://git-lfs.github.com/spec/v1\n",
                      "a.asc: is a pointer of Git LFS; run `git lfs pull` where it is"},
        BrokenHeights{"a.r16", "", "a.r16: is heights without their number of columns"},
        BrokenHeights{"a.jpg", "", "a.jpg: is an image (JPEG); convert it: `convert a.jpg"}));
TEST_P(EveryBrokenGrid, IsRefusedByLine) {
  const std::string message = RefusedHeights(GetParam().text, GetParam().name);
  EXPECT_TRUE(Has(message, GetParam().says)) << message;
}

TEST(Heights, OfColouredImagesAreRefused) {
  EXPECT_TRUE(Has(
      RefusedHeights(BytesOf(Corpus() / "colours.png"), "a.png"),
      "a.png: the pixel in row 1, column 2 is no grey: heights are levels of grey; convert it: "));
}

/// A file that is cut off or changed gives an error that names it, or a grid of finite heights.
TEST(Heights, OfDamagedFilesAreRefusedOrFinite) {
  std::mt19937_64 random(3);
  const auto check = [](const std::string& bytes, const std::string& name) {
    try {
      const HeightGrid grid = ParseHeights(bytes, name, {.no_data = 0.0});
      ASSERT_EQ(grid.heights.size(), grid.columns * grid.rows);
      ASSERT_TRUE(grid.columns >= 2 && grid.rows >= 2);
      for (const double height : grid.heights) ASSERT_TRUE(std::isfinite(height));
      ASSERT_TRUE(grid.scale.allFinite() && grid.scale.minCoeff() > 0);
    } catch (const library::SceneError& error) {
      EXPECT_TRUE(std::string_view(error.what()).starts_with(name)) << error.what();
      EXPECT_FALSE(error.remedy().empty()) << error.what();
    }
  };
  for (const auto& entry : std::filesystem::directory_iterator(Corpus())) {
    const std::string name = entry.path().filename().string(), bytes = BytesOf(entry.path());
    SCOPED_TRACE(name);
    for (std::size_t size = 0; size < bytes.size(); ++size) check(bytes.substr(0, size), name);
    for (int i = 0; i < Cases(2000); ++i) {
      std::string damaged = bytes;
      for (std::uint64_t edits = 1 + random() % 3; edits > 0; --edits)
        damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
      check(damaged, name);
    }
  }
}

}  // namespace
}  // namespace cdb::tests
