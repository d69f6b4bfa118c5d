#include "compiler/lints/count_text.h"

#include <fmt/format.h>

namespace cdb::lints {

std::string CountText(std::size_t count, std::size_t looked_at, std::size_t runs) {
  return looked_at == runs
             ? fmt::format("{} of {} runs", count, runs)
             : fmt::format("{} of the {} runs that were checked, of {}", count, looked_at, runs);
}

}  // namespace cdb::lints
