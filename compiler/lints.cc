#include "compiler/lints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dsl/check.h"

namespace cdb::compiler {
namespace {

constexpr dsl::DiagnosticKind Warning(std::string_view name) {
  return {name, dsl::Severity::kWarning};
}

// clang-format off
constexpr LintInfo kLints[] = {
    {Lint::kTallStack, Warning("tall-stack"),
     "n^2 g timestep^2 / (size iterations) of a stack of n", "0.015",
     "the stack {} slide or fall", "timestep {} or less, or more solver.iterations",
     "timestep solver.iterations quantity location acceleration size"},
    {Lint::kMassRatio, Warning("mass-ratio"),
     "mass of what lies above over mass of what bears it, over iterations", "10",
     "what is light {} give way under what is heavy", "solver.iterations {} or more, or masses nearer to each other",
     "mass solver.iterations"},
    {Lint::kLongStep, Warning("long-step"),
     "g timestep^2 / size", "0.03 on a plane, 0.3 on a box",
     "objects {} sink in, drift or fall through", "timestep {} or less",
     "timestep acceleration size"},
    {Lint::kThinWall, Warning("thin-wall"),
     "v timestep / (size + thickness of a box wall), without ccd", "0.5",
     "objects {} pass through a wall", "timestep {} or less, or ccd on",
     "linear_velocity timestep acceleration world.wall_shape size"},
    {Lint::kFastHit, Warning("fast-hit"),
     "v timestep / size, where there is something to hit", "1.5",
     "what objects hit {} spin them faster than Bullet turns", "timestep {} or less",
     "linear_velocity timestep acceleration size"},
    {Lint::kSoftContact, Warning("soft-contact"),
     "m g / contact_stiffness, m", "0.04",
     "soft contacts {} lose their balance", "contact_stiffness {} or more",
     "contact_stiffness mass acceleration"},
        {Lint::kStiffSpring, Warning("stiff-spring"),
     "w timestep of the fastest swing of a group's springs, dampers included", "2",
     "springs {} explode", "timestep {} or less, or a lower links.stiffness",
     "links.stiffness links.damping timestep mass"},
    {Lint::kThinShape, Warning("thin-shape"),
     "longest side over shortest, of objects that meet by GJK", "30",
     "depths of contacts {} be wrong", "an aspect of 1 : {0} or less, or cuboids",
     "aspect size type"},
    {Lint::kFastSpin, Warning("fast-spin"),
     "spin timestep, rad", "1.41",
     "Bullet {} turn objects by less than their spin", "timestep {} or less",
     "angular_velocity timestep"},
    {Lint::kSpinDrift, Warning("spin-drift"),
     "cycles (spin timestep)^2 of unequal moments of inertia", "0.15",
     "free spin {} lose its energy", "timestep {} or less",
     "angular_velocity timestep cycles"},
    {Lint::kHugeBox, Warning("huge-box"),
     "diagonal of an object's box, its way in a cycle included, m", "1e6",
     "Bullet {} switch objects off", "a size or a way in one cycle of {} m or less",
     "size linear_velocity timestep acceleration"},
    {Lint::kCoarsePlace, Warning("coarse-place"),
     "step between neighbouring numbers at an object's place, over its size", "1e-3",
     "contacts {} not be resolved", "places within {} m, or precision double",
     "location world.side precision size"},
    {Lint::kLostMotion, Warning("lost-motion"),
     "step between neighbouring numbers, over what a cycle adds to a place or a speed", "0.4",
     "objects {} move at a wrong speed or stand still", "places within {} m, or precision double",
     "location world.side linear_velocity timestep precision"},
    {Lint::kHeavyMass, Warning("heavy-mass"),
     "mass, kg", "1.45e7 in single precision, 7e15 in double",
     "contacts {} be lost", "a mass of {} kg or less, or precision double",
     "mass precision"},
    {Lint::kEarlySleep, Warning("early-sleep"),
     "0.8 m/s over the speed or 1 rad/s over the spin of what flies freely for 2 s", "1",
     "Bullet {} put objects to sleep in flight", "sleeping off",
     "sleeping linear_velocity angular_velocity acceleration"},
    {Lint::kShortRun, Warning("short-run"),
     "sqrt(n size / g) over the time of the run", "1",
     "objects {} not have come to rest when the run ends", "cycles {} or more",
     "cycles timestep size acceleration"},
};
// clang-format on

/// As people write it: a step is a fraction of a second.
std::string RemedyNumber(Lint lint, double value) {
  const LintInfo& info = InfoOf(lint);
  if (info.remedy.starts_with("timestep") && value < 1)
    return fmt::format("1/{:.0f}", std::ceil(1 / value * (1 - 1e-9)));
  if (info.remedy.starts_with("solver.iterations") || info.remedy.starts_with("cycles"))
    return fmt::format("{:.0f}", std::ceil(value * (1 - 1e-9)));
  return fmt::format("{:.2g}", value);
}

}  // namespace

std::span<const LintInfo> Lints() { return kLints; }

const LintInfo& InfoOf(Lint lint) {
  const LintInfo& info = kLints[static_cast<std::size_t>(lint)];
  CDB_CHECK(info.lint == lint);
  return info;
}

bool IsLint(const dsl::DiagnosticKind& kind) {
  return std::ranges::any_of(kLints, [&](const LintInfo& info) { return &info.kind == &kind; });
}

std::string LintMessage(const LintNumber& number) {
  const LintInfo& info = InfoOf(number.lint);
  return fmt::format("{}: {} is {:.3g}, and the limit is {:.3g}",
                     fmt::format(fmt::runtime(info.foretells), number.IsBad() ? "will" : "may"),
                     info.number, number.value, number.threshold);
}

std::string LintRemedy(const LintNumber& number) {
  return fmt::format(fmt::runtime(InfoOf(number.lint).remedy),
                     RemedyNumber(number.lint, number.remedy));
}

}  // namespace cdb::compiler
