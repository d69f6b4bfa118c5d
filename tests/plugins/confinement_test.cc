// Hostile detectors: what the worker denies them, and what they can still break.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>

#include <map>
#include <string>
#include <vector>

#include "runtime/results/store.h"
#include "tests/plugins/cell_ends.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

const std::vector<std::string> kRefused = {
    "opens_a_socket",     "makes_a_file",      "writes_a_file",     "removes_a_file",
    "changes_rights",     "executes",          "starts_a_process",  "leaves_its_group",
    "signals_the_runner", "traces_the_runner", "raises_its_limits", "shares_memory"};

std::string HostileRun(const std::string& statements) {
  return fmt::format(
      "use detector \"{}\"\nbenchmark b {{\n  cycles 3\n  world.side 250\n  {}\n"
      "  objects {{ quantity 30; linear_velocity uniform(-100, 100) }}\n}}\n",
      (BuildFolder() / "tests/plugins/hostile.so").string(), statements);
}

TEST(Confinement, RefusesWhatADetectorDoesNotNeed) {
  if (prctl(PR_GET_SECCOMP) < 0) GTEST_SKIP() << "this kernel has no seccomp";
  const Program program;
  program.Write("victim", "as it was\n");
  program.Write("b.cdb", HostileRun(fmt::format("detector sweep({}, threads_and_reading)",
                                                fmt::join(kRefused, ", "))));
  EXPECT_EQ(program.Run({"run", "b.cdb", "-q"}).status, 0);
  for (const auto& [name, end] : Ends(program.folder() / "b.h5"))
    EXPECT_EQ(end.status, results::Status::kDone) << name << ": " << end.message;
  EXPECT_EQ(program.Read("victim"), "as it was\n");
  EXPECT_FALSE(program.Exists("escaped"));
}

/// Each attempt succeeds without confinement, so that the test above can fail.
TEST(Confinement, CanBeTurnedOff) {
  const Program program;
  for (const std::string& name : kRefused) {
    program.Write("victim", "as it was\n");
    program.Write("b.cdb", HostileRun("detector sweep(" + name + ")"));
    program.Shell("rm -rf escaped; CDB_UNCONFINED_PLUGINS=1 \"$CDB\" run b.cdb -q --fresh");
    const CellEnd end = Ends(program.folder() / "b.h5").at(name);
    EXPECT_NE(end.status, results::Status::kDone) << name;
    EXPECT_EQ(Has(end.message, "allowed"), name != "executes") << name << end.message;
  }
}

TEST(Confinement, HoldsOnTracesToo) {
  if (prctl(PR_GET_SECCOMP) < 0) GTEST_SKIP() << "this kernel has no seccomp";
  const Program program;
  program.Write("t.cdb", "benchmark t { cycles 5; objects.quantity 20 }");
  ASSERT_EQ(program.Run({"trace", "t.cdb", "-q", "-o", "t.h5"}).status, 0);
  program.Write("b.cdb", fmt::format("use detector \"{}\"\nbenchmark b {{ trace \"t.h5\"; detector "
                                     "sweep(makes_a_file, starts_a_process) }}\n",
                                     (BuildFolder() / "tests/plugins/hostile.so").string()));
  EXPECT_EQ(program.Run({"run", "b.cdb", "-q"}).status, 0);
  EXPECT_FALSE(program.Exists("escaped"));
}

TEST(Confinement, DamageOfTheHeapIsFound) {
  const Program program;
  program.Write("b.cdb", HostileRun("detector sweep(dbvt, writes_past_its_pairs, "
                                    "crashes_in_its_destructor)"));
  EXPECT_EQ(program.Run({"run", "b.cdb", "-q"}).status, 3);
  const auto ends = Ends(program.folder() / "b.h5");
  EXPECT_EQ(ends.at("dbvt").status, results::Status::kDone);
  EXPECT_EQ(ends.at("writes_past_its_pairs").status, results::Status::kCrashed);
  EXPECT_EQ(ends.at("crashes_in_its_destructor").status, results::Status::kCrashed);
  EXPECT_TRUE(Has(ends.at("crashes_in_its_destructor").message,
                  "destroying detector `crashes_in_its_destructor`"))
      << ends.at("crashes_in_its_destructor").message;
}

TEST(Confinement, ItsRecordingIsCheckedAndHasNoDescriptor) {
  const Program program;
  program.Write("b.cdb", HostileRun("record timing, counts, stability; detector sweep(dbvt, "
                                    "holds_descriptors, overwrites_its_recording)"));
  for (const char* how : {"", "CDB_UNCONFINED_PLUGINS=1 "}) {
    EXPECT_EQ(program.Shell(std::string(how) + "\"$CDB\" run b.cdb -q --fresh").status, 3) << how;
    const auto ends = Ends(program.folder() / "b.h5");
    EXPECT_EQ(ends.at("dbvt").status, results::Status::kDone);
    EXPECT_EQ(ends.at("holds_descriptors").status, results::Status::kDone)
        << ends.at("holds_descriptors").message;
    EXPECT_EQ(ends.at("overwrites_its_recording").status, results::Status::kFailed);
    EXPECT_TRUE(Has(ends.at("overwrites_its_recording").message, "has no value in cycle 0"))
        << ends.at("overwrites_its_recording").message;
  }
}

TEST(MemoryLimit, EndsTheRunThatExceedsItAndNoOther) {
  if (kAddressSanitizer) GTEST_SKIP() << "shadow memory exceeds any limit";
  const Program program;
  program.Write("b.cdb", HostileRun("memory 500 MB; detector sweep(dbvt, takes_memory)"));
  EXPECT_EQ(program.Run({"run", "b.cdb", "-q"}).status, 3);
  const auto ends = Ends(program.folder() / "b.h5");
  EXPECT_EQ(ends.at("dbvt").status, results::Status::kDone) << ends.at("dbvt").message;
  const CellEnd& over = ends.at("takes_memory");
  EXPECT_EQ(over.status, results::Status::kFailed);
  EXPECT_TRUE(Has(over.message, "ended at its memory limit of 500 MB after 0 of 3 cycles"))
      << over.message;
  EXPECT_GT(results::ResultFile(program.folder() / "b.h5").ReadReal("peak_rss", {{1}, 0}), 1e6);
}

}  // namespace
}  // namespace cdb::tests
