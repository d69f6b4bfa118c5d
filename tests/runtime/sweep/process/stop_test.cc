#include "runtime/sweep/process/stop.h"

#include <gtest/gtest.h>
#include <signal.h>

namespace cdb::tests {
namespace {

TEST(StopTest, ASignalSetsTheFlag) {
  process::StopFlag flag;
  {
    const process::StopOnSignals watch(flag);
    EXPECT_FALSE(flag.requested());
    raise(SIGTERM);
    EXPECT_EQ(flag.signal(), SIGTERM);
    raise(SIGINT);
    EXPECT_EQ(flag.signal(), SIGTERM) << "the first counts";
    struct sigaction now = {};
    sigaction(SIGTERM, nullptr, &now);
    EXPECT_EQ(now.sa_handler, SIG_DFL) << "a second one ends the process";
  }
  struct sigaction now = {};
  sigaction(SIGHUP, nullptr, &now);
  EXPECT_EQ(now.sa_handler, SIG_DFL);
}

TEST(StopTest, AnIgnoredSignalStaysIgnored) {
  signal(SIGHUP, SIG_IGN);
  process::StopFlag flag;
  {
    const process::StopOnSignals watch(flag);
    raise(SIGHUP);
    EXPECT_FALSE(flag.requested());
  }
  struct sigaction now = {};
  sigaction(SIGHUP, nullptr, &now);
  EXPECT_EQ(now.sa_handler, SIG_IGN);
  signal(SIGHUP, SIG_DFL);
}

}  // namespace
}  // namespace cdb::tests
