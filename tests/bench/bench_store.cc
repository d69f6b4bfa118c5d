// What the store costs: a run beside its fsync, a merge of many, reading a result back.
//   bench_store [RUNS [CYCLES]]
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <string_view>
#include <vector>

#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"

namespace {

/// Wall and processor time since it was made; a busy machine shows in the first, fsync too.
class Stopwatch {
 public:
  void Print(std::string_view what, double n) const {
    const std::chrono::duration<double, std::milli> wall = Clock::now() - begin_;
    const double cpu = 1000.0 * static_cast<double>(std::clock() - cpu_) / CLOCKS_PER_SEC;
    fmt::print("{:<28} {:9.3f} ms  {:9.3f} ms of processor\n", what, wall.count() / n, cpu / n);
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point begin_ = Clock::now();
  std::clock_t cpu_ = std::clock();
};

}  // namespace

int main(int argc, char** argv) {
  using namespace cdb;
  const int runs = argc > 1 ? std::atoi(argv[1]) : 1000;
  const int cycles = argc > 2 ? std::atoi(argv[2]) : 1000;
  std::vector<double> quantities;
  for (int i = 1; i <= runs / 10; ++i) quantities.push_back(i * 10);
  const cdb::plan::Plan plan = tests::MakePlan(
      {tests::NumberAxis("quantity", quantities), tests::TextAxis("detector", {"simple", "dbvt"})},
      5, {.cycles = static_cast<std::uint64_t>(cycles)});
  const results::Provenance provenance = tests::TestProvenance();
  const tests::TemporaryFolder folder;
  const auto n = static_cast<double>(plan.runs.size());
  const tests::FakeResult fake(plan.runs.front());
  {
    journal::RunWriter writer(plan, provenance);
    auto journal = journal::Journal::OpenToWrite(folder.path(), plan.Sha256());
    const Stopwatch watch;
    for (const auto& run : plan.runs) writer.Write(run, fake.result, journal);
    watch.Print("write a run, with fsync", n);
  }
  {
    auto journal = journal::Journal::OpenToRead(folder / "runs.journal");
    const Stopwatch watch;
    for (const auto& run : plan.runs) journal::InfoOf(journal.Read(run.id).value());
    watch.Print("look at a run", n);
  }
  {
    const Stopwatch watch;
    journal::Merge(plan, provenance, folder.path(), folder / "out.h5");
    watch.Print(fmt::format("merge {} runs", plan.runs.size()), 1);
  }
  const Stopwatch watch;
  const results::ResultFile result(folder / "out.h5");
  double sum_ns = 0;
  for (const auto& run : plan.runs)
    for (const double ns : result.ReadDuration(protocol::Phase::kStep, {run.at, run.rep}))
      sum_ns += ns;
  watch.Print("read the step times of a run", n);
  fmt::print("{} cycles a run, {} ns in all\n", cycles, sum_ns);
}
