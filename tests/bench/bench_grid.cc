// How the compiler grows with the runs of a benchmark: a check, a check of which `skip` leaves
// half, a check whose lints read every axis, and the plan as YAML, which goes nowhere.
//   bench_grid [MOST]      up to 10^MOST runs; default 7
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>

#include "compiler/compile.h"
#include "library/closed_forms/scene_fault.h"

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
      "  runs  check s  MiB   half by skip s  MiB   all axes s  MiB   plan s  runs/s  MiB\n");
  for (int digits = 3; digits <= most; ++digits) {
    const std::string plain = Scenario(digits, "seed", "");
    const Cost check = CostOf([&] { Check(plain); });
    const Cost half =
        CostOf([&] { Check(Scenario(digits, "seed", "skip when cycles > quantity")); });
    const Cost all = CostOf([&] { Check(Scenario(digits, "objects.mass", "")); });
    const Cost plan =
        CostOf([&] { cdb::grid::WriteYaml(Check(plain).grids.at(0), [](std::string_view) {}); });
    fmt::print(
        "  10^{}  {:7.3f}  {:3.0f}   {:14.3f}  {:3.0f}   {:10.3f}  {:3.0f}   {:6.2f}  {:6.0f}  "
        "{:3.0f}\n",
        digits, check.seconds, check.mebibytes, half.seconds, half.mebibytes, all.seconds,
        all.mebibytes, plan.seconds, std::pow(10, digits) / plan.seconds, plan.mebibytes);
    std::fflush(stdout);
  }
  return 0;
}
