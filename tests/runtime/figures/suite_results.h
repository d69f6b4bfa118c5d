// Results of the standard suite with made-up times, errors and verdicts.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/figures/suite.h"
#include "runtime/protocol/machine/noise.h"
#include "runtime/results/store.h"

namespace cdb::tests {

/// The values that a run recorded.
struct SuiteRun {
  double ns = 1000;  ///< of every phase in every cycle
  double error = 0;  ///< of the kind by which the scene is judged
  results::Status status = results::Status::kDone;
  protocol::Verdict verdict = protocol::Verdict::kStable;
  machine::Noise noise = machine::Noise::kQuiet;
  std::string state = "0123456789abcdef", omitted = {};
  double peak_bytes = 5e6;
};
using SuiteChange = std::function<void(const plan::Run&, SuiteRun&)>;

/// A made-up scene: `detectors` in 4 cycles of 1/60 s, judged by the position error.
plan::Plan SuitePlan(const std::vector<std::string>& detectors, std::uint64_t repeats = 5);

inline const results::Provenance kSuiteProvenance = {
    {"build_type", "Release"}, {"cdb_version", "0.1.0"},
    {"commit", "c0ffee"},      {"bullet_version", "3.24"},
    {"compiler", "GNU"},       {"cpu", "a µ-processor"},
    {"host", "here"},          {"jobs", "1"}};

/// Writes results: those of a run without faults, modified by `change`. `error`: the name of the
/// error that is set.
void WriteSuiteResults(const plan::Plan& plan, const std::string& error, const SuiteChange& change,
                       const std::filesystem::path& out,
                       const results::Provenance& provenance = kSuiteProvenance);

}  // namespace cdb::tests
