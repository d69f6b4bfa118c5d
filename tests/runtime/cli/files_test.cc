// Valid paths name files; the program neither waits for other things nor overwrites them by
// mistake.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>

#include "runtime/results/store.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

const char kScenario[] = "benchmark s { cycles 2; objects.quantity sweep(2, 3) }";

/// Expects a non-zero exit status, a message with `part`, and no wait.
void ExpectRefused(const Program& program, const std::string& command, const std::string& part) {
  const Finished finished = program.Shell("exec timeout 20 \"$CDB\" " + command);
  EXPECT_TRUE(finished.status == 1 || finished.status == 2) << command << ": " << finished.status;
  EXPECT_NE(finished.err.find(part), std::string::npos) << command << ": " << finished.err;
}

TEST(Inputs, PipesAndDevicesAreRefusedAndNotWaitedFor) {
  const Program program;
  program.Write("s.cdb", kScenario);
  for (const char* name : {"p.cdb", "p.yaml", "p.h5", "p.obj", "p.csv", "p.so", "p.runs"})
    ASSERT_EQ(mkfifo((program.folder() / name).c_str(), 0600), 0);
  for (const char* command :
       {"check p.cdb", "plan p.yaml", "run p.cdb", "run p.yaml", "fmt p.cdb", "show p.h5",
        "report p.h5", "view p.h5", "compare p.h5 p.h5", "check s.cdb --plugin ./p.so"})
    ExpectRefused(program, command, "it is a pipe, not a file");
  ExpectRefused(program, "check /dev/zero", "it is a device, not a file");
  ExpectRefused(program, "merge -o m.h5 p.runs", "p.runs");
  const auto in_scenario = [&](const std::string& line, const std::string& part) {
    program.Write("t.cdb", "benchmark t { cycles 2; " + line + " }");
    ExpectRefused(program, "check t.cdb", part);
  };
  in_scenario("objects.type mesh(\"p.obj\")", "not a file");
  in_scenario("objects.location poses(\"p.csv\")", "it is a pipe, not a file");
  in_scenario("objects.location poses(\"p.h5\", cycle: 1)", "it is a pipe, not a file");
  in_scenario("trace \"p.h5\"", "no file");
  program.Write("u.cdb", std::string("use \"p.cdb\"\n") + kScenario);
  ExpectRefused(program, "check u.cdb", "it is a pipe, not a file");
}

TEST(Inputs, APipeInAFolderOfRunsIsNotWaitedFor) {
  const Program program;
  program.Write("s.cdb", kScenario);
  const auto run_parts = [&] {
    for (const char* part : {"1/2", "2/2"})
      EXPECT_EQ(program.Shell(std::string("exec timeout 20 \"$CDB\" run s.cdb -q --shard ") + part)
                    .status,
                0);
  };
  run_parts();
  const fs::path folder = program.folder() / "s.runs";
  const auto to_pipe = [](const fs::path& path) {
    fs::remove(path);
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  };
  to_pipe(folder / "runs.journal");
  for (const char* command : {"merge -o m.h5 s.runs", "run s.cdb"})
    ExpectRefused(program, command, "it is a pipe, not a file");
  fs::remove(folder / "runs.journal");
  run_parts();
  for (const char* name : {"plan.yaml", "plan.short.yaml"}) to_pipe(folder / name);
  ExpectRefused(program, "merge -o m.h5 s.runs", "it is a pipe, not a file");
  ExpectRefused(program, "run s.cdb", "it is a pipe, not a file");
}

TEST(Outputs, AResultsFileCalledLikeAFolderOfRunsIsRefused) {
  const Program program;
  program.Write("s.cdb", kScenario);
  ExpectRefused(program, "run s.cdb -o s.runs", "folders of unfinished sweeps");
  EXPECT_FALSE(program.Exists("s.runs"));
}

/// What the starter of a program leaves to it.
TEST(Inputs, IgnoredOrBlockedSignalsAndClosedDescriptorsDoNoHarm) {
  const Program program;
  program.Write("b.cdb", "benchmark b { cycles 3; world.side 100; objects { quantity 2 } }");
  for (const char* how : {"trap '' CHLD", "trap '' CHLD PIPE HUP INT TERM", "exec <&- 2>&-",
                          "umask 0", "umask 077"}) {
    const std::string line = std::string(how) + "; \"$CDB\" run -q --fresh b.cdb >/dev/null && " +
                             "\"$CDB\" check b.h5 >checked";
    EXPECT_EQ(program.Shell(line).status, 0) << how;
    EXPECT_NE(program.Read("checked").find("1 of 1 runs"), std::string::npos) << how;
  }
}

TEST(Outputs, ALinkIsWrittenThroughAndADeviceIsRefused) {
  const Program program;
  program.Write("s.cdb", kScenario);
  fs::create_directory(program.folder() / "disk");
  fs::create_symlink("disk/real.h5", program.folder() / "s.h5");
  EXPECT_EQ(program.Run({"run", "s.cdb", "-q"}).status, 0);
  EXPECT_TRUE(fs::is_symlink(program.folder() / "s.h5"));
  EXPECT_EQ(results::ResultFile(program.folder() / "disk" / "real.h5").benchmark(), "s");
  fs::create_symlink("/dev/full", program.folder() / "full");
  ASSERT_EQ(mkfifo((program.folder() / "p").c_str(), 0600), 0);
  for (const char* command : {"plan s.cdb -o full", "report s.h5 -o full", "view s.cdb -o full",
                              "merge -o full disk", "trace s.cdb -o full"})
    ExpectRefused(program, command,
                  std::string(command).starts_with("merge")   ? "plan.yaml"
                  : std::string(command).starts_with("trace") ? "full"
                                                              : "it is a device, not a file");
  ExpectRefused(program, "plan s.cdb -o p", "it is a pipe, not a file");
  EXPECT_TRUE(fs::is_character_file(program.folder() / "full"));
}

}  // namespace
}  // namespace cdb::tests
