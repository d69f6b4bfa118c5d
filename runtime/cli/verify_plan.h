// What `cdb verify` runs in place of a benchmark's plan.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan.h"

namespace cdb::runtime {

/// For VerifyOptions::detectors, alone: every one that is built and holds the scene.
inline constexpr std::string_view kEveryDetector = "all";

struct VerifyOptions {
  std::vector<std::string> detectors;   ///< with a broad phase; empty: the plan's own
  std::optional<std::uint64_t> cycles;  ///< nullopt: the plan's own
};

struct VerifyPlan {
  compiler::Plan plan;
  std::vector<std::string> left_out;  ///< what `all` does without, and why: a line each
};

/// Every point of the plan once, with `record pairs` alone, pairs in sorted order and no errors.
/// Where detectors are given, they are the axis `detector`, in place of one that the plan has.
/// Throws CommandError where nothing is left to run.
VerifyPlan MakeVerifyPlan(const compiler::Plan& plan, const VerifyOptions& options);

}  // namespace cdb::runtime
