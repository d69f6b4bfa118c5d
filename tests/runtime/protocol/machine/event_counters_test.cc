#include "runtime/protocol/machine/event_counters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "tests/support/new_pages.h"

namespace cdb::tests {
namespace {

using machine::EventCounters;
using schema::Counter;

double CountOf(const machine::Counts& counts, Counter counter) {
  return counts[static_cast<std::size_t>(counter)];
}

TEST(EventCounters, CountPageFaultsExactly) {
  NewPages pages;
  const EventCounters counters;
  machine::Counts before = counters.Read(), after = before;
  // The first round loads the code of the second.
  for (int round = 0; round < 2; ++round) {
    before = counters.Read();
    pages.Touch(100);
    after = counters.Read();
  }
  const double faults =
      CountOf(after, Counter::kPageFaults) - CountOf(before, Counter::kPageFaults);
  const bool is_missing =
      std::ranges::find(counters.missing(), Counter::kPageFaults,
                        &machine::MissingCounter::counter) != counters.missing().end();
  if (is_missing) {
    EXPECT_TRUE(std::isnan(faults));
  } else {
    EXPECT_EQ(faults, 100);
  }
}

TEST(EventCounters, AreEitherCountedOrMissingForAReason) {
  const EventCounters counters;
  const machine::Counts counts = counters.Read();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto missing = std::ranges::find(counters.missing(), static_cast<Counter>(i),
                                           &machine::MissingCounter::counter);
    EXPECT_EQ(std::isnan(counts[i]), missing != counters.missing().end()) << schema::kCounters[i];
    if (missing != counters.missing().end()) {
      EXPECT_FALSE(missing->why.empty());
    }
  }
  EXPECT_EQ(counters.CountsNothing(), counters.missing().size() == counts.size());
}

TEST(EventCounters, AreNotHiddenByAProcessorThatCountsOthers) {
  const EventCounters counters;
  const machine::Counts counts = counters.Read();
  if (std::isnan(CountOf(counts, Counter::kInstructions)) &&
      std::isnan(CountOf(counts, Counter::kCpuCycles)))
    GTEST_SKIP() << "there are no counters of the processor";
  for (const machine::MissingCounter& missing : counters.missing())
    EXPECT_EQ(missing.why.find("most virtual machines"), std::string::npos) << missing.why;
}

TEST(EventCounters, CountTheInstructionsOfALoop) {
  const EventCounters counters;
  const double before = CountOf(counters.Read(), Counter::kInstructions);
  volatile int sink = 0;
  for (int i = 0; i < 100000; ++i) sink = sink + i;
  const double count = CountOf(counters.Read(), Counter::kInstructions) - before;
  EXPECT_TRUE(std::isnan(count) || (count > 100000 && count < 3000000)) << count;
}

TEST(EventCounters, DoNotCountOtherThreads) {
  NewPages pages;
  const EventCounters counters;
  std::thread([&pages] { pages.Touch(1); }).join();  // what starting a thread needs
  const auto faults = [&] { return CountOf(counters.Read(), Counter::kPageFaults); };
  const double before = faults();
  std::thread([&pages] { pages.Touch(500); }).join();
  const double count = faults() - before;
  EXPECT_TRUE(std::isnan(count) || count < 100) << count;
}

TEST(EventCounters, OfNoneCountNothing) {
  const EventCounters counters(std::span<const Counter>{});
  EXPECT_TRUE(counters.CountsNothing());
  EXPECT_TRUE(counters.missing().empty());
  for (const double count : counters.Read()) EXPECT_TRUE(std::isnan(count));
}

TEST(EventCounters, AreNamedByTheirReasons) {
  EXPECT_EQ(machine::MissingText({}), "");
  const machine::MissingCounter missing[] = {{Counter::kCpuCycles, "no reason"},
                                             {Counter::kPageFaults, "another"},
                                             {Counter::kCacheMisses, "no reason"}};
  EXPECT_EQ(machine::MissingText(missing),
            "cpu_cycles, cache_misses (no reason); page_faults (another)");
}

}  // namespace
}  // namespace cdb::tests
