// The programs of workers, the end of what they print, and the processors that they get.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "runtime/sweep/process/launcher.h"
#include "runtime/sweep/process/process.h"
#include "runtime/sweep/process/worker.h"
#include "tests/runtime/sweep/schedule/plans.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

TEST(ClaimedProcessors, AreNotSharedByRunnersSideBySide) {
  cpu_set_t allowed;
  sched_getaffinity(0, sizeof allowed, &allowed);
  const auto all = static_cast<std::size_t>(CPU_COUNT(&allowed));
  const std::string claim = fmt::format("cdb-claim-{}", getpid());
  std::set<int> taken;
  std::vector<process::ClaimedProcessors> runners;
  for (std::size_t i = 0; i < all; ++i) {
    runners.emplace_back(1, claim);
    taken.insert(runners.back().Of(0));
  }
  EXPECT_EQ(taken.size(), all);
  EXPECT_FALSE(taken.contains(-1));
  for (const int cpu : taken) EXPECT_TRUE(CPU_ISSET(cpu, &allowed));
  EXPECT_EQ(process::ClaimedProcessors(1, claim).Of(0), -1) << "none is left";
  const int freed = runners.back().Of(0);
  runners.pop_back();
  EXPECT_EQ(process::ClaimedProcessors(all + 1, claim).Of(0), -1);
  EXPECT_EQ(process::ClaimedProcessors(1, claim).Of(0), freed);
}

TEST(FindWorkersTest, LooksBesideAndInLibexec) {
  TemporaryFolder root;
  const fs::path bin = root.path() / "bin";
  const fs::path libexec = root.path() / "libexec" / "cdb";
  fs::create_directories(bin);
  fs::create_directories(libexec);
  const auto plan = MakePlan();
  try {
    process::FindWorkers(plan, bin);
    ADD_FAILURE();
  } catch (const process::ScheduleError& error) {
    for (const std::string& part : {(bin / "cdb-worker-f32").string(),
                                    (libexec / "cdb-worker-f32").string(), std::string("Build")})
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
  const auto install = [](const fs::path& file) {
    WriteFile(file, "#!/bin/true\n");
    fs::permissions(file, fs::perms::owner_all);
  };
  install(libexec / "cdb-worker-f32");
  EXPECT_EQ(process::FindWorkers(plan, bin).single, libexec / "cdb-worker-f32");
  EXPECT_TRUE(process::FindWorkers(plan, bin).double_.empty()) << "not needed";
  WriteFile(bin / "cdb-worker-f32", "no program");
  EXPECT_EQ(process::FindWorkers(plan, bin).single, libexec / "cdb-worker-f32")
      << "must be a program";
  install(bin / "cdb-worker-f32");
  EXPECT_EQ(process::FindWorkers(plan, bin).single, bin / "cdb-worker-f32");

  PlanShape shape;
  shape.precision = "double";
  EXPECT_THROW(process::FindWorkers(MakePlan(shape), bin), process::ScheduleError);
  install(bin / "cdb-worker-f64");
  EXPECT_EQ(process::FindWorkers(MakePlan(shape), bin).double_, bin / "cdb-worker-f64");
  EXPECT_TRUE(process::FindWorkers(MakePlan(shape), bin).single.empty());
}

TEST(TextTailTest, KeepsTheEnd) {
  process::TextTail tail;
  EXPECT_EQ(tail.LastLines(), "");
  tail.Append("\n\n");
  EXPECT_EQ(tail.LastLines(), "");
  tail.Append("a\nb\nc\nd\ne\nf\ng\n\n");
  EXPECT_EQ(tail.LastLines(), "c\nd\ne\nf\ng");
  process::TextTail one;
  one.Append("only");
  EXPECT_EQ(one.LastLines(), "only");
  // One long line of two-byte characters, cut in the middle of a character.
  for (int i = 0; i < 1000; ++i) one.Append("ééééééééééééé");
  one.Append("!");
  const std::string text = one.LastLines();
  EXPECT_TRUE(text.starts_with("...é")) << text.substr(0, 20);
  EXPECT_TRUE(text.ends_with("é!"));
  EXPECT_EQ(text.find('?'), std::string::npos);
}

TEST(TextTailTest, SaysInQuestionMarksWhatIsNoText) {
  const std::pair<std::string_view, const char*> cases[] = {
      {"tab\there", "tab here"},
      {"\x7f", "?"},
      {"\xc3", "?"},
      {"\xe2\x82", "??"},
      {"\xe2\x82\xac", "€"},
      {"\xed\xa0\x80", "???"},
      {"\xf4\x90\x80\x80", "????"},
      {"\xf0\x9f\x90\x87", "\xf0\x9f\x90\x87"},
      {"\xc2\x85", "??"},
      {"\xf0\x80\x80\x80", "????"}};
  for (const auto& [bytes, text] : cases) {
    process::TextTail tail;
    tail.Append(bytes);
    EXPECT_EQ(tail.LastLines(), text);
  }
}

}  // namespace
}  // namespace cdb::tests
