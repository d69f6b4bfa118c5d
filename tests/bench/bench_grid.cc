// How the compiler grows with the runs of a benchmark: a check, a check of which `skip` leaves
// half, a check whose lints read every axis, the plan as YAML, which goes nowhere, and what `cdb
// run` does until its first run starts: for the first of a thousand shards, and for all runs where
// half are done (up to 10^6, as each is written to a journal). fsync does nothing here.
//   bench_grid [MOST]      up to 10^MOST runs; default 7
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "compiler/compile.h"
#include "compiler/grid/part.h"
#include "compiler/yaml/short_plan.h"
#include "library/closed_forms/scene_fault.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/sweep/schedule/parts.h"
#include "tests/support/files.h"

extern "C" int fsync(int) { return 0; }
extern "C" int fdatasync(int) { return 0; }

namespace {

/// Three axes, 10^`digits` points together. Lints read `third` or do not.
std::string Scenario(int digits, const std::string& third, const std::string& more) {
  const int a = digits / 3, b = (digits - a) / 2, c = digits - a - b;
  const auto power = [](int n) { return static_cast<int>(std::pow(10, n) + 0.5); };
  return fmt::format(
      "benchmark grid {{ world.side 1000; cycles sweep(1 .. {})\n"
      "objects {{ size 5; quantity sweep(1 .. {}) }}\n{} sweep(1 .. {})\n{} }}\n",
      power(a), power(b), third, power(c), more);
}

cdb::compiler::Compilation Check(const std::string& text) {
  const auto read = [&](const std::string&, std::string&) { return std::optional(text); };
  cdb::compiler::CompileOptions options;
  options.lists_runs = false;
  options.find_fault = cdb::closed_forms::FindSceneFault;
  return cdb::compiler::Compile("grid.cdb", read, options);
}

/// What `cdb run` has of a long plan.
struct LongPlan {
  std::shared_ptr<const cdb::grid::Grid> grid;
  cdb::plan::Plan plan;

  explicit LongPlan(const std::string& text)
      : grid(std::make_shared<const cdb::grid::Grid>(Check(text).grids.at(0))), plan(grid->head) {
    auto whole = std::make_shared<cdb::plan::WholePlan>(cdb::grid::MakeWhole(grid));
    cdb::yaml::ShortPlan form;
    form.sha256 = whole->sha256;
    whole->short_text = cdb::yaml::ToYaml(form);
    plan.whole = std::move(whole);
  }
  cdb::plan::Plan ListPart(std::uint64_t index, std::uint64_t count) const {
    return cdb::grid::ListPart(*grid, plan.whole, {index, count});
  }
};

/// Asks for a stop when the first run should start.
class StoppingLauncher : public cdb::process::Launcher {
 public:
  explicit StoppingLauncher(cdb::process::StopFlag& stop) : stop_(stop) {}
  void Start(std::size_t, const cdb::plan::Run&, const std::string&) override { stop_.Request(15); }
  std::optional<cdb::process::Ending> Wait(double) override { return std::nullopt; }
  void StopAll() override {}

 private:
  cdb::process::StopFlag& stop_;
};

void StartShard(const std::string& text, const std::filesystem::path& folder,
                cdb::schedule::ShardChoice shard) {
  const LongPlan made(text);
  cdb::process::StopFlag stop;
  StoppingLauncher launcher(stop);
  cdb::schedule::ProgressListener silent;
  cdb::schedule::ExecuteOptions options;
  options.folder = folder;
  options.shard = shard;
  options.stop = &stop;
  cdb::schedule::ExecuteParts(
      made.plan,
      [&](std::uint64_t index, std::uint64_t count) { return made.ListPart(index, count); },
      options, launcher, silent);
}

/// A journal in which the first half of the parts have ended, with empty records of their runs.
void MakeHalfDone(const cdb::plan::Plan& plan, const std::filesystem::path& folder) {
  const std::uint64_t runs = plan.RunCount();
  const std::uint64_t parts =
      std::max<std::uint64_t>(1, (runs + cdb::schedule::kPartRuns - 1) / cdb::schedule::kPartRuns);
  auto journal = cdb::journal::Journal::OpenToWrite(folder, plan.Sha256());
  for (std::uint64_t part = 1; part <= parts / 2; ++part)
    journal.Ask(fmt::format("part {} of {}", part, parts),
                fmt::format("{} {} 0 0 0 0", plan.Sha256(), runs / parts));
  cdb::journal::Record record;
  record.about = std::make_shared<const cdb::journal::About>();
  for (std::uint64_t i = 0; i < parts / 2 * (runs / parts); ++i) {
    record.run_id = fmt::format("{:016x}", i);
    journal.Write(record);
  }
}

/// Processor time and peak memory of a process of its own.
struct Cost {
  double seconds = 0, mebibytes = 0;
};
Cost CostOf(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    work();
    _exit(0);
  }
  int status = 0;
  rusage used = {};
  wait4(child, &status, 0, &used);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return {seconds(used.ru_utime) + seconds(used.ru_stime),
          static_cast<double>(used.ru_maxrss) / 1024};
}

}  // namespace

int main(int argc, char** argv) {
  const int most = argc > 1 ? std::atoi(argv[1]) : 7;
  fmt::print(
      "  runs  check s  MiB   half by skip s  MiB   all axes s  MiB   plan s  runs/s  MiB   "
      "shard 1/1000 s  MiB   resume s  MiB\n");
  for (int digits = 3; digits <= most; ++digits) {
    const std::string plain = Scenario(digits, "seed", "");
    const Cost check = CostOf([&] { Check(plain); });
    const Cost half =
        CostOf([&] { Check(Scenario(digits, "seed", "skip when cycles > quantity")); });
    const Cost all = CostOf([&] { Check(Scenario(digits, "objects.mass", "")); });
    const Cost plan =
        CostOf([&] { cdb::grid::WriteYaml(Check(plain).grids.at(0), [](std::string_view) {}); });
    const cdb::tests::TemporaryFolder fresh, half_done;
    const Cost shard = CostOf([&] { StartShard(plain, fresh.path(), {1, 1000}); });
    Cost resume;
    if (digits <= 6) {
      const LongPlan made(plain);
      std::ofstream(half_done / "plan.yaml") << made.plan.whole->short_text;
      MakeHalfDone(made.plan, half_done.path());
      resume = CostOf([&] { StartShard(plain, half_done.path(), {}); });
    }
    fmt::print(
        "  10^{}  {:7.3f}  {:3.0f}   {:14.3f}  {:3.0f}   {:10.3f}  {:3.0f}   {:6.2f}  {:6.0f}  "
        "{:3.0f}   {:14.3f}  {:3.0f}   {}\n",
        digits, check.seconds, check.mebibytes, half.seconds, half.mebibytes, all.seconds,
        all.mebibytes, plan.seconds, std::pow(10, digits) / plan.seconds, plan.mebibytes,
        shard.seconds, shard.mebibytes,
        digits <= 6 ? fmt::format("{:8.3f}  {:3.0f}", resume.seconds, resume.mebibytes)
                    : "       -    -");
    std::fflush(stdout);
  }
  return 0;
}
