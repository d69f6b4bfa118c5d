// A small sweep that tests of commands run, and the ends of its runs.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>

#include "runtime/results/store.h"

namespace cdb::tests {

inline constexpr char kSmall[] =
    "benchmark small {\n  cycles 20\n  world.side 400\n  detector sweep(sap, dbvt)\n"
    "  objects { quantity sweep(5, 20); type any(sphere, cuboid, cylinder, cone)\n"
    "    linear_velocity uniform(-200, 200) }\n}\n";

/// The state hash of every run, by its id; fails if a run is missing or did not succeed.
inline std::map<std::string, std::string> Hashes(const std::filesystem::path& file) {
  const results::ResultFile result(file);
  std::map<std::string, std::string> hashes;
  results::ResultFile::Cell cell;
  cell.at.assign(result.axes().size(), 0);
  for (;;) {
    for (cell.rep = 0; cell.rep < result.repeats(); ++cell.rep) {
      const results::Status status = result.ReadStatus(cell);
      if (status == results::Status::kSkipped) continue;
      EXPECT_EQ(status, results::Status::kDone);
      const std::string hash = result.ReadText("state_hash", cell);
      EXPECT_EQ(hash.size(), 16u);
      hashes[result.ReadText("run_id", cell)] = hash;
    }
    std::size_t i = cell.at.size();
    while (i > 0 && ++cell.at[i - 1] == result.axes()[i - 1].values.size()) cell.at[--i] = 0;
    if (i == 0) return hashes;
  }
}

}  // namespace cdb::tests
