// Results files for tests of comparisons: real plans with made-up times of known noise.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/protocol/verdict.h"
#include "runtime/results/store.h"

namespace cdb::tests {

inline constexpr std::uint64_t kComparedCycles = 6;

/// The values that a run recorded, without noise.
struct ComparedRun {
  double factor = 1;  ///< applied to all times
  std::string state = "0123456789abcdef";
  protocol::Verdict verdict = protocol::Verdict::kStable;
  results::Status status = results::Status::kDone;
  double error = 0.5, floor = 0;
  double peak_bytes = 5e6;
  std::int32_t missed = 0;
  std::string omitted = {};
};
using ComparedScene = std::function<void(const plan::Run&, ComparedRun&)>;

struct ComparedResult {
  plan::Plan plan;
  ComparedScene change = [](const plan::Run&, ComparedRun&) {};
  double noise = 0.005;  ///< between runs
  std::uint64_t seed = 1;
  results::Provenance provenance = {{"build_type", "Release"}, {"cpu", "a µ-processor"}};
  double started = 0;  ///< s
};

/// A plan of a benchmark with `more` settings; if `detectors` is empty, it sweeps only the
/// quantities.
plan::Plan ComparedPlan(std::uint64_t repeats,
                        const std::vector<std::string>& quantities = {"10", "20"},
                        const std::vector<std::string>& detectors = {"simple", "dbvt", "sap",
                                                                     "grid"},
                        const std::string& more = "", const std::string& record = "timing, pairs");

void WriteCompared(const ComparedResult& of, const std::filesystem::path& out);

/// A scene in which `detector` is slower by `factor`.
ComparedScene Slower(std::size_t detector, double factor);

}  // namespace cdb::tests
