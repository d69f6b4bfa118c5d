// Errors of the environment: full disks, missing folders, kill -9.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <random>
#include <thread>

#include "runtime/results/files/safe_file.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/store.h"
#include "runtime/results/trace_file.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using plan::Plan;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Runs `body`, which returns the empty text on success, in a child process.
std::string InChild(const std::function<std::string()>& body) {
  int ends[2];
  if (pipe(ends) != 0) return "no pipe";
  const pid_t child = fork();
  if (child == 0) {
    std::string text;
    try {
      text = body();
    } catch (const std::exception& error) {
      text = std::string("unexpected: ") + error.what();
    }
    text += '.';  // distinguishes it from a child that died
    const bool sent = write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size());
    _exit(sent ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof(buffer))) > 0;)
    text.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || text.empty())
    return "the process died, status " + std::to_string(status);
  text.pop_back();
  return text;
}

void LimitFiles(rlim_t bytes) {
  signal(SIGXFSZ, SIG_IGN);
  const rlimit limit = {bytes, RLIM_INFINITY};
  setrlimit(RLIMIT_FSIZE, &limit);
}

std::string ErrorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const files::StoreError& error) {
    return error.what();
  }
  return "";
}

Plan SmallPlan(std::size_t n = 6) {
  std::vector<double> quantities;
  for (std::size_t i = 0; i < n; ++i) quantities.push_back(static_cast<double>(i));
  return MakePlan({NumberAxis("quantity", quantities)}, 1, {.cycles = 200});
}

TEST(FullDisk, WhileARunIsWrittenLosesNothing) {
  const Plan plan = SmallPlan();
  const TemporaryFolder folder;
  WriteRun(plan, plan.runs[0], FakeResult(plan.runs[0]).result, {}, folder.path());
  const auto before = RunsIn(folder.path());
  const std::size_t bytes = ReadFile(folder / "runs.journal").size();
  for (const std::size_t limit : {std::size_t{0}, std::size_t{1}, std::size_t{4096}, bytes}) {
    SCOPED_TRACE(limit);
    EXPECT_EQ(InChild([&]() -> std::string {
                auto journal = journal::Journal::OpenToWrite(folder.path(), plan.Sha256());
                const results::Provenance none;
                journal::RunWriter writer(plan, none);
                LimitFiles(limit);
                const FakeResult one(plan.runs[1]);
                std::string error;
                // The log has room for a few runs.
                for (int i = 0; i < 100 && error.empty(); ++i)
                  error = ErrorOf([&] { writer.Write(plan.runs[1], one.result, journal); });
                if (error.find("File too large") == std::string::npos) return "said " + error;
                if (error.find("runs.journal") == std::string::npos) return "no file in " + error;
                if (error.find("make room") == std::string::npos) return "no remedy in " + error;
                // The driver continues when there is space again.
                LimitFiles(RLIM_INFINITY);
                writer.Write(plan.runs[1], one.result, journal);
                if (!journal.Read(plan.runs[1].id)) return "is not there";
                journal.Forget(plan.runs[1].id);
                return "";
              }),
              "");
    EXPECT_EQ(RunsIn(folder.path()), before);
  }
}

TEST(FullDisk, WhileMergingLosesNothing) {
  const Plan plan = SmallPlan();
  const TemporaryFolder folder, target;
  for (std::size_t i = 0; i < 3; ++i)
    WriteRun(plan, plan.runs[i], FakeResult(plan.runs[i]).result, {}, folder.path());
  const std::filesystem::path out = target / "out.h5";
  journal::Merge(plan, {}, folder.path(), out);
  const std::string before = ReadFile(out);
  const auto runs = RunsIn(folder.path());
  for (std::size_t limit = 0; limit < before.size(); limit += 1 + before.size() / Cases(40)) {
    SCOPED_TRACE(limit);
    EXPECT_EQ(InChild([&]() -> std::string {
                LimitFiles(limit);
                const std::string error =
                    ErrorOf([&] { journal::Merge(plan, {}, folder.path(), out); });
                if (error.find(out.string()) == std::string::npos) return "no file in " + error;
                if (error.find("File too large") == std::string::npos) return "said " + error;
                if (FilesIn(target.path()).size() != 1) return "left a temporary";
                if (ReadFile(out) != before) return "changed the result";
                LimitFiles(RLIM_INFINITY);
                const TemporaryFolder again;
                WriteRun(plan, plan.runs[4], FakeResult(plan.runs[4]).result, {}, again.path());
                journal::Merge(plan, {}, again.path(), again / "out.h5");
                const results::ResultFile file(again / "out.h5");
                return file.ReadStatus({{4}, 0}) == results::Status::kDone ? "" : "cannot go on";
              }),
              "");
  }
  EXPECT_EQ(RunsIn(folder.path()), runs);
}

TEST(FullDisk, LeavesTheProcessAbleToEndInPeace) {
  const Plan plan = SmallPlan();
  const TemporaryFolder folder, target;
  WriteRun(plan, plan.runs[0], FakeResult(plan.runs[0]).result, {}, folder.path());
  // HDF5 cleans up when a process ends, and must not use the file that it could not write.
  const auto fail_and_exit = [&] {
    LimitFiles(20000);
    const std::string error =
        ErrorOf([&] { journal::Merge(plan, {}, folder.path(), target / "out.h5"); });
    std::size_t open_files = 0;
    for ([[maybe_unused]] const auto& entry :
         std::filesystem::directory_iterator("/proc/self/fd")) {
      std::error_code ignored;
      const auto file = std::filesystem::read_symlink(entry.path(), ignored).string();
      if (file.find("out.h5") != std::string::npos) ++open_files;
    }
    if (error.empty() || open_files > 0) std::fputs("left a file open", stderr);
    std::exit(error.empty() ? 1 : 0);
  };
  EXPECT_EXIT(fail_and_exit(), testing::ExitedWithCode(0), "^$");
}

/// A small file system, in a mount namespace that ends with the process.
bool MountSmallDisk(const std::filesystem::path& where, const char* size) {
  return unshare(CLONE_NEWNS) == 0 &&
         mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
         mount("tmpfs", where.c_str(), "tmpfs", 0, size) == 0;
}

TEST(FullDisk, OfARealFileSystemIsNamed) {
  const Plan plan = SmallPlan(200);
  const TemporaryFolder folder;
  const std::string outcome = InChild([&]() -> std::string {
    if (!MountSmallDisk(folder.path(), "size=256k")) return "SKIP";
    std::size_t written = 0;
    std::string error;
    for (const plan::Run& run : plan.runs) {
      const FakeResult fake(run);
      error = ErrorOf([&] { WriteRun(plan, run, fake.result, {}, folder.path()); });
      if (!error.empty()) break;
      ++written;
    }
    if (error.find("No space left on device") == std::string::npos) return "said " + error;
    journal::Journals journals({folder.path()});
    if (journals.size() != written || written == 0) return "lost a run";
    for (std::size_t i = 0; i < written; ++i)
      if (!journals.Find(plan.runs[i].id)) return "lost a run";
    error = ErrorOf([&] { journal::Merge(plan, {}, folder.path(), folder / "out.h5"); });
    if (error.find("No space left on device") == std::string::npos) return "said " + error;
    for (const std::string& name : FilesIn(folder.path()))
      if (name.ends_with(".tmp")) return "left a temporary";
    return "";
  });
  if (outcome == "SKIP") GTEST_SKIP() << "may not mount here";
  EXPECT_EQ(outcome, "");
}

TEST(ReadOnlyDisk, IsNamed) {
  const Plan plan = SmallPlan();
  const TemporaryFolder folder, empty;
  const std::string outcome = InChild([&]() -> std::string {
    if (!MountSmallDisk(folder.path(), "size=1m") ||
        mount("none", folder.path().c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) != 0)
      return "SKIP";
    const FakeResult fake(plan.runs[0]);
    const std::string run =
        ErrorOf([&] { WriteRun(plan, plan.runs[0], fake.result, {}, folder.path()); });
    if (run.find("Read-only file system") == std::string::npos) return "said " + run;
    const std::string out =
        ErrorOf([&] { journal::Merge(plan, {}, empty.path(), folder / "out.h5"); });
    return out.find("Read-only file system") == std::string::npos ? "said " + out : "";
  });
  if (outcome == "SKIP") GTEST_SKIP() << "may not mount here";
  EXPECT_EQ(outcome, "");
}

TEST(Folders, ThatCannotBeUsedAreNamed) {
  const Plan plan = SmallPlan();
  const FakeResult fake(plan.runs[0]);
  const TemporaryFolder folder;
  WriteFile(folder / "file", "x");
  std::filesystem::create_directory(folder / "out.h5");
  std::filesystem::create_directory(folder / "runs.journal");
  const auto write = [&](const std::filesystem::path& where) {
    return ErrorOf([&] { WriteRun(plan, plan.runs[0], fake.result, {}, where); });
  };
  EXPECT_THAT(write(folder / "none"), HasSubstr("No such file or directory"));
  EXPECT_THAT(write(folder / "file"), HasSubstr("Not a directory"));
  EXPECT_THAT(write(folder.path()), HasSubstr("it is a folder, not a file"));
  const auto merge = [&](const std::filesystem::path& from, const std::filesystem::path& to) {
    return ErrorOf([&] { journal::Merge(plan, {}, from, to); });
  };
  const TemporaryFolder empty;
  EXPECT_THAT(merge(folder / "none", folder / "a.h5"), HasSubstr("No such file or directory"));
  EXPECT_THAT(merge(empty.path(), folder / "none/a.h5"), HasSubstr("No such file or directory"));
  EXPECT_THAT(merge(empty.path(), folder / "file/a.h5"), HasSubstr("Not a directory"));
  EXPECT_THAT(merge(empty.path(), folder / "out.h5"), HasSubstr("is a folder"));
  EXPECT_THAT(FilesIn(folder.path()), ElementsAre("file", "out.h5", "runs.journal"));
}

TEST(Errors, OfHdf5ArePrintedNowhere) {
  const TemporaryFolder folder;
  WriteFile(folder / "text.h5", "hello");
  testing::internal::CaptureStderr();
  EXPECT_THROW(results::ResultFile(folder / "text.h5"), files::StoreError);
  std::thread([&] {
    EXPECT_THROW(results::ResultFile(folder / "text.h5"), files::StoreError);
  }).join();
  EXPECT_THAT(testing::internal::GetCapturedStderr(), IsEmpty());
}

/// Starts `body` in a process that writes a byte after each piece of work, and kills it during one
/// of the first pieces, however slow the machine is. Returns the number of bytes.
std::size_t KillDuring(std::mt19937& random, const std::function<void(int)>& body) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child == 0) {
    body(ends[1]);
    _exit(0);
  }
  close(ends[1]);
  std::size_t said = 0;
  char c = 0;
  for (std::size_t least = random() % 4; said < least && read(ends[0], &c, 1) == 1;) ++said;
  usleep(static_cast<useconds_t>(random() % 20000));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  while (read(ends[0], &c, 1) == 1) ++said;
  close(ends[0]);
  return said;
}

TEST(Kill, WhileRunsAreWrittenLosesNoFinishedRun) {
  const Plan plan = SmallPlan(60);
  const TemporaryFolder folder;
  std::mt19937 random(7);
  std::size_t finished = 0;
  for (int trial = 0; trial < Cases(60); ++trial) {
    finished = std::max(finished, KillDuring(random, [&](int say) {
                          const results::Provenance none;
                          journal::RunWriter writer(plan, none);
                          auto journal =
                              journal::Journal::OpenToWrite(folder.path(), plan.Sha256());
                          for (const plan::Run& run : plan.runs) {
                            writer.Write(run, FakeResult(run).result, journal);
                            if (write(say, "x", 1) != 1) _exit(1);
                          }
                        }));
    journal::Journals journals({folder.path()});
    EXPECT_GE(journals.size(), finished);
    for (std::size_t i = 0; i < finished; ++i) EXPECT_TRUE(journals.Find(plan.runs[i].id));
  }
  EXPECT_GT(finished, 0u);
}

TEST(Kill, WhileMergingLeavesTheResultWhole) {
  const Plan plan = SmallPlan(30);
  const TemporaryFolder folder, target;
  for (std::size_t i = 0; i < plan.runs.size(); ++i)
    WriteRun(plan, plan.runs[i], FakeResult(plan.runs[i]).result, {}, folder.path());
  const auto runs = RunsIn(folder.path());
  journal::Merge(plan, {}, folder.path(), target / "out.h5");
  std::mt19937 random(11);
  for (int trial = 0; trial < Cases(60); ++trial) {
    KillDuring(random, [&](int say) {
      do journal::Merge(plan, {}, folder.path(), target / "out.h5");
      while (write(say, "x", 1) == 1);
    });
    const results::ResultFile file(target / "out.h5");
    for (const plan::Run& run : plan.runs)
      ASSERT_EQ(file.ReadDuration(protocol::Phase::kBroad, {run.at, 0}).back(),
                ValueAt(run, *protocol::FindSeries("duration"), 199));
    files::RemoveStaleTemporaries(target.path());
    ASSERT_THAT(FilesIn(target.path()), ElementsAre("out.h5"));
    ASSERT_EQ(RunsIn(folder.path()), runs);
  }
}

/// The next process of the same kind removes the files that killed ones left, also under another
/// name.
TEST(Kill, WhileMergingAndTracingLeavesNoTemporariesForEver) {
  const Plan plan = SmallPlan(3);
  const TemporaryFolder folder, target;
  for (const plan::Run& run : plan.runs)
    WriteRun(plan, run, FakeResult(run).result, {}, folder.path());
  protocol::TraceMemory trace = protocol::TraceMemory::Create({3, 4, false});
  const std::vector<double> boxes(3 * protocol::kBoxSize, 1);
  for (std::uint64_t cycle = 0; cycle < 4; ++cycle) trace.SetBoxes(cycle, boxes);
  const auto merge = [&](const char* name) {
    journal::Merge(plan, {}, folder.path(), target / name);
  };
  const auto write_trace = [&](const char* name) {
    results::WriteTrace(trace, {}, 0, {}, target / name);
  };
  std::mt19937 random(13);
  std::size_t left = 0;
  for (int trial = 0; trial < 10; ++trial) {
    KillDuring(random, [&](int say) {
      do merge("killed.h5");
      while (write(say, "x", 1) == 1);
    });
    KillDuring(random, [&](int say) {
      do write_trace("killed.trace.h5");
      while (write(say, "x", 1) == 1);
    });
    for (const std::string& name : FilesIn(target.path())) left += name.ends_with(".tmp");
    merge("out.h5");
    write_trace("t.trace.h5");
    for (const std::string& name : FilesIn(target.path()))
      EXPECT_FALSE(name.ends_with(".tmp")) << name;
  }
  EXPECT_GT(left, 0u) << "no kill has met a temporary";
}

}  // namespace
}  // namespace cdb::tests
