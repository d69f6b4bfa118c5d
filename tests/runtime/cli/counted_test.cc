// Runs whose clock is the count of their instructions (`clock instructions`), and runs that count
// events of the processor (`record counters`).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "runtime/protocol/machine/event_counters.h"
#include "runtime/protocol/recording.h"
#include "runtime/results/store.h"
#include "runtime/sweep/process/program.h"
#include "tests/support/program.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

TEST(Counted, HasCountsInPlaceOfTimes) {
  if (kAnySanitizer) GTEST_SKIP() << "Valgrind cannot run what a sanitizer watches";
  if (!process::FindProgram("valgrind")) GTEST_SKIP() << "there is no Valgrind";
  const Program program;
  program.Write("few.cdb",
                "benchmark few {\n  cycles 4\n  detector sweep(sap, dbvt)\n  clock instructions\n"
                "  objects { quantity 8; size 5 }\n}\n");
  for (const char* name : {"a.h5", "b.h5"}) {
    const Finished run = program.Run({"run", "few.cdb", "-o", name, "--jobs", "2"});
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.out.find("Left out: the numbers of instructions"), std::string::npos) << run.out;
    EXPECT_EQ(run.out.find("cdb report"), std::string::npos) << run.out;
  }
  const results::ResultFile file(program.folder() / "a.h5");
  for (const std::size_t detector : {0, 1})
    for (const double count : file.ReadDuration(protocol::Phase::kStep, {{detector}, 0})) {
      EXPECT_GT(count, 5'000);
      EXPECT_LT(count, 1'000'000) << "of 8 spheres";
      EXPECT_EQ(count, std::round(count));
    }
  const Finished compared = program.Run({"compare", "a.h5", "b.h5", "--fail-if", "unsure"});
  EXPECT_EQ(compared.status, 0) << compared.err << compared.out;
  EXPECT_NE(compared.out.find("Mean number of instructions of a cycle"), std::string::npos)
      << compared.out;
  EXPECT_EQ(compared.out.find("INSTRUCTIONS"), std::string::npos) << compared.out;
  const Finished shown = program.Run({"show", "a.h5", "--all"});
  EXPECT_EQ(shown.status, 0) << shown.err;
  EXPECT_NE(shown.err.find("Left out: the numbers of instructions"), std::string::npos)
      << shown.err;
  for (const char* unit : {" us", " ns", " ms"})
    EXPECT_EQ(shown.out.find(unit), std::string::npos) << shown.out;
  const Finished budget = program.Run({"show", "a.h5", "--budget", "4ms"});
  EXPECT_EQ(budget.status, 2);
  EXPECT_NE(budget.err.find("--budget is about times, and a.h5 has numbers of instructions"),
            std::string::npos)
      << budget.err;
  EXPECT_NE(program.Run({"report", "a.h5"}).err.find("not times"), std::string::npos);
  const Finished estimate = program.Run({"plan", "few.cdb", "--estimate"});
  EXPECT_EQ(estimate.status, 2);
  EXPECT_NE(estimate.err.find("--estimate: the runs of 'few' have `clock instructions`"),
            std::string::npos)
      << estimate.err;
}

TEST(Counted, RunsAreJudged) {
  if (kAnySanitizer) GTEST_SKIP() << "Valgrind cannot run what a sanitizer watches";
  if (!process::FindProgram("valgrind")) GTEST_SKIP() << "there is no Valgrind";
  const Program program;
  program.Write("gate.cdb",
                "benchmark gate {\n  cycles 3\n  record counts, timing, stability, poses\n"
                "  clock instructions\n  require max(pairs) < 0\n"
                "  objects { quantity 3; size 5 }\n}\n");
  const Finished run = program.Run({"run", "gate.cdb"});
  EXPECT_EQ(run.status, 5) << run.err;
  EXPECT_NE(run.out.find("max(pairs) < 0: not met"), std::string::npos) << run.out;
  const Finished shown = program.Run({"show", "gate.h5"});
  EXPECT_EQ(shown.status, 5) << shown.err;
  EXPECT_NE(shown.out.find("max(pairs) < 0: not met"), std::string::npos) << shown.out;
  ASSERT_EQ(program.Run({"view", "gate.h5", "-o", "counted.html"}).status, 0);
  const std::string page = program.Read("counted.html");
  EXPECT_NE(page.find("\"unit\":\"instructions\""), std::string::npos);
  EXPECT_EQ(page.find("\"unit\":\"ns\""), std::string::npos);
  ASSERT_EQ(program.Run({"run", "gate.cdb", "--set", "clock=time", "-o", "timed.h5"}).status, 5);
  EXPECT_NE(program.Run({"view", "gate.h5", "timed.h5"}).err.find("cannot be side by side"),
            std::string::npos);
}

TEST(Counted, RunsFailIfACountIsLost) {
  if (kAnySanitizer) GTEST_SKIP() << "Valgrind cannot run what a sanitizer watches";
  if (!process::FindProgram("valgrind")) GTEST_SKIP() << "there is no Valgrind";
  const Program program;
  // Empties the log of Valgrind all the time, until the run ends.
  program.Write("valgrind",
                "#!/bin/sh\n"
                "fd=$(echo \"$*\" | sed 's/.*--log-fd=\\([0-9]*\\).*/\\1/')\n"
                "(while kill -0 $$; do : > /proc/self/fd/$fd; done) 2> /dev/null &\n"
                "PATH=${PATH#*:}\n"
                "exec valgrind \"$@\"\n");
  program.Write("few.cdb",
                "benchmark few { cycles 500; clock instructions; objects { size 5 } }\n");
  const Finished run = program.Shell("chmod +x valgrind; PATH=$PWD:$PATH $CDB run few.cdb");
  EXPECT_EQ(run.status, 3) << run.out << run.err;
  EXPECT_NE(run.err.find("failed: clock instructions: "), std::string::npos) << run.err;
  EXPECT_EQ(program.Run({"check", "few.h5"}).status, 0);
}

TEST(Counted, NamesWhatIsMissing) {
  const Program program;
  program.Write("few.cdb", "benchmark few { cycles 2; clock instructions; objects { size 5 } }\n");
  const Finished run = program.Shell("PATH=/nowhere $CDB run few.cdb");
  EXPECT_EQ(run.status, 2) << run.out;
  EXPECT_NE(run.err.find("needs the program valgrind"), std::string::npos) << run.err;
  program.Write(
      "few.cdb",
      "benchmark few { cycles 2; clock sweep(time, instructions); objects { size 5 } }\n");
  const Finished swept = program.Run({"check", "few.cdb"});
  EXPECT_NE((swept.out + swept.err).find("'clock' cannot be swept"), std::string::npos);
  for (const char* judged : {"budget 4 ms", "require mean(step) < 1 s"}) {
    program.Write("few.cdb",
                  fmt::format("benchmark few {{ cycles 2; repeats 5; clock instructions\n"
                              "  {}; objects {{ size 5 }} }}\n",
                              judged));
    const Finished checked = program.Run({"check", "few.cdb"});
    EXPECT_EQ(checked.status, 0) << checked.err;
    EXPECT_NE((checked.out + checked.err).find("' is not checked: `clock instructions`"),
              std::string::npos)
        << checked.out << checked.err;
  }
}

TEST(Counters, AreRecordedAndShownOrNamedAsMissing) {
  const Program program;
  program.Write(
      "few.cdb",
      "benchmark few {\n  cycles 4\n  detector sweep(sap, dbvt)\n  record timing, counters\n"
      "  objects { quantity 8; size 5 }\n}\n");
  const Finished run = program.Run({"run", "few.cdb"});
  ASSERT_EQ(run.status, 0) << run.err;
  const results::ResultFile file(program.folder() / "few.h5");
  const machine::EventCounters here;
  const machine::Counts counted = here.Read();
  const Finished shown = program.Run({"show", "few.h5"});
  EXPECT_EQ(shown.status, 0) << shown.err;
  for (std::size_t i = 0; i < counted.size(); ++i) {
    const std::string name(schema::kCounters[i]);
    for (const double count :
         file.ReadCounter(static_cast<schema::Counter>(i), protocol::Phase::kStep, {{1}, 0}))
      EXPECT_TRUE(std::isnan(counted[i]) ? std::isnan(count) : count >= 0) << name << " " << count;
    EXPECT_NE(shown.out.find(name), std::string::npos) << shown.out;
    EXPECT_EQ(run.err.find(name) != std::string::npos, std::isnan(counted[i])) << run.err;
  }
  EXPECT_EQ(shown.out.find("Events of step in a cycle") != std::string::npos, !here.CountsNothing())
      << shown.out;
  EXPECT_EQ(shown.out.find("not counted by the machine") != std::string::npos,
            !here.missing().empty())
      << shown.out;
  EXPECT_EQ(program.Run({"check", "few.h5"}).status, 0);
  EXPECT_NE(program.Run({"show", "few.h5", "--json"}).out.find("\"page_faults\""),
            std::string::npos);
  ASSERT_EQ(program.Run({"run", "few.cdb", "--set", "record=timing", "-o", "plain.h5"}).status, 0);
  EXPECT_NE(program.Run({"compare", "plain.h5", "few.h5"}).out.find("records counters"),
            std::string::npos);
}

TEST(Counters, AreRefusedWhereTheyWouldCountSomethingElse) {
  const Program program;
  const auto fault = [&](const std::string& settings) {
    program.Write("no.cdb", "benchmark no {\n  cycles 4\n  record timing, counters\n" + settings +
                                "\n  objects { quantity 8; size 5 }\n}\n");
    const Finished check = program.Run({"check", "no.cdb"});
    EXPECT_EQ(check.status, 1) << settings;
    return check.err + check.out;
  };
  EXPECT_NE(fault("  detector grid\n  threads 2").find("counts the events of one thread"),
            std::string::npos);
  EXPECT_NE(fault("  clock instructions").find("whose events are not those of the engine"),
            std::string::npos);
  program.Write("many.cdb",
                "benchmark many { cycles 4; record counters; objects { quantity 8; size 5 } }");
  EXPECT_NE(program.Run({"run", "many.cdb", "--jobs", "2"}).err.find("records counters"),
            std::string::npos);
}

}  // namespace
}  // namespace cdb::tests
