#include "compiler/schema/schema.h"

#include <algorithm>

#include "compiler/schema/catalogue.h"
#include "compiler/schema/components.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/value.h"

namespace cdb::schema {
namespace {

using enum ParameterType;
using enum WordSource;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMaxSeed = 18446744073709551615.0;
constexpr Domain kAny = {};
constexpr Domain kPositive = {.min = 0, .min_open = true};
constexpr Domain kNotNegative = {.min = 0};
constexpr Domain kFraction = {.min = 0, .max = 1};
/// Cycles, objects and repeats are int32 coordinates of the results.
constexpr Domain kCountFromOne = {.min = 1, .max = 2147483647};
constexpr Domain kCountFromZero = {.min = 0, .max = 2147483647};
constexpr bool kGroup = true;
constexpr bool kDrawn = true;
constexpr bool kConstant = false;

// clang-format off
constexpr Parameter kParameters[] = {
    // The ten of the paper, section 3.1.
    {"cycles", false, kCount, kCountFromOne, kConstant, "", "1000", "", kOwn, "clock",
     "collision-detection cycles to time",
     "steps frames iterations duration"},
    {"quantity", kGroup, kCount, kCountFromZero, kConstant, "", "10", "", kOwn, "bodies",
     "how many objects",
     "count number n amount objects"},
    {"type", kGroup, kWord, kAny, kDrawn, "", "sphere", "", kObjectTypes, "shapes",
     "what the objects are",
     "kind shape shapes object types", "mesh hull"},
    {"aspect", kGroup, kRatio, kPositive, kConstant, "", "1 : 1 : 1", "", kOwn, "shapes",
     "1 : y : z; a side is size times its part, the full extent along x, y and z; at 1 : 1 : 1 a mesh keeps its own proportions, the longest side is the size"},
    {"location", kGroup, kWord, kAny, kConstant, "", "uniform", "", kLayouts, "placement",
     "how the objects are placed; nothing overlaps unless overlap says so",
     "position layout placement distribution", "grid stack pyramid pile ring line at pair"},
    {"overlap", kGroup, kSwitch, kAny, kConstant, "", "off", "", kOwn, "placement",
     "objects may begin inside those of any group that has it on too, where a layout with arguments puts them there",
     "overlapping"},
    {"size", kGroup, kReal, kPositive, kDrawn, "m", "50", "", kOwn, "shapes",
     "full extent of an object; a distribution draws each side by itself",
     "radius diameter length extent scale"},
    {"mass", kGroup, kReal, kPositive, kDrawn, "kg", "1", "fixed", kOwn, "bodies",
     "mass of an object; fixed ones never move",
     "weight density"},
    {"acceleration", false, kVector, kAny, kDrawn, "m/s^2", "(0, -9.8, 0)", "", kOwn, "gravity",
     "acts on every object; a distribution is drawn once for the world",
     "gravity g", "every rotating"},
    {"linear_velocity", kGroup, kVector, kAny, kDrawn, "m/s", "0", "", kOwn, "bodies",
     "velocity of the centre of mass at the start",
     "velocity speed v", "every rotating"},
    {"angular_velocity", kGroup, kVector, kAny, kDrawn, "rad/s", "0", "", kOwn, "bodies",
     "spin at the start",
     "spin rotation omega", "every rotating"},

    // What a study needs beside them: the world,
    {"seed", false, kCount, {.min = 0, .max = kMaxSeed}, kConstant, "", "0xAAAAAAAAAA", "", kOwn, "streams",
     "every distribution has a random stream of its own, seeded by it",
     "random_seed rng"},
    // In a default, `objects` is the number of objects in all groups, at least 1.
    {"world.side", false, kReal, kPositive, kConstant, "m", "50 * objects", "", kOwn, "walls",
     "side of the cube, centred on the origin; 50 times the number of objects where it is left out",
     "side cube box width world.size"},
    {"world.walls", false, kWord, kAny, kConstant, "", "all", "all floor none", kOwn, "walls",
     "which walls of the cube stand; floor is the one at -y",
     "walls floor ground"},
    {"world.wall_shape", false, kWord, kAny, kConstant, "", "plane", "plane box", kOwn, "walls",
     "infinite planes, or boxes"},
    {"timestep", false, kReal, kPositive, kConstant, "s", "1 / 60", "", kOwn, "step",
     "simulated time of one cycle",
     "dt time_step delta_t step frequency hz"},
    {"precision", false, kWord, kAny, kConstant, "", "single", "single double", kOwn, "worker",
     "of Bullet's numbers",
     "float real"},
    {"detector", false, kWord, kAny, kConstant, "", "dbvt", "", kDetectors, "detector",
     "the collision detector",
     "broadphase broad_phase broad algorithm detectors"},
    {"narrow_phase", false, kWord, kAny, kConstant, "", "own", "own", kNarrowPhases, "detector",
     "who finds the contacts of the detector's pairs; own is the detector itself where it has a narrow phase, else Bullet",
     "narrowphase narrow contacts_by"},
    {"pair_order", false, kWord, kAny, kConstant, "", "listed", "listed sorted", kOwn, "detector",
     "in which order pairs are worked on: as the detector lists them, or sorted by body, so that all who list the same pairs move alike to the bit",
     "order deterministic"},
    {"threads", false, kCount, kCountFromOne, kConstant, "", "1", "", kOwn, "detector",
     "threads that the detector may work on; those without threads work on one",
     "cores parallel"},
    {"trace", false, kText, kAny, kConstant, "", "none", "none", kOwn, "trace",
     "the file of a recorded run (`cdb trace`), from the folder of the .cdb file: detectors are run on its boxes, without a world",
     "replay recording motion baked", "file"},
    {"contact", false, kWord, kAny, kConstant, "", "bullet", "bullet faithful", kOwn, "solver",
     "Bullet's own contact settings, or those under which bounces keep their energy"},
    {"solver.iterations", false, kCount, kCountFromOne, kConstant, "", "10", "", kOwn, "solver",
     "sweeps of the constraint solver over all contacts in a cycle",
     "solver_iterations solver.steps"},
    {"solver.erp", false, kReal, kFraction, kConstant, "", "0.2", "", kOwn, "solver",
     "part of a penetration that is mended in a cycle"},
    {"solver.warm_start", false, kReal, kFraction, kConstant, "", "0.85", "", kOwn, "solver",
     "part of the last cycle's impulses that the solver starts from; 0 is a cold start"},

    // the objects,
    {"friction", kGroup, kReal, kNotNegative, kDrawn, "", "0.5", "", kOwn, "contact material",
     "coefficient of sliding friction; a contact takes the product of both"},
    {"rolling_friction", kGroup, kReal, kNotNegative, kDrawn, "m", "0", "", kOwn, "contact material",
     "resistance to rolling",
     "rolling"},
    {"restitution", kGroup, kReal, kFraction, kDrawn, "", "0", "", kOwn, "contact material",
     "part of the normal velocity that a bounce keeps; a contact takes the product of both",
     "bounce bounciness elasticity"},
    {"linear_damping", kGroup, kReal, kFraction, kDrawn, "", "0", "", kOwn, "damping",
     "part of the velocity lost in a second"},
    {"angular_damping", kGroup, kReal, kFraction, kDrawn, "", "0", "", kOwn, "damping",
     "part of the spin lost in a second"},
    {"margin", kGroup, kReal, kNotNegative, kDrawn, "m", "0.04", "", kOwn, "shapes",
     "Bullet's collision margin; the outer extent of the object stays what size says"},
    {"contact_stiffness", kGroup, kReal, kPositive, kDrawn, "N/m", "rigid", "rigid", kOwn, "contact material",
     "spring constant of a soft contact"},
    {"contact_damping", kGroup, kReal, kNotNegative, kDrawn, "N s/m", "0.1", "", kOwn, "contact material",
     "damper of a soft contact; without effect where the contact is rigid"},
    {"ccd", kGroup, kSwitch, kAny, kDrawn, "", "off", "", kOwn, "continuous detection",
     "continuous collision detection, for fast objects"},
    {"orientation", kGroup, kVector, kAny, kDrawn, "rad", "0", "random", kOwn, "bodies",
     "turn at the start as axis times angle; random is uniform over all turns",
     "turn rotation angle"},
    {"links.type", kGroup, kWord, kAny, kConstant, "", "none", "none ball hinge fixed spring", kOwn, "links",
     "what holds each object to the next, in order: a ball, hinge (about z) or fixed joint half way between their centres, or a spring from centre to centre",
     "joint joints constraint constraints links"},
    {"links.stiffness", kGroup, kReal, kPositive, kConstant, "N/m", "1000", "", kOwn, "links",
     "of each spring; its length at the start is its length at rest"},
    {"links.damping", kGroup, kReal, kNotNegative, kConstant, "N s/m", "0", "", kOwn, "links",
     "of each spring, along it"},
    {"links.anchor", kGroup, kSwitch, kAny, kConstant, "", "on", "", kOwn, "links",
     "the first object is linked to the world too, where it starts",
     "pin"},
    {"links.end_mass", kGroup, kReal, kPositive, kConstant, "kg", "same", "same", kOwn, "links",
     "mass of the last object; same is that of the others"},
    {"sleeping", false, kSwitch, kAny, kConstant, "", "on", "", kOwn, "sleeping",
     "objects at rest are put to sleep",
     "sleep deactivation"},

    // and the measurement.
    {"repeats", false, kCount, kCountFromOne, kConstant, "", "1", "", kOwn, "schedule",
     "timed repeats of each point",
     "repetitions runs reps repeat"},
    {"warmup", false, kCount, kCountFromZero, kConstant, "", "0", "", kOwn, "clock",
     "cycles before the first that is recorded"},
    {"timeout", false, kReal, kPositive, kConstant, "s", "none", "none", kOwn, "schedule",
     "wall time after which a run is ended and marked"},
    {"record", false, kWords, kAny, kConstant, "", "timing, counts, stability",
     "timing counts energy stability contacts poses memory pairs boxes", kOwn, "recording",
     "what is stored of each cycle",
     "output store measure metrics"},
    {"expect", false, kWord, kAny, kConstant, "", "auto", "auto anything rest energy", kOwn, "verdict",
     "what the scene ought to do, for its verdict; auto: stacks, pyramids and piles rest, elastic scenes without friction keep their energy",
     "should verdict"},
    {"omit", false, kWords, kAny, kConstant, "", "auto", "auto none", kComponents, "needs",
     "which parts of the engine to leave out that the scene provably does not need",
     "prune exclude skip_parts without leave_out"},

    // What it is held against.
    {"accuracy.metrics", false, kWords, kAny, kConstant, "", "none", "none", kMetrics, "accuracy",
     "errors to collect, in a pass of its own beside the timed one",
     "errors error accuracy"},
    {"accuracy.interval", false, kReal, kPositive, kConstant, "s", "1 / 15", "", kOwn, "accuracy",
     "simulated time from one sample to the next; a whole number of time steps, and the same in every run",
     "accuracy.samples accuracy.every"},
    {"accuracy.closed_form", false, kWord, kAny, kConstant, "", "none", "none", kClosedForms, "accuracy",
     "what is true by physics alone; none makes a reference run where errors need one",
     "accuracy.truth accuracy.analytic"},
    {"accuracy.reference.timestep", false, kReal, kPositive, kConstant, "s", "1 / 3840", "", kOwn, "accuracy",
     "time step of the reference run"},
    {"accuracy.reference.precision", false, kWord, kAny, kConstant, "", "double", "single double", kOwn, "accuracy",
     "of the reference run"},
    {"accuracy.reference.detector", false, kWord, kAny, kConstant, "", "dbvt", "", kDetectors, "accuracy",
     "of the reference run"},
    {"accuracy.reference.iterations", false, kCount, kCountFromOne, kConstant, "", "100", "", kOwn, "accuracy",
     "solver.iterations of the reference run"},
    {"accuracy.reference.contact", false, kWord, kAny, kConstant, "", "same", "same bullet faithful", kOwn, "accuracy",
     "of the reference run; same is the run's own"},
};
// clang-format on

std::string_view NextWord(std::string_view& words) {
  const std::size_t space = words.find(' ');
  const std::string_view word = words.substr(0, space);
  words.remove_prefix(space == std::string_view::npos ? words.size() : space + 1);
  return word;
}

}  // namespace

bool Domain::Contains(double value) const {
  return (min_open ? value > min : value >= min) && value <= max;
}

std::string Domain::Text() const {
  const bool above = min != -kInfinity;
  const bool below = max != kInfinity && max < 2147483647;
  if (above && below) return "between " + FormatReal(min) + " and " + FormatReal(max);
  if (above) return (min_open ? "more than " + FormatReal(min) : FormatReal(min) + " or more");
  return "any number";
}

std::string Parameter::FullName() const {
  return grouped ? "objects." + std::string(name) : std::string(name);
}

std::vector<std::string_view> Parameter::AllWords(std::span<const PluginDetector> plugins) const {
  std::vector<std::string_view> all;
  for (std::string_view rest = words; !rest.empty();) all.push_back(NextWord(rest));
  const auto add = [&all](const auto& rows) {
    for (const auto& row : rows) all.push_back(row.name);
  };
  const auto add_detectors = [&](std::string_view phase) {
    for (const DetectorInfo& detector : Detectors())
      if (detector.HasPhase(phase)) all.push_back(detector.name);
    for (const PluginDetector& detector : plugins)
      if (FindDetector(detector.name, plugins)->HasPhase(phase)) all.push_back(detector.name);
  };
  switch (word_source) {
    case kOwn:
      break;
    case kObjectTypes:
      add(ObjectTypes());
      break;
    case kDetectors:
      add_detectors("broad");
      break;
    case kNarrowPhases:
      add_detectors("narrow");
      break;
    case kLayouts:
      add(Layouts());
      break;
    case kComponents:
      add(Components());
      break;
    case kMetrics:
      add(Metrics());
      break;
    case kClosedForms:
      add(ClosedForms());
      break;
  }
  return all;
}

bool Parameter::HasWord(std::string_view word, std::span<const PluginDetector> plugins) const {
  const auto all = AllWords(plugins);
  return std::ranges::find(all, word) != all.end();
}

bool Parameter::TakesDetectors() const {
  return word_source == kDetectors || word_source == kNarrowPhases;
}

std::vector<std::string_view> Parameter::AllCalls() const {
  std::vector<std::string_view> all;
  for (std::string_view rest = calls; !rest.empty();) all.push_back(NextWord(rest));
  return all;
}

bool Parameter::TakesCall(std::string_view word) const { return ListsWord(calls, word); }

bool Parameter::StandsAlone(std::string_view word) const {
  return type == kWords && word_source != kOwn && ListsWord(words, word);
}

std::string Parameter::Takes(std::span<const PluginDetector> plugins) const {
  std::string text;
  switch (type) {
    case kCount:
      text = "a whole number, " + domain.Text();
      break;
    case kReal:
      text = "a number, " + domain.Text();
      break;
    case kSwitch:
      text = "on or off";
      break;
    case kWord:
      text = "one of";
      break;
    case kWords:
      text = "a list of";
      break;
    case kVector:
      text = domain.not_zero ? "a vector (x, y, z) other than 0" : "a vector (x, y, z), or 0";
      break;
    case kRatio:
      text = "a ratio 1 : y : z, each part " + domain.Text();
      break;
    case kText:
      text = "a text in quotes";
      break;
  }
  if (domain.min == -kInfinity && type == kReal) text = "a number";
  const bool only_words = type == kWord || type == kWords;
  std::string alone, listed;
  const auto list = [&](std::string_view word, std::string_view brackets) {
    listed += only_words ? (listed.empty() ? " " : ", ") : ", or ";
    listed += word;
    listed += brackets;
  };
  for (const std::string_view word : AllWords(plugins)) {
    if (StandsAlone(word)) {
      alone += std::string(word) + ", ";
    } else {
      list(word, "");
    }
  }
  for (const std::string_view call : AllCalls())
    list(call, RequiredArguments(*FindParametrisedWord(call)).empty() ? "" : "( )");
  text = (alone.empty() ? "" : alone + "or ") + text + listed;
  if (distribution) text += ", or a distribution";
  return text;
}

bool ListsWord(std::string_view words, std::string_view word) {
  while (!words.empty())
    if (NextWord(words) == word) return true;
  return false;
}

std::span<const Parameter> Schema() { return kParameters; }

std::vector<std::string_view> BlocksIn(std::string_view block, bool grouped) {
  std::vector<std::string_view> blocks;
  for (const Parameter& parameter : kParameters) {
    std::string_view rest = parameter.name;
    if (parameter.grouped != grouped) continue;
    if (!block.empty()) {
      if (!rest.starts_with(std::string(block) + ".")) continue;
      rest.remove_prefix(block.size() + 1);
    }
    const std::size_t dot = rest.find('.');
    if (dot == std::string_view::npos) continue;
    const std::string_view name = rest.substr(0, dot);
    if (std::ranges::find(blocks, name) == blocks.end()) blocks.push_back(name);
  }
  return blocks;
}

const Parameter* FindParameter(std::string_view name, bool grouped) {
  const auto* row = std::ranges::find_if(kParameters, [&](const Parameter& parameter) {
    return parameter.grouped == grouped && parameter.name == name;
  });
  return row == std::end(kParameters) ? nullptr : row;
}

}  // namespace cdb::schema
