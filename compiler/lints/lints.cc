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
     "mass above / (mass below iterations), times 0.6 n on a stack of n", "12",
     "light objects {} give way under heavy ones", "solver.iterations {} or more, or masses that differ less",
     "mass solver.iterations"},
    {Lint::kHeavyEnd, {"W0303", "heavy-end"},
     "(end_mass / mass) g timestep^2 / (size erp iterations), for a chain of joints", "0.1",
     "joints {} come apart", "timestep {} or less, or more solver.iterations",
     "links.end_mass timestep solver.iterations mass"},
    {Lint::kNarrowFoot, {"W0304", "narrow-foot"},
     "width of an object / width of the one object it stands on", "30",
     "objects {} tip over", "a base at least {} m wide",
     "size location"},
    {Lint::kOverlap, {"W0305", "overlap"},
     "initial overlap of neighbours in a line / size", "0.3",
     "objects {} be pushed apart", "a gap of -{} m or more",
     "location size"},
    {Lint::kLongStep, {"W0306", "long-step"},
     "g timestep^2 / size", "0.04 on a plane, 0.3 on a box; for balls that rest on one, none and 5",
     "objects {} sink in, drift or fall through", "timestep {} or less",
     "timestep acceleration size"},
    {Lint::kThinWall, {"W0307", "thin-wall"},
     "v timestep / (size + thickness of a box wall or fixed object), without ccd", "1.5",
     "objects {} pass through a wall or a fixed object", "timestep {} or less, or ccd on",
     "linear_velocity timestep acceleration world.wall_shape size"},
    {Lint::kFastHit, {"W0308", "fast-hit"},
     "v timestep / size, without ccd", "2",
     "an impact {} spin objects faster than Bullet can rotate them", "timestep {} or less, or ccd on",
     "linear_velocity timestep acceleration size"},
    {Lint::kSoftContact, {"W0309", "soft-contact"},
     "n m g / contact_stiffness, n objects high, m", "0.04",
     "objects on soft contacts {} lose their balance", "contact_stiffness {} or more",
     "contact_stiffness mass acceleration"},
    {Lint::kStiffSpring, {"W0310", "stiff-spring"},
     "w timestep, w the highest angular frequency of a group's springs", "2",
     "springs {} explode", "timestep {} or less, or a lower links.stiffness",
     "links.stiffness links.damping timestep mass"},
    {Lint::kThinShape, {"W0311", "thin-shape"},
     "longest side / shortest side, of objects that touch more than planes", "30, and never certain",
     "contacts {} be too deep or too shallow", "an aspect of 1 : {} or less",
     "aspect size type"},
    {Lint::kFastSpin, {"W0312", "fast-spin"},
     "spin timestep, rad", "1.41",
     "objects {} rotate more slowly than their spin", "timestep {} or less",
     "angular_velocity timestep"},
    {Lint::kSpinDrift, {"W0313", "spin-drift"},
     "cycles (spin timestep twist)^2, where twist is 0 for spin about a principal axis", "0.05",
     "free spin {} lose energy", "timestep {} or less",
     "angular_velocity timestep cycles"},
    {Lint::kHugeBox, {"W0314", "huge-box"},
     "diagonal of an object's bounding box + distance moved in a cycle, m", "1e6",
     "Bullet {} disable objects", "size + v timestep of {} m or less",
     "size linear_velocity timestep acceleration"},
    {Lint::kCoarsePlace, {"W0315", "coarse-place"},
     "spacing of floating-point numbers at an object's position / its size", "0.012, certain from 0.5",
     "contacts {} not be resolved", "positions within {} m, or precision double",
     "location world.side precision size"},
    {Lint::kLostMotion, {"W0316", "lost-motion"},
     "spacing of floating-point numbers / distance moved in a cycle; of speeds, / (5 g timestep)", "0.4",
     "objects {} move at a wrong speed or stand still", "positions within {} m, or precision double",
     "location world.side linear_velocity timestep precision"},
    {Lint::kLostFall, {"W0317", "lost-fall"},
     "spacing of floating-point numbers / the larger of g timestep^2 and 0.01 size", "0.3",
     "the fall of the first cycles {} be lost in rounding", "positions within {} m (a smaller world.side), or precision double",
     "world.side location quantity precision size acceleration timestep"},
    {Lint::kHeavyMass, {"W0318", "heavy-mass"},
     "mass, kg", "1.45e7 in single precision, 7e15 in double",
     "contacts {} be lost", "a mass of {} kg or less, or precision double",
     "mass precision"},
    {Lint::kEarlySleep, {"W0319", "early-sleep"},
     "0.8 m/s / speed or 1 rad/s / spin, of an object in flight for 2 s", "1",
     "objects {} fall asleep in flight", "sleeping off",
     "sleeping linear_velocity angular_velocity acceleration"},
    {Lint::kShortRun, {"W0320", "short-run"},
     "sqrt(n size / g) / duration of the run, times n / iterations if above 1", "35",
     "objects {} not have come to rest by the end of the run", "cycles {} or more",
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
  const bool is_below = number.Severity() < 1;
  std::string message =
      fmt::format("{}: {:.3g} is {} the limit of {:.3g} for {}",
                  fmt::format(fmt::runtime(info.predicts), number.IsBad() ? "will" : "may"),
                  number.value, is_below ? "near" : "above", number.threshold, info.number);
  if (is_below)
    message += fmt::format("; it sometimes happens from {:.2g} up",
                           number.threshold * LintNumber::kDoubtful);
  return message;
}

std::string LintRemedy(const LintNumber& number) {
  const std::string_view about = InfoOf(number.lint).about;
  if (InfoOf(number.lint).remedy.starts_with("timestep") && number.remedy < kLeastTimestep)
    return fmt::format("no practical time step is small enough; change {}",
                       about.substr(0, about.find(' ')));
  return fmt::format(fmt::runtime(InfoOf(number.lint).remedy),
                     RemedyNumber(number.lint, number.remedy));
}

}  // namespace cdb::lints
