// Every task is executed exactly once, whatever the threads do.
#include "library/detectors/kernels/thread_pool.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include "library/detectors/kernels/pair_buffer.h"

namespace cdb::kernels {
namespace {

class ThreadPools : public testing::TestWithParam<unsigned> {};

INSTANTIATE_TEST_SUITE_P(Sizes, ThreadPools, testing::Values(1, 2, 5));

TEST_P(ThreadPools, ExecuteEachTaskOnce) {
  ThreadPool pool(GetParam());
  EXPECT_EQ(pool.size(), GetParam());
  for (unsigned round = 0; round < 2000; ++round) {
    // Sessions, rounds outside of them, and pauses in which threads fall asleep.
    if (round % 400 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const ThreadPool::Session session(pool, round / 100 % 2 == 0);
    const unsigned tasks = round % 7 * GetParam();
    std::vector<unsigned> calls(tasks, 0);
    pool.Run(tasks, [&](unsigned task) { ++calls[task]; });
    EXPECT_EQ(calls, std::vector<unsigned>(tasks, 1)) << round;
  }
}

TEST_P(ThreadPools, FinishAllTasksBeforeAnErrorIsThrown) {
  ThreadPool pool(GetParam());
  for (int round = 0; round < 50; ++round) {
    std::vector<unsigned> calls(20, 0);
    EXPECT_THROW(pool.Run(20,
                          [&](unsigned task) {
                            ++calls[task];
                            if (task % 4 == 1) throw std::runtime_error("a task fails");
                          }),
                 std::runtime_error);
    EXPECT_EQ(calls, std::vector<unsigned>(20, 1));
    EXPECT_NO_THROW(pool.Run(3, [](unsigned) {}));
  }
}

TEST_P(ThreadPools, WorkAloneAfterAnInterruption) {
  ThreadPool pool(GetParam());
  const auto interrupt = [] { std::this_thread::sleep_for(std::chrono::milliseconds(2)); };
  std::vector<std::thread::id> executed(8);
  const auto run = [&] {
    pool.Run(8, [&](unsigned task) { executed[task] = std::this_thread::get_id(); });
  };
  {
    const ThreadPool::Session session(pool, true);
    interrupt();
  }
  EXPECT_FALSE(pool.IsAwake());
  for (int round = 0; round < 100; ++round) {
    run();
    EXPECT_EQ(executed, std::vector(8, std::this_thread::get_id()));
  }
  EXPECT_EQ(pool.IsResting(), GetParam() > 1);
  // It ends, even if no loop is worth sharing.
  for (int cycle = 0; cycle < 64; ++cycle) const ThreadPool::Session session(pool, false);
  EXPECT_FALSE(pool.IsResting());
}

TEST_P(ThreadPools, DividesRangesWithoutGaps) {
  PairParts parts(GetParam());
  for (const double work : {1., 1e4, 1e6})
    for (const std::size_t end : {0, 1, 63, 64, 65, 1000, 4099}) {
      std::vector<int> visits(end, 0);
      const unsigned count =
          parts.ForEach(work, 0, end, 64, [&](unsigned, std::size_t from, std::size_t to) {
            EXPECT_EQ(from % 64 == 0 || from == end, true);
            for (std::size_t i = from; i < to; ++i) ++visits[i];
          });
      EXPECT_LE(count, parts.most());
      EXPECT_EQ(visits, std::vector<int>(end, 1));
    }
}

}  // namespace
}  // namespace cdb::kernels
