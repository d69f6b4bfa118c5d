#include <gtest/gtest.h>

#include <algorithm>

#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

// The poses and contacts of a single cycle of a cell, in a file where other cells have different
// ones.
TEST(ResultFile, ReadsSingleCyclesAndContacts) {
  const plan::Plan plan =
      MakePlan({NumberAxis("size", {1, 2})}, 2,
               {.cycles = 5, .objects = 3, .record = {"timing", "counts", "contacts", "poses"}});
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs)
    WriteRun(plan, run, FakeResult(run).result, TestProvenance(), folder.path());
  journal::Merge(plan, TestProvenance(), folder.path(), folder / "out.h5");
  results::ResultFile file(folder / "out.h5");
  const protocol::Series& poses = *protocol::FindSeries("poses");
  for (const plan::Run& run : plan.runs) {
    const results::ResultFile::Cell cell{run.at, run.rep};
    std::uint64_t row = 0;
    for (std::uint64_t cycle = 0; cycle < 5; ++cycle) {
      const std::vector<double> read = file.ReadCycle("poses", cell, cycle);
      ASSERT_EQ(read.size(), 3 * protocol::kPoseSize);
      for (std::size_t i = 0; i < read.size(); ++i)
        EXPECT_EQ(read[i], ValueAt(run, poses, cycle * read.size() + i));
      const auto count = static_cast<std::uint64_t>(ContactsIn(run, cycle));
      for (const protocol::ContactRecord& contact : file.ReadContacts(cell, row, count)) {
        const protocol::ContactRecord expected = ContactAt(run, row++);
        EXPECT_EQ(contact.body_a, expected.body_a);
        EXPECT_EQ(contact.body_b, expected.body_b);
        EXPECT_TRUE(std::ranges::equal(contact.point, expected.point));
        EXPECT_TRUE(std::ranges::equal(contact.normal, expected.normal));
        EXPECT_EQ(contact.distance, expected.distance);
      }
    }
  }
  // A cell of a selection is read at its place in the whole file.
  file.Select(0, {1});
  const plan::Run& last = plan.runs.back();
  EXPECT_EQ(file.ReadCycle("poses", {{0}, last.rep}, 4)[0],
            ValueAt(last, poses, 4 * 3 * protocol::kPoseSize));
}

}  // namespace
}  // namespace cdb::tests
