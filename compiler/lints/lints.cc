#include "compiler/lints/lints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dsl/text/check.h"

namespace cdb::lints {
namespace {

// clang-format off
constexpr LintInfo kLints[] = {
    {.lint = Lint::kTallStack, .kind = {"W0301", "tall-stack"},
     .number = "n^2 g timestep^2 / (size iterations), n objects high",
     .threshold = "0.025; a pyramid counts for 0.4 of its height",
     .predicts = "the stack {} slide or fall",
     .remedy = "timestep {} or less, or more solver.iterations",
     .about = "timestep solver.iterations quantity location acceleration size"},
    {.lint = Lint::kMassRatio, .kind = {"W0302", "mass-ratio"},
     .number = "mass above / (mass below iterations), times 0.6 n on a stack of n",
     .threshold = "12",
     .predicts = "light objects {} give way under heavy ones",
     .remedy = "solver.iterations {} or more, or masses that differ less",
     .about = "mass solver.iterations"},
    {.lint = Lint::kHeavyEnd, .kind = {"W0303", "heavy-end"},
     .number = "(mass held / mass) g timestep^2 / (size erp iterations), in maximal coordinates; held is end_mass of a chain, or what joints hold beyond an object",
     .threshold = "0.1",
     .predicts = "joints {} come apart",
     .remedy = "timestep {} or less, more solver.iterations, or coordinates reduced",
     .about = "links.end_mass mass timestep solver.iterations"},
    {.lint = Lint::kNarrowFoot, .kind = {"W0304", "narrow-foot"},
     .number = "width of an object / width of the one object it stands on",
     .threshold = "30",
     .predicts = "objects {} tip over",
     .remedy = "a base at least {} m wide",
     .about = "size location"},
    {.lint = Lint::kOverlap, .kind = {"W0305", "overlap"},
     .number = "initial overlap of neighbours in a line / size",
     .threshold = "0.3",
     .predicts = "objects {} be pushed apart",
     .remedy = "a gap of -{} m or more",
     .about = "location size"},
    {.lint = Lint::kLongStep, .kind = {"W0306", "long-step"},
     .number = "g timestep^2 / size",
     .threshold = "0.04 on a floor that is a plane, 0.0125 for a box that slides on it, 0.3 on a box (world.wall_shape box); for balls that rest on one, none and 5",
     .predicts = "objects {} sink in, drift or fall through",
     .remedy = "timestep {} or less; on a plane, also world.wall_shape box",
     .about = "timestep acceleration size"},
    {.lint = Lint::kThinWall, .kind = {"W0307", "thin-wall"},
     .number = "v timestep / (size + thickness of a box wall or fixed object), without ccd",
     .threshold = "1.5",
     .predicts = "objects {} pass through a wall or a fixed object",
     .remedy = "timestep {} or less, or ccd on",
     .about = "linear_velocity timestep acceleration world.wall_shape size"},
    {.lint = Lint::kFastHit, .kind = {"W0308", "fast-hit"},
     .number = "v timestep / size, without ccd",
     .threshold = "2",
     .predicts = "an impact {} spin objects faster than Bullet can rotate them",
     .remedy = "timestep {} or less, or ccd on",
     .about = "linear_velocity timestep acceleration size"},
    {.lint = Lint::kSoftContact, .kind = {"W0309", "soft-contact"},
     .number = "n m g / contact_stiffness, n objects high, m",
     .threshold = "0.04",
     .predicts = "objects on soft contacts {} lose their balance",
     .remedy = "contact_stiffness {} or more",
     .about = "contact_stiffness mass acceleration"},
    {.lint = Lint::kStiffSpring, .kind = {"W0310", "stiff-spring"},
     .number = "w timestep, w the highest angular frequency of a group's springs, or of a block",
     .threshold = "2",
     .predicts = "springs or blocks {} explode",
     .remedy = "timestep {} or less, or a lower stiffness",
     .about = "links.stiffness links.damping soft.stiffness soft.damping soft.young_modulus "
              "soft.poisson_ratio soft.stiffness_damping size timestep mass"},
    {.lint = Lint::kThinShape, .kind = {"W0311", "thin-shape"},
     .number = "longest side / shortest side, of objects that touch more than planes",
     .threshold = "30, and never certain",
     .predicts = "contacts {} be too deep or too shallow",
     .remedy = "an aspect of 1 : {} or less",
     .about = "aspect size type"},
    {.lint = Lint::kFastSpin, .kind = {"W0312", "fast-spin"},
     .number = "spin timestep, rad",
     .threshold = "1.41",
     .predicts = "objects {} rotate more slowly than their spin",
     .remedy = "timestep {} or less",
     .about = "angular_velocity timestep"},
    {.lint = Lint::kSpinDrift, .kind = {"W0313", "spin-drift"},
     .number = "cycles (spin timestep twist)^2, where twist is 0 for spin about a principal axis",
     .threshold = "0.05",
     .predicts = "free spin {} lose energy",
     .remedy = "timestep {} or less",
     .about = "angular_velocity timestep cycles"},
    {.lint = Lint::kHugeBox, .kind = {"W0314", "huge-box"},
     .number = "diagonal of an object's bounding box + distance moved in a cycle, m",
     .threshold = "1e6",
     .predicts = "Bullet {} disable objects",
     .remedy = "size + v timestep of {} m or less",
     .about = "size linear_velocity timestep acceleration"},
    {.lint = Lint::kCoarsePlace, .kind = {"W0315", "coarse-place"},
     .number = "spacing of floating-point numbers at an object's position / its size",
     .threshold = "0.012, certain from 0.5",
     .predicts = "contacts {} not be resolved",
     .remedy = "positions within {} m, or precision double",
     .about = "location world.side precision size"},
    {.lint = Lint::kLostMotion, .kind = {"W0316", "lost-motion"},
     .number = "spacing of floating-point numbers / distance moved in a cycle; of speeds, / (5 g timestep)",
     .threshold = "0.4",
     .predicts = "objects {} move at a wrong speed or stand still",
     .remedy = "positions within {} m, or precision double",
     .about = "location world.side linear_velocity timestep precision"},
    {.lint = Lint::kLostFall, .kind = {"W0317", "lost-fall"},
     .number = "spacing of floating-point numbers / the larger of g timestep^2 and 0.01 size",
     .threshold = "0.3",
     .predicts = "the fall of the first cycles {} be lost in rounding",
     .remedy = "positions within {} m (a smaller world.side), or precision double",
     .about = "world.side location quantity precision size acceleration timestep"},
    {.lint = Lint::kHeavyMass, .kind = {"W0318", "heavy-mass"},
     .number = "mass, kg",
     .threshold = "1.45e7 in single precision, 7e15 in double",
     .predicts = "contacts {} be lost",
     .remedy = "a mass of {} kg or less, or precision double",
     .about = "mass precision"},
    {.lint = Lint::kEarlySleep, .kind = {"W0319", "early-sleep"},
     .number = "0.8 m/s / speed or 1 rad/s / spin, of an object in flight, without friction, or of a ball that rolls, for 2 s",
     .threshold = "1",
     .predicts = "objects {} fall asleep in motion",
     .remedy = "sleeping off",
     .about = "sleeping linear_velocity angular_velocity acceleration"},
    {.lint = Lint::kShortRun, .kind = {"W0320", "short-run"},
     .number = "sqrt(n size / g) / duration of the run, times n / iterations if above 1",
     .threshold = "35",
     .predicts = "objects {} not have come to rest by the end of the run",
     .remedy = "cycles {} or more",
     .about = "cycles timestep size acceleration"},
    {.lint = Lint::kInternalEdges, .kind = {"W0321", "internal-edges"},
     .number = "distance that an object can move / its size, if it may touch a surface with edges bullet, or adjacent fixed boxes",
     .threshold = "1, and never certain",
     .predicts = "edges between coplanar faces of the ground {} deflect objects",
     .remedy = "edges smooth for a surface, or one box in place of several",
     .about = "linear_velocity acceleration location type"},
    {.lint = Lint::kForeseenBounce, .kind = {"W0322", "foreseen-bounce"},
     .number = "v timestep / half the least side, with ccd and restitution",
     .threshold = "1, and never certain",
     .predicts = "bounces {} lose their energy, as contacts that ccd foresees have no restitution",
     .remedy = "timestep {} or less",
     .about = "ccd restitution linear_velocity timestep acceleration size"},
    {.lint = Lint::kLossyBounce, .kind = {"W0323", "lossy-bounce"},
     .number = "energy that contacts may take from a rebound or give it / what the verdict permits, at least 1 if it is elastic; with contact faithful, 0.2 m/s / v",
     .threshold = "1, and never certain",
     .predicts = "bounces {} lose or gain energy",
     .remedy = "contact faithful, and speeds above {} m/s",
     .about = "contact restitution linear_velocity acceleration"},
    {.lint = Lint::kLongChain, .kind = {"W0324", "long-chain"},
     .number = "n^2 g timestep^2 / (size iterations), for a held chain of n joints; n^4 if they are fixed and it does not hang",
     .threshold = "0.2 if it hangs straight down, 0.05 if not; 0.001 for n^4",
     .predicts = "the joints of a long chain {} come apart or bend",
     .remedy = "timestep {} or less, or more solver.iterations",
     .about = "quantity timestep solver.iterations links.type location"},
    {.lint = Lint::kSwingingJoint, .kind = {"W0325", "swinging-joint"},
     .number = "cycles (n w timestep)^2, w the angular frequency of a pendulum of n objects",
     .threshold = "3, certain from 8 for a chain that is let go",
     .predicts = "the joints of a pendulum {} take its energy",
     .remedy = "timestep {} or less",
     .about = "timestep cycles quantity linear_velocity location"},
    {.lint = Lint::kCrush, .kind = {"W0326", "crush"},
     .number = "distance by which a kinematic object closes a gap / room in the gap beside an object",
     .threshold = "1, certain for an object that begins in the gap",
     .predicts = "objects {} be crushed between kinematic and fixed ones",
     .remedy = "motion that closes the gap by {} m or less",
     .about = "linear_velocity location cycles size"},
    {.lint = Lint::kCreep, .kind = {"W0327", "creep"},
     .number = "0.5 mm/s duration / size, of objects at rest until they may sleep, in single precision",
     .threshold = "0.25, and never certain",
     .predicts = "objects at rest {} creep aside",
     .remedy = "precision double, or a size of {} m or more",
     .about = "size precision sleeping cycles"},
    {.lint = Lint::kRollingGain, .kind = {"W0328", "rolling-gain"},
     .number = "duration sqrt(g / size), of a cylinder or capsule that may roll, no faster than sqrt(g size)",
     .threshold = "4.8, and never certain",
     .predicts = "rolling {} gain energy, as contacts are kept from where the object was before",
     .remedy = "narrow_phase batch, a sphere, or rolling_friction",
     .about = "linear_velocity narrow_phase type acceleration cycles"},
    {.lint = Lint::kLeaningStack, .kind = {"W0329", "leaning-stack"},
     .number = "n^2 s timestep sqrt(g / size), n objects high and pulled aside by s g",
     .threshold = "0.02, and never certain; solver.iterations have no effect",
     .predicts = "a stack that is pulled aside {} creep and fall",
     .remedy = "timestep {} or less",
     .about = "acceleration timestep quantity location size"},
    {.lint = Lint::kSlidingBox, .kind = {"W0330", "sliding-box"},
     .number = "time for which a cuboid slides on a floor that is a plane / sqrt(size / g)",
     .threshold = "12, and never certain; the time step has hardly any effect",
     .predicts = "friction {} turn a box, or brake it too much or too little, as Bullet finds one corner on a plane at a time",
     .remedy = "world.wall_shape box, or narrow_phase batch",
     .about = "world.wall_shape narrow_phase linear_velocity friction"},
    {.lint = Lint::kTumblingTree, .kind = {"W0331", "tumbling-tree"},
     .number = "cycles (w timestep)^2, w the spin at the start, averaged by mass, of a tree in reduced coordinates that nothing holds and in which a joint turns",
     .threshold = "0.2",
     .predicts = "a tree that tumbles {} gain energy, as Bullet takes its Coriolis terms from the start of the step",
     .remedy = "timestep {} or less, or coordinates maximal",
     .about = "angular_velocity timestep cycles coordinates"},
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
