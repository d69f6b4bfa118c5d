// Any bytes, read as heights of each format: the result is an error that names the file, or a grid
// of finite heights.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "dsl/text/check.h"
#include "library/scene_error.h"
#include "library/terrain/height_grid.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cdb;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const std::string name : {"fuzz.csv", "fuzz.asc", "fuzz.png", "fuzz.tif", "fuzz.hgt"}) try {
      const terrain::HeightGrid grid = terrain::ParseHeights(bytes, name, {.no_data = 0.0});
      CDB_CHECK(grid.columns >= 2 && grid.rows >= 2);
      CDB_CHECK(grid.heights.size() == grid.columns * grid.rows);
      for (const double height : grid.heights) CDB_CHECK(std::isfinite(height));
      CDB_CHECK(grid.scale.allFinite() && grid.scale.minCoeff() > 0);
    } catch (const library::SceneError& error) {
      CDB_CHECK(std::string_view(error.what()).starts_with(name));
    }
  return 0;
}
