// The plan that `cdb verify` executes in place of that of a benchmark.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::plans {

struct VerifyOptions {
  std::vector<std::string> detectors;           ///< with a broad phase; empty: those of the plan
  std::optional<std::uint64_t> cycles;          ///< nullopt: as in the plan
  std::vector<schema::PluginDetector> plugins;  ///< may be named in `detectors`

  /// The word `all` alone: every detector that is built and can handle the scene.
  bool WantsAll() const { return detectors == std::vector<std::string>{"all"}; }
};

struct VerifyPlan {
  plan::Plan plan;
  std::vector<std::string> left_out;  ///< detectors and points, with the reason: a line each
  /// By the id of each run: the narrow phase that makes its contacts.
  std::map<std::string, std::string> narrow_phases;
};

/// Every point of the plan once, recording `pairs` alone, with pairs in sorted order and no errors.
/// If detectors are given, they form the axis `detector`, in place of the plan's. Throws
/// CommandError if nothing is left to run.
VerifyPlan MakeVerifyPlan(const plan::Plan& plan, const VerifyOptions& options);

}  // namespace cdb::plans
