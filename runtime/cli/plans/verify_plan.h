// What `cdb verify` runs in place of a benchmark's plan.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::plans {

struct VerifyOptions {
  std::vector<std::string> detectors;           ///< with a broad phase; empty: the plan's own
  std::optional<std::uint64_t> cycles;          ///< nullopt: the plan's own
  std::vector<schema::PluginDetector> plugins;  ///< that `detectors` may name

  /// The word `all` alone: every detector that is built and holds the scene.
  bool WantsAll() const { return detectors == std::vector<std::string>{"all"}; }
};

struct VerifyPlan {
  plan::Plan plan;
  std::vector<std::string> left_out;  ///< detectors and points, and why: a line each
};

/// Every point of the plan once, with `record pairs` alone, pairs in sorted order and no errors.
/// Where detectors are given, they are the axis `detector`, in place of one that the plan has.
/// Throws CommandError where nothing is left to run.
VerifyPlan MakeVerifyPlan(const plan::Plan& plan, const VerifyOptions& options);

}  // namespace cdb::plans
