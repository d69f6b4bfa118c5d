// Prints the results of a sweep that must not depend on where it is executed: id, status and final
// state of each run.
//   result_states out.h5
#include <fmt/format.h>

#include "runtime/figures/points.h"
#include "runtime/results/store.h"

int main(int argc, char** argv) {
  using namespace cdb;
  if (argc != 2) return 2;
  const results::ResultFile file(argv[1]);
  for (const results::ResultFile::Cell& cell : figures::AllCells(file))
    fmt::print("{} {} {}\n", file.ReadText("run_id", cell),
               results::StatusName(file.ReadStatus(cell)), file.ReadText("state_hash", cell));
  return 0;
}
