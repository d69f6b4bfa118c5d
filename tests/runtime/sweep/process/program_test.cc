#include "runtime/sweep/process/program.h"

#include <gtest/gtest.h>

namespace cdb::tests {
namespace {

TEST(RunProgram, CollectsBothOutputsAndTheStatus) {
  const auto end = process::RunProgram({"sh", "-c", "cat; echo no >&2; exit 7"}, "yes\n");
  ASSERT_TRUE(end.has_value());
  EXPECT_EQ(end->out, "yes\n");
  EXPECT_EQ(end->err, "no\n");
  EXPECT_EQ(end->status, 7);
}

TEST(RunProgram, InputMayBeLeftUnread) {
  const auto end = process::RunProgram({"sh", "-c", "exec <&-; exit 3"}, std::string(60'000, 'x'));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->status, 3);
}

TEST(RunProgram, OutputMayBeLongerThanAPipe) {
  const auto end =
      process::RunProgram({"sh", "-c", "head -c 300000 /dev/zero >&2; head -c 300000 /dev/zero"});
  EXPECT_EQ(end->out.size(), 300000u);
  EXPECT_EQ(end->err.size(), 300000u);
}

TEST(RunProgram, ASignalCountsAsTheShellCountsIt) {
  EXPECT_EQ(process::RunProgram({"sh", "-c", "kill -KILL $$"})->status, 128 + 9);
}

TEST(RunProgram, AProgramThatIsNotThereIsNone) {
  EXPECT_FALSE(process::RunProgram({"no-such-program-of-cdb"}).has_value());
}

}  // namespace
}  // namespace cdb::tests
