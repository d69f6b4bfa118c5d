#include "compiler/lints/lints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dsl/text/check.h"

namespace cdb::lints {
namespace {

// clang-format off
constexpr LintInfo kLints[] = {
    {Lint::kTallStack, {"W0301", "tall-stack"},
     "n^2 g timestep^2 / (size iterations), n objects high", "0.025; a pyramid counts for 0.4 of its height",
     "the stack {} slide or fall", "timestep {} or less, or more solver.iterations",
     "timestep solver.iterations quantity location acceleration size"},
    {Lint::kMassRatio, {"W0302", "mass-ratio"},
     "the mass above over the mass that bears it, over iterations; times 0.6 n on a stack of n", "12",
     "what is light {} give way under what is heavy", "solver.iterations {} or more, or masses nearer to each other",
     "mass solver.iterations"},
    {Lint::kHeavyEnd, {"W0303", "heavy-end"},
     "end_mass / mass g timestep^2 / (size erp iterations) of a chain of joints", "0.1",
     "joints {} come apart", "timestep {} or less, or more solver.iterations",
     "links.end_mass timestep solver.iterations mass"},
    {Lint::kNarrowFoot, {"W0304", "narrow-foot"},
     "size of what stands over that of the one object it stands on", "30",
     "objects {} tip over", "a foot of {} m or more",
     "size location"},
    {Lint::kOverlap, {"W0305", "overlap"},
     "how far objects of a line begin in one another, over size", "0.3",
     "objects {} be pushed apart", "a gap of -{} m at most",
     "location size"},
    {Lint::kLongStep, {"W0306", "long-step"},
     "g timestep^2 / size", "0.04 on a plane, 0.3 on a box; for balls that lie there none and 5",
     "objects {} sink in, drift or fall through", "timestep {} or less",
     "timestep acceleration size"},
    {Lint::kThinWall, {"W0307", "thin-wall"},
     "v timestep / (size + thickness of a box wall or fixed object), without ccd", "1.5",
     "objects {} pass through a wall or a fixed object", "timestep {} or less, or ccd on",
     "linear_velocity timestep acceleration world.wall_shape size"},
    {Lint::kFastHit, {"W0308", "fast-hit"},
     "v timestep / size, without ccd", "2",
     "a hit {} spin objects faster than Bullet turns", "timestep {} or less, or ccd on",
     "linear_velocity timestep acceleration size"},
    {Lint::kSoftContact, {"W0309", "soft-contact"},
     "n m g / contact_stiffness, n objects high, m", "0.04",
     "soft contacts {} lose their balance", "contact_stiffness {} or more",
     "contact_stiffness mass acceleration"},
    {Lint::kStiffSpring, {"W0310", "stiff-spring"},
     "w timestep of the fastest swing of a group's springs", "2",
     "springs {} explode", "timestep {} or less, or a lower links.stiffness",
     "links.stiffness links.damping timestep mass"},
    {Lint::kThinShape, {"W0311", "thin-shape"},
     "longest side over shortest, of what meets more than planes", "30, and never certain",
     "contacts {} be too deep or too shallow", "an aspect of 1 : {} or less",
     "aspect size type"},
    {Lint::kFastSpin, {"W0312", "fast-spin"},
     "spin timestep, rad", "1.41",
     "objects {} turn by less than their spin", "timestep {} or less",
     "angular_velocity timestep"},
    {Lint::kSpinDrift, {"W0313", "spin-drift"},
     "cycles (spin timestep twist)^2, twist 0 about an axis of the body", "0.05 of all energy",
     "free spin {} lose energy", "timestep {} or less",
     "angular_velocity timestep cycles"},
    {Lint::kHugeBox, {"W0314", "huge-box"},
     "diagonal of an object's box and its way in a cycle, m", "1e6",
     "Bullet {} switch objects off", "size and v timestep of {} m or less together",
     "size linear_velocity timestep acceleration"},
    {Lint::kCoarsePlace, {"W0315", "coarse-place"},
     "step between neighbouring numbers at an object's place, over its size", "0.012, certain from 0.5",
     "contacts {} not be resolved", "places within {} m, or precision double",
     "location world.side precision size"},
    {Lint::kLostMotion, {"W0316", "lost-motion"},
     "step between neighbouring numbers over the way of a cycle; for speeds, over 5 g timestep", "0.4",
     "objects {} move at a wrong speed or stand still", "places within {} m, or precision double",
     "location world.side linear_velocity timestep precision"},
    {Lint::kLostFall, {"W0317", "lost-fall"},
     "step between neighbouring numbers over the larger of g timestep^2 and 0.01 of an object's size", "0.3",
     "the fall of the first cycles {} be lost in rounding", "places within {} m (a smaller world.side), or precision double",
     "world.side location quantity precision size acceleration timestep"},
    {Lint::kHeavyMass, {"W0318", "heavy-mass"},
     "mass, kg", "1.45e7 in single precision, 7e15 in double",
     "contacts {} be lost", "a mass of {} kg or less, or precision double",
     "mass precision"},
    {Lint::kEarlySleep, {"W0319", "early-sleep"},
     "0.8 m/s over speed or 1 rad/s over spin, of what flies for 2 s", "1",
     "objects {} fall asleep in flight", "sleeping off",
     "sleeping linear_velocity angular_velocity acceleration"},
    {Lint::kShortRun, {"W0320", "short-run"},
     "sqrt(n size / g) over the time of the run, and times n / iterations if that is more than 1", "35",
     "objects {} not have come to rest when the run ends", "cycles {} or more",
     "cycles timestep size acceleration"},
};
// clang-format on

/// s; runs with smaller time steps take too long to be useful.
constexpr double kLeastTimestep = 1e-5;

/// A time step as a fraction of a second, a count as a whole number.
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
  const std::string limit =
      number.Severity() < 1
          ? fmt::format("near the limit of {:.3g}: it happens at times from {:.2g} on",
                        number.threshold, number.threshold * LintNumber::kDoubtful)
          : fmt::format("and the limit is {:.3g}", number.threshold);
  return fmt::format("{}: {} is {:.3g}, {}",
                     fmt::format(fmt::runtime(info.predicts), number.IsBad() ? "will" : "may"),
                     info.number, number.value, limit);
}

std::string LintRemedy(const LintNumber& number) {
  const std::string_view about = InfoOf(number.lint).about;
  if (InfoOf(number.lint).remedy.starts_with("timestep") && number.remedy < kLeastTimestep)
    return fmt::format("no time step of use is small enough; change {}",
                       about.substr(0, about.find(' ')));
  return fmt::format(fmt::runtime(InfoOf(number.lint).remedy),
                     RemedyNumber(number.lint, number.remedy));
}

}  // namespace cdb::lints
