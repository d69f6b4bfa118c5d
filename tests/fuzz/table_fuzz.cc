// Any bytes, read as a table of poses, of a path and of numbers, in each form: the result is an
// error that names the file, or finite numbers in each row.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "compiler/plan/text_table.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"
#include "library/layouts/pose_table.h"
#include "library/scene_error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cdb;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto is_named = [](std::string_view error) { return error.starts_with("fuzz.csv"); };
  for (const char separator : {'\0', ',', ';', '\t', ' '})
    for (const char decimal : {'\0', ',', '.'}) try {
        plan::TextTable table(text, "fuzz.csv", {separator, decimal, {}, decimal == '.'});
        CDB_CHECK(table.headings().empty() || table.headings().size() == table.width());
        for (std::size_t i = 0; i < table.width(); ++i) {
          const plan::Column column = table.At(i);
          table.FindDecimal({&column, 1});
          for (std::size_t row = 0; row < table.rows(); ++row)
            CDB_CHECK(!std::isnan(table.Number(row, column)));
        }
      } catch (const plan::TableError& error) {
        CDB_CHECK(is_named(error.what()) && !error.remedy.empty());
      }
  for (const auto parse : {layouts::ParsePoseCsv, layouts::ParsePathCsv}) try {
      for (const layouts::PoseRow& row : parse(text, "fuzz.csv").rows)
        CDB_CHECK(row.position.allFinite() && std::abs(row.orientation.norm() - 1) < 1e-9);
    } catch (const library::SceneError& error) {
      CDB_CHECK(is_named(error.what()) && !error.remedy().empty());
    }
  return 0;
}
