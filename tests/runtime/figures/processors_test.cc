#include "runtime/printers/document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "runtime/figures/points.h"
#include "runtime/printers/show.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Three points with two detectors, each run on the processor that `cpu_of` names.
class Processors : public testing::Test {
 protected:
  void Merge(const std::vector<std::string>& cpu_of) {
    for (std::size_t i = 0; i < cpu_of.size(); ++i) {
      results::Provenance facts;
      if (!cpu_of[i].empty()) facts["cpu"] = cpu_of[i];
      WriteRun(plan_, plan_.runs[i], FakeResult(plan_.runs[i]).result, facts, folder_.path());
    }
    journal::Merge(plan_, {}, folder_.path(), folder_ / "out.h5");
  }
  std::string Text() const {
    const results::ResultFile file(folder_ / "out.h5");
    std::string text;
    for (const std::string& note : printers::ProcessorNotes(file, figures::AllCells(file)))
      text += "  " + note + "\n";
    return text;
  }

  const plan::Plan plan_ =
      MakePlan({NumberAxis("quantity", {1, 2, 3}), TextAxis("detector", {"sap", "dbvt"})}, 1, {});
  const TemporaryFolder folder_;
};

TEST_F(Processors, OfOneKindAreNotWorthALine) {
  Merge({"fast", "fast", "fast", "fast", "fast", "fast"});
  EXPECT_EQ(Text(), "");
}

TEST_F(Processors, OfSeveralKindsAreCounted) {
  Merge({"fast", "fast", "slow", "slow", "slow", "slow"});
  EXPECT_THAT(Text(), HasSubstr("2 runs on fast\n"));
  EXPECT_THAT(Text(), HasSubstr("4 runs on slow\n"));
  EXPECT_THAT(Text(), Not(HasSubstr("points"))) << "each point is of one kind";
  EXPECT_THAT(printers::Show(results::ResultFile(folder_ / "out.h5")).text, HasSubstr(Text()));
}

TEST_F(Processors, AreNamedWhereOnePointHasSeveral) {
  Merge({"fast", "slow", "slow", "slow"});  // and two runs are missing
  EXPECT_THAT(Text(), HasSubstr("1 run on fast\n"));
  EXPECT_THAT(Text(), HasSubstr("3 runs on slow\n"));
  EXPECT_THAT(Text(), HasSubstr("At 1 of 2 points, detectors or repeats ran on several of them."));
}

TEST_F(Processors, WithoutANameAreAKindOfTheirOwn) {
  Merge({"fast", "", "fast", "fast", "fast", "fast"});
  EXPECT_THAT(Text(), HasSubstr("1 run on a processor without a name\n"));
}

}  // namespace
}  // namespace cdb::tests
