// The command line of the benchmarks that take their scenes from .cdb files, and those scenes.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "compiler/compile.h"

namespace cdb::bench {

/// `[-r ROUNDS] [-c CYCLES] [FILE.cdb ...]`.
struct ScenarioRuns {
  std::uint64_t rounds, cycles;
  std::vector<std::string> files;

  /// `standard`: what holds where the command line says nothing else.
  ScenarioRuns(int argc, char** argv, ScenarioRuns standard) : ScenarioRuns(std::move(standard)) {
    std::vector<std::string> given;
    for (int i = 1; i < argc; ++i) {
      const std::string argument = argv[i];
      if ((argument == "-r" || argument == "-c") && i + 1 < argc) {
        (argument == "-r" ? rounds : cycles) = std::strtoull(argv[++i], nullptr, 10);
      } else {
        given.push_back(argument);
      }
    }
    if (!given.empty()) files = given;
  }
  ScenarioRuns(std::uint64_t r, std::uint64_t c, std::string file)
      : rounds(r), cycles(c), files{std::move(file)} {}

  /// Calls `run(benchmark, scene)` with the last run of each benchmark. False where a file has
  /// errors.
  template <typename Run>
  bool ForEach(Run run) const {
    for (const std::string& file : files) {
      const auto result = compiler::Compile(file, compiler::ReadFromDisk, {});
      if (result.diagnostics.has_errors()) {
        fmt::print(stderr, "{}: has errors; see cdb check\n", file);
        return false;
      }
      for (const plan::Plan& plan : result.plans) run(plan.benchmark, plan.runs.back().scene);
    }
    return true;
  }
};

}  // namespace cdb::bench
