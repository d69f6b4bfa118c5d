// Which files belong to one series of a history.
#include "runtime/figures/history/histories.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace cdb::tests {
namespace {

using history::FileFigures;

/// `scene`: empty as of a file whose plan cannot be read.
FileFigures FileOfCommit(int commit, const std::string& scene, bool has_counters) {
  FileFigures file;
  file.file = std::to_string(commit) + ".h5";
  file.benchmark = "fixture";
  file.place = commit;
  file.points = {{"quantity 10", scene, {{"step", has_counters ? 4000.0 : 1000.0}}, ""}};
  file.has_counters = has_counters;
  return file;
}

TEST(Histories, KeepTimesWithCountersApartIfPlansCannotBeRead) {
  // The last files have a plan of this version, or none has.
  for (const bool is_last_readable : {false, true}) {
    std::vector<FileFigures> files;
    for (int commit = 0; commit < 16; ++commit) {
      const bool has_counters = commit >= 8 && commit < 14;
      files.push_back(FileOfCommit(
          commit, is_last_readable && commit >= 13 ? has_counters ? "counted" : "plain" : "",
          has_counters));
    }
    const std::vector<history::History> histories = history::MakeHistories(files, {});
    ASSERT_EQ(histories.size(), 1u);
    ASSERT_EQ(histories[0].series.size(), 2u);
    EXPECT_EQ(histories[0].series[0].values, std::vector<double>(10, 1000));
    EXPECT_EQ(histories[0].series[1].values, std::vector<double>(6, 4000));
    EXPECT_TRUE(histories[0].changes.empty());
  }
}

}  // namespace
}  // namespace cdb::tests
