#include "runtime/protocol/machine/machine.h"

#include <gtest/gtest.h>
#include <sched.h>

namespace cdb::tests {
namespace {

TEST(Host, CountsProcessorsThatAProgramMayNotUse) {
  cpu_set_t before, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  const double online = machine::OnlineProcessorCount();
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(machine::ProcessorCount(), 1);
  EXPECT_EQ(machine::OnlineProcessorCount(), online);
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
  EXPECT_GE(online, machine::ProcessorCount());
}

}  // namespace
}  // namespace cdb::tests
