// A cluster of 64 nodes, simulated: the real driver, journal, resumption and merge, with workers
// that end at once and count as long as real runs took. Nodes die, some are slow, some runs fail.
// Time of the cluster is simulated; processor time, memory and bytes are measured. fsync does
// nothing here unless `-s`: a disk says more about itself than about cdb.
//   bench_cluster [-s] [-t TASKS] [-p PART] [LEAST MOST [FOLDER]]
// 10^LEAST to 10^MOST runs; default 3 to 5, below the current folder. -t: so many tasks. -p: only
// each PART-th task is executed, and the merge lacks the others.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "compiler/compile.h"
#include "compiler/grid/part.h"
#include "compiler/yaml/plan_yaml.h"
#include "compiler/yaml/short_plan.h"
#include "library/closed_forms/scene_fault.h"
#include "runtime/sweep/cluster/follow.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/sweep/schedule/order.h"
#include "runtime/sweep/schedule/parts.h"
#include "tests/runtime/results/store_fixture.h"

namespace {

bool g_syncs = false;
std::uint64_t g_tasks = 0;  ///< 0: as the cluster wants
std::uint64_t g_part = 1;

}  // namespace

extern "C" int fsync(int fd) { return g_syncs ? static_cast<int>(syscall(SYS_fsync, fd)) : 0; }
extern "C" int fdatasync(int fd) {
  return g_syncs ? static_cast<int>(syscall(SYS_fdatasync, fd)) : 0;
}

namespace {

namespace fs = std::filesystem;
using namespace cdb;

constexpr std::uint64_t kNodes = 64, kMostTasks = 256;
/// s of wall time: runs of 100 cycles with 500 to 2500 objects and sap, sap32, dbvt and auto, as
/// `cdb run` told them on a virtual machine with two cores.
constexpr double kRunSeconds[] = {0.056, 0.040, 0.056, 0.039, 0.095, 0.1, 0.068, 0.2, 0.1, 0.3,
                                  0.2,   0.2,   0.2,   0.4,   0.1,   0.2, 0.2,   0.5, 0.3, 0.3};
constexpr double kTask_s = 60;
constexpr double kFails = 0.01, kCrashes = 0.002;  // of all runs
constexpr double kNodeDies = 0.05;                 // of all tasks
constexpr std::uint64_t kSlowNodes = 3;
constexpr double kSlowness = 3;
constexpr double kDispatch_s = 1, kNodeIsMissed_s = 300;  // until Slurm takes a node for dead

std::string Scenario(int digits) {
  const auto power = [](int n) { return static_cast<int>(std::pow(10, n) + 0.5); };
  const int a = digits / 2, b = digits - a;
  return fmt::format(
      "benchmark many {{ world.side 1000; cycles 10; record timing; detector sweep(sap32, dbvt)\n"
      "objects {{ size 5; quantity sweep(1 .. {}) }}\nseed sweep(1 .. {}) }}\n",
      power(a) / 2, power(b));
}

/// As `cdb run` has it: a list of runs, or a grid.
struct Made {
  std::shared_ptr<const grid::Grid> grid;
  plan::Plan plan;

  explicit Made(int digits) {
    const std::string text = Scenario(digits);
    const auto read = [&](const std::string&, std::string&) { return std::optional(text); };
    compiler::CompileOptions options;
    options.lists_runs = false;
    options.find_fault = closed_forms::FindSceneFault;
    auto made = compiler::Compile("many.cdb", read, options);
    grid = std::make_shared<const grid::Grid>(std::move(made.grids.at(0)));
    if (grid->run_count() <= compiler::kMostListed) {
      plan = grid::ListRuns(*grid);
      return;
    }
    plan = grid->head;
    auto whole = std::make_shared<plan::WholePlan>(grid::MakeWhole(grid));
    yaml::ShortPlan form;
    form.benchmark = grid->head.benchmark;
    form.sha256 = whole->sha256;
    form.runs = whole->run_count;
    whole->short_text = yaml::ToYaml(form);
    plan.whole = std::move(whole);
  }
};

/// Runs end at once; the clock of the node goes on as if they had not.
class SimulatedNode : public process::Launcher {
 public:
  SimulatedNode(std::uint64_t task, int life, bool is_slow, process::StopFlag& stop)
      : random_(task * 100 + static_cast<std::uint64_t>(life)),
        slowness_(is_slow ? kSlowness : 1),
        stop_(stop) {
    if (life == 0 && std::bernoulli_distribution(kNodeDies)(random_))
      runs_left_ = std::uniform_int_distribution<std::uint64_t>(0, 20)(random_);
  }
  double seconds = 0;
  bool died = false;

  void Start(std::size_t, const plan::Run& run, const std::string&) override { run_ = &run; }
  std::optional<process::Ending> Wait(double) override {
    if (run_ == nullptr) return std::nullopt;
    if (runs_left_-- == 0) {
      died = true;
      stop_.Request(SIGKILL);
      return std::nullopt;
    }
    // What a run comes to depends on the run alone.
    std::mt19937_64 fate(std::hash<std::string>()(run_->id));
    const double draw = std::uniform_real_distribution(0.0, 1.0)(fate);
    seconds += slowness_ * kRunSeconds[fate() % std::size(kRunSeconds)];
    const results::Status status = draw < kCrashes            ? results::Status::kCrashed
                                   : draw < kCrashes + kFails ? results::Status::kFailed
                                                              : results::Status::kDone;
    fake_.emplace(*run_, status, status == results::Status::kDone ? 10 : 3);
    process::Ending ending;
    ending.result = fake_->result;
    ending.wall_s = 1;
    run_ = nullptr;
    return ending;
  }
  void StopAll() override { run_ = nullptr; }

 private:
  std::mt19937_64 random_;
  const double slowness_;
  process::StopFlag& stop_;
  std::uint64_t runs_left_ = static_cast<std::uint64_t>(-1);
  const plan::Run* run_ = nullptr;
  std::optional<tests::FakeResult> fake_;
};

schedule::Summary ExecuteTask(const Made& made, const fs::path& folder, std::uint64_t task,
                              std::uint64_t tasks, SimulatedNode& node, process::StopFlag& stop) {
  schedule::ExecuteOptions options;
  options.folder = folder;
  options.shard = {task, tasks};
  options.provenance = tests::TestProvenance();
  options.stop = &stop;
  schedule::ProgressListener silent;
  if (!made.plan.whole) return schedule::Execute(made.plan, options, node, silent);
  const auto list = [&](std::uint64_t index, std::uint64_t count) {
    return grid::ListPart(*made.grid, made.plan.whole, {index, count});
  };
  return schedule::ExecuteParts(made.plan, list, options, node, silent);
}

/// A minute of runs in each, or one for each node.
std::uint64_t CountTasks(const plan::Plan& plan) {
  if (g_tasks > 0) return g_tasks;
  double sum = 0;
  for (const double seconds : kRunSeconds) sum += seconds;
  const double all_s =
      sum / static_cast<double>(std::size(kRunSeconds)) * static_cast<double>(plan.RunCount());
  return std::clamp(static_cast<std::uint64_t>(all_s / kTask_s), kNodes, kMostTasks);
}

struct Sweep {
  double makespan_s = 0, busy_s = 0;
  std::uint64_t deaths = 0, tasks = 0;
};

/// All tasks, each on the node that is free first; those that lost theirs once more.
Sweep Execute(const Made& made, const fs::path& folder) {
  struct Waiting {
    std::uint64_t task;
    int life;
    double from_s;
  };
  std::vector<Waiting> queue;
  const std::uint64_t tasks = CountTasks(made.plan);
  for (std::uint64_t task = 1; task <= tasks; task += g_part) queue.push_back({task, 0, 0});
  std::vector<double> free_s(kNodes, 0);
  Sweep sweep;
  sweep.tasks = tasks;
  for (std::size_t i = 0; i < queue.size(); ++i) {
    const Waiting next = queue[i];
    const auto node = std::ranges::min_element(free_s);
    process::StopFlag stop;
    SimulatedNode simulated(next.task, next.life,
                            static_cast<std::uint64_t>(node - free_s.begin()) < kSlowNodes, stop);
    ExecuteTask(made, folder, next.task, tasks, simulated, stop);
    *node = std::max(*node, next.from_s) + kDispatch_s + simulated.seconds;
    sweep.busy_s += simulated.seconds;
    if (!simulated.died) continue;
    ++sweep.deaths;
    queue.push_back({next.task, next.life + 1, *node + kNodeIsMissed_s});
  }
  sweep.makespan_s = std::ranges::max(free_s);
  return sweep;
}

struct Cost {
  double seconds = 0, wall_s = 0, mebibytes = 0;
};

/// Of a process of its own; what `work` returns comes back.
template <typename Result>
Cost CostOf(const std::function<Result()>& work, Result& result) {
  int ends[2];
  if (pipe(ends) != 0) std::exit(2);
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) {
    try {
      const Result made = work();
      _exit(write(ends[1], &made, sizeof made) == sizeof made ? 0 : 1);
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}\n", error.what());
      _exit(2);
    }
  }
  close(ends[1]);
  const bool is_good = read(ends[0], &result, sizeof result) == sizeof result;
  close(ends[0]);
  int status = 0;
  rusage used = {};
  wait4(child, &status, 0, &used);
  if (!is_good || status != 0) std::exit(2);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  return {seconds(used.ru_utime) + seconds(used.ru_stime), wall.count(),
          static_cast<double>(used.ru_maxrss) / 1024};
}

double BytesIn(const fs::path& folder) {
  double bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder))
    bytes += static_cast<double>(entry.file_size());
  return bytes;
}

std::size_t CountFiles(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

void Measure(int digits, const fs::path& place) {
  const fs::path folder = place / fmt::format("many{}.runs", digits);
  const fs::path out = place / fmt::format("many{}.h5", digits);
  double written = 0;
  const auto print = [&](const char* what, const Cost& cost, const std::string& more) {
    fmt::print("  10^{}  {:28} {:9.2f} {:9.2f} {:10.1f} {:9.0f}  {}\n", digits, what, cost.wall_s,
               cost.seconds, 1e6 * cost.seconds / std::max(written, 1.0), cost.mebibytes, more);
    std::fflush(stdout);
  };
  Sweep sweep;
  Cost cost = CostOf<Sweep>([&] { return Execute(Made(digits), folder); }, sweep);
  const double bytes = BytesIn(folder);
  written = static_cast<double>(journal::CountRuns(folder));
  print("drivers and journal", cost,
        fmt::format("{} tasks; {} files, {:.1f} kB a run; {} nodes died; {:.0f} s on the cluster, "
                    "{:.0f} % busy",
                    sweep.tasks, CountFiles(folder), bytes / written / 1e3, sweep.deaths,
                    sweep.makespan_s,
                    100 * sweep.busy_s / sweep.makespan_s / static_cast<double>(kNodes)));
  std::size_t found = 0;
  cost = CostOf<std::size_t>(
      [&] {
        const Made made(digits);
        const std::uint64_t tasks = CountTasks(made.plan);
        process::StopFlag stop;
        SimulatedNode node(1, 1, false, stop);
        return ExecuteTask(made, folder, 1, tasks, node, stop).resumed;
      },
      found);
  print("start of one task, resumed", cost, fmt::format("{} runs found", found));
  cost = CostOf<std::size_t>(
      [&] {
        cluster::RunCount count(Made(digits).plan, folder);
        count.Update();
        return count.ended();
      },
      found);
  print("following: a look", cost, fmt::format("{} runs", found));
  int unused = 0;
  cost = CostOf<int>(
      [&] {
        const Made made(digits);
        journal::Merge(made.plan, tests::TestProvenance(), folder, out);
        return 0;
      },
      unused);
  print("merge", cost,
        fmt::format("{:.0f} runs, {:.2f} GB, to {:.2f} GB", written, bytes / 1e9,
                    static_cast<double>(fs::file_size(out)) / 1e9));
  cost = CostOf<std::size_t>(
      [&] {
        const results::ResultFile file(out);
        std::size_t done = 0;
        const Made made(digits);
        made.plan.ForEachRun([&](const std::string&, const auto& at, std::uint64_t rep) {
          done += file.ReadStatus({at, rep}) == results::Status::kDone;
        });
        return done;
      },
      found);
  print("every status of the result", cost, fmt::format("{} done", found));
  cost = CostOf<int>(
      [&] {
        schedule::RemoveSweep(folder, Made(digits).plan.Sha256());
        return 0;
      },
      unused);
  print("removing the journal", cost, "");
  fs::remove(out);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  std::size_t i = 0;
  for (; i < words.size() && words[i].starts_with('-'); ++i) {
    if (words[i] == "-s") {
      g_syncs = true;
    } else if (i + 1 < words.size()) {
      (words[i] == "-t" ? g_tasks : g_part) = std::strtoull(words[i + 1].c_str(), nullptr, 10);
      ++i;
    }
  }
  const int least = i < words.size() ? std::atoi(words[i].c_str()) : 3;
  const int most = i + 1 < words.size() ? std::atoi(words[i + 1].c_str()) : 5;
  const fs::path place = i + 2 < words.size() ? words[i + 2] : "bench_cluster";
  fs::create_directories(place);
  fmt::print("  runs  {:28} {:>9} {:>9} {:>10} {:>9}\n", "", "wall s", "cpu s", "us a run", "MiB");
  for (int digits = least; digits <= most; ++digits) Measure(digits, place);
  fs::remove(place);
  return 0;
}
