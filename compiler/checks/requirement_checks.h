// The requirements of a benchmark: `require p99(step) < 4 ms`. Each becomes a figure, a comparison
// and a limit, or an error that names the figures there are.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "compiler/configure/configuration.h"
#include "compiler/plan/plan.h"
#include "compiler/plan/requirement.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

struct WrittenRequirement {
  plan::Requirement what;
  text::Span span, figure;  ///< of the whole comparison, and of its figure
};

/// Those of one choice of cases, in the order of writing; `and` joins two. Nullopt after a
/// diagnostic. Warns of times that so few `repeats` cannot judge.
std::optional<std::vector<WrittenRequirement>> ReadRequirements(
    configure::Configuration& configuration, std::uint64_t repeats);

/// The condition of a `find( )`, which is one comparison. Nullopt after a diagnostic.
std::optional<WrittenRequirement> ReadUntil(configure::Configuration& configuration,
                                            const dsl::Condition& condition,
                                            const scenario::Scope& scope, std::uint64_t repeats);

struct WrittenRace {
  plan::Race what;
  text::Span span, figure;  ///< of the call, and of its figure
};

/// What a `race( )` is by: `mean(step)` if it does not say. Nullopt after a diagnostic.
std::optional<WrittenRace> ReadRace(configure::Configuration& configuration, const dsl::Expr& call,
                                    const scenario::Scope& scope);

/// True if a run of the scene has the figure.
bool HasFigure(const plan::Scene& scene, const plan::Figure& figure);
/// Reports that no run of the benchmark has the figure, and how to record it.
void ReportNotRecorded(const WrittenRequirement& requirement, std::string_view benchmark,
                       dsl::Diagnostics& diagnostics);

}  // namespace cdb::checks
