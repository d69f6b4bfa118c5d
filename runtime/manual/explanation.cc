#include "runtime/manual/explanation.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <string>

#include "compiler/lints/lints.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/parametrised_words.h"
#include "runtime/terminal/console.h"
#include "runtime/terminal/table.h"

namespace cdb::manual {
namespace {

bool IsSameWord(std::string_view a, std::string_view b) {
  const auto lower = [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  return std::ranges::equal(a, b, {}, lower, lower);
}

/// Indents each line by four spaces. Cuts long lines, and replaces bytes that are not text.
std::string ExampleText(std::string_view text) {
  constexpr std::size_t kLongest = 90;
  std::string indented;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    indented += "    ";
    for (const char c : line.substr(0, kLongest)) {
      const auto byte = static_cast<unsigned char>(c);
      indented += byte < 0x20 || byte == 0xE9 ? std::string("\uFFFD") : std::string(1, c);
    }
    indented += line.size() > kLongest ? "…\n" : "\n";
  }
  return indented;
}

}  // namespace

std::optional<std::string> ExampleFile(std::string_view path) {
  if (path == "masses.csv") return "1.5\n2.5 kg\n";
  if (path == "level.obj") return "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 4 3 2\n";
  if (path == "wheel.stl") return "solid wheel\nendsolid\n";
  return std::nullopt;
}

std::optional<analysis::ModelFacts> ExampleModel(const schema::Value& type, analysis::ModelFault&) {
  const schema::Call* call = schema::AsCall(type);
  if (call == nullptr) return std::nullopt;
  analysis::ModelFacts facts;
  if (call->name == "compound") {
    facts.sides = {10, 20, 10};
    return facts;
  }
  if (call->name != "mesh") return std::nullopt;
  const bool is_fine = schema::AsNumber(schema::ArgumentOf(*call, "hulls")) != nullptr;
  facts.iou = is_fine ? 0.93 : 0.65;
  facts.hulls = 40;
  facts.text = "mesh(\"wheel.stl\"): 40 hulls, volume error 52 %, IoU 0.650";
  return facts;
}

std::vector<const Explanation*> AllExplanations() {
  std::vector<const Explanation*> all;
  for (const auto rows : {SyntaxExplanations(), ScenarioExplanations(), LintExplanations()})
    for (const Explanation& row : rows) all.push_back(&row);
  return all;
}

std::vector<const Explanation*> FindExplanations(std::string_view wanted) {
  std::vector<const Explanation*> found;
  for (const Explanation* row : AllExplanations())
    if (IsSameWord(row->kind->code, wanted) || IsSameWord(row->kind->id, wanted))
      found.push_back(row);
  return found;
}

std::string ExplanationText(const Explanation& explanation, std::string_view rendered) {
  const bool is_error = explanation.kind->severity() == dsl::Severity::kError;
  return fmt::format("{} {} ({})\n{}\nWRONG\n{}\n{}\nRIGHT\n{}", explanation.kind->code,
                     explanation.kind->id, is_error ? "error" : "warning",
                     terminal::Wrapped(explanation.text, 2), ExampleText(explanation.wrong),
                     rendered, ExampleText(explanation.right));
}

std::string ExplanationList() {
  terminal::Table table;
  table.KeepWhole();
  for (const char* head : {"code", "name", ""}) table.AddColumn(head, false);
  for (const Explanation* row : AllExplanations()) {
    std::string_view sentence = row->text.substr(0, row->text.find(". "));
    if (sentence.ends_with('.')) sentence.remove_suffix(1);
    table.AddRow({std::string(row->kind->code), std::string(row->kind->id), std::string(sentence)});
  }
  return table.Text();
}

// Explanations of the lints of compiler/lints/lints.h. `cdb doc lints` prints their limits.

namespace {

using lints::Lint;

struct LintExample {
  Lint lint;
  std::string_view wrong, right;
};

constexpr LintExample kExamples[] = {
    {Lint::kTallStack,
     "benchmark b { objects { quantity 20; type cuboid; size 1; location stack } }\n",
     "benchmark b {\n  timestep 1 / 500\n  cycles 5000\n"
     "  objects { quantity 20; type cuboid; size 1; location stack }\n}\n"},
    {Lint::kMassRatio,
     "benchmark b { objects { quantity 2; size 20; location stack; mass log_uniform(1, 1e4) } }\n",
     "benchmark b { objects { quantity 2; size 20; location stack; mass uniform(1, 2) } }\n"},
    {Lint::kHeavyEnd,
     "benchmark b {\n  objects { quantity 5; size 40; location line; links { type ball; end_mass "
     "1e4 "
     "} }\n}\n",
     "benchmark b {\n  objects { quantity 5; size 40; location line; links { type ball; end_mass "
     "10 "
     "} }\n}\n"},
    {Lint::kNarrowFoot,
     "benchmark b {\n  expect rest\n"
     "  objects small { quantity 1; type cuboid; size 1; location at(0, 0, 0) }\n"
     "  objects large { quantity 1; type cuboid; size 40; location at(0, 21, 0) }\n}\n",
     "benchmark b {\n  expect rest\n"
     "  objects small { quantity 1; type cuboid; size 20; location at(0, -30, 0) }\n"
     "  objects large { quantity 1; type cuboid; size 40; location at(0, 0, 0) }\n}\n"},
    {Lint::kOverlap,
     "benchmark b { objects { quantity 2; size 1; overlap on; location line(gap: -0.5) } }\n",
     "benchmark b { objects { quantity 2; size 1; overlap on; location line(gap: -0.05) } }\n"},
    {Lint::kLongStep, "benchmark b { objects { size 0.2 } }\n",
     "benchmark b { timestep 1 / 240; objects { size 0.2 } }\n"},
    {Lint::kThinWall,
     "benchmark b {\n  acceleration 0\n  world { walls none; side 50 }\n"
     "  objects ball { quantity 1; size 0.2; location at(-5, 0, 0); linear_velocity (100, 0, 0) }\n"
     "  objects slab {\n    quantity 1; type cuboid; size 0.1; aspect 1 : 40 : 40; mass fixed\n"
     "    location at(0, 0, 0)\n  }\n}\n",
     "benchmark b {\n  acceleration 0\n  world { walls none; side 50 }\n"
     "  objects ball { quantity 1; size 0.2; location at(-5, 0, 0); linear_velocity (5, 0, 0) }\n"
     "  objects slab {\n    quantity 1; type cuboid; size 0.1; aspect 1 : 40 : 40; mass fixed\n"
     "    location at(0, 0, 0)\n  }\n}\n"},
    {Lint::kFastHit, "benchmark b { objects { size 1; linear_velocity (200, 0, 0) } }\n",
     "benchmark b { timestep 1 / 1000; objects { size 1; linear_velocity (200, 0, 0) } }\n"},
    {Lint::kSoftContact,
     "benchmark b {\n  objects { size 40; quantity 2; location stack; contact_stiffness 10 }\n}\n",
     "benchmark b {\n  objects { size 40; quantity 2; location stack; contact_stiffness 1e4 "
     "}\n}\n"},
    {Lint::kStiffSpring,
     "benchmark b {\n  objects { quantity 3; size 40; location line; links { type spring; "
     "stiffness "
     "1e5 } }\n}\n",
     "benchmark b {\n  objects { quantity 3; size 40; location line; links { type spring; "
     "stiffness "
     "100 } }\n}\n"},
    {Lint::kThinShape, "benchmark b { objects { type cylinder; size 5; aspect 1 : 40 : 1 } }\n",
     "benchmark b { objects { type cylinder; size 5; aspect 1 : 4 : 1 } }\n"},
    {Lint::kFastSpin,
     "benchmark b {\n  world.walls none\n  acceleration 0\n"
     "  objects { type sphere; angular_velocity (100, 0, 0) }\n}\n",
     "benchmark b {\n  world.walls none\n  acceleration 0\n"
     "  objects { type sphere; angular_velocity (10, 0, 0) }\n}\n"},
    {Lint::kSpinDrift,
     "benchmark b {\n  world.walls none\n  acceleration 0\n"
     "  objects { type cuboid; aspect 1 : 2 : 3; angular_velocity (10, 5, 0) }\n}\n",
     "benchmark b {\n  world.walls none\n  acceleration 0\n"
     "  objects { type cuboid; aspect 1 : 2 : 3; angular_velocity (10, 0, 0) }\n}\n"},
    {Lint::kHugeBox, "benchmark b { world { side 1e8; walls none }; objects.size 1e6 }\n",
     "benchmark b { world { side 1e6; walls none }; objects.size 1e4 }\n"},
    {Lint::kCoarsePlace,
     "benchmark b { world.side 1e6; objects { size 1; linear_velocity (10, 0, 0) } }\n",
     "benchmark b {\n  precision double\n  world.side 1e6\n"
     "  objects { size 1; linear_velocity (10, 0, 0) }\n}\n"},
    {Lint::kLostMotion,
     "benchmark b {\n  world { side 1e7; walls none }\n  acceleration 0\n"
     "  objects { quantity 1; size 1; location at(2e6, 0, 0); linear_velocity (1, 0, 0) }\n}\n",
     "benchmark b {\n  world { side 1e4; walls none }\n  acceleration 0\n"
     "  objects { quantity 1; size 1; location at(0, 0, 0); linear_velocity (1, 0, 0) }\n}\n"},
    {Lint::kLostFall, "benchmark b { world.side 4e6 }\n", "benchmark b { world.side 1e4 }\n"},
    {Lint::kHeavyMass, "benchmark b { objects.mass 1e8 }\n", "benchmark b { objects.mass 1e6 }\n"},
    {Lint::kEarlySleep,
     "benchmark b {\n  world.walls none\n  acceleration 0\n  objects.linear_velocity (0.1, 0, "
     "0)\n}\n",
     "benchmark b {\n  world.walls none\n  acceleration 0\n  sleeping off\n"
     "  objects.linear_velocity (0.1, 0, 0)\n}\n"},
    {Lint::kShortRun, "benchmark b { cycles 3; objects { size 40; quantity 2; location stack } }\n",
     "benchmark b { cycles 300; objects { size 40; quantity 2; location stack } }\n"},
    {Lint::kInternalEdges,
     "benchmark b {\n  timestep 1 / 240\n  cycles 240\n  world { walls none; side 50 }\n"
     "  objects bunny {\n    quantity 1; type bunny; size 1; location at(0, 1, 0)\n"
     "    linear_velocity (3, 0, 0)\n  }\n"
     "  objects ground {\n    quantity 1; type surface(\"level.obj\"); size 20; mass fixed\n"
     "    location at(0, 0, 0)\n  }\n}\n",
     "benchmark b {\n  timestep 1 / 240\n  cycles 240\n  world { walls none; side 50 }\n"
     "  objects bunny {\n    quantity 1; type bunny; size 1; location at(0, 1, 0)\n"
     "    linear_velocity (3, 0, 0)\n  }\n"
     "  objects ground {\n    quantity 1; type surface(\"level.obj\"); size 20; mass fixed\n"
     "    location at(0, 0, 0); edges smooth\n  }\n}\n"},
    {Lint::kForeseenBounce,
     "benchmark b {\n  world.side 20\n  contact faithful\n"
     "  objects { quantity 1; size 0.3; location at(0, 0, 0); restitution 1; ccd on }\n}\n",
     "benchmark b {\n  world.side 20\n  contact faithful\n  timestep 1 / 240\n"
     "  objects { quantity 1; size 0.3; location at(0, 0, 0); restitution 1; ccd on }\n}\n"},
    {Lint::kLossyBounce,
     "benchmark b {\n  world.side 20\n"
     "  objects { quantity 1; size 1; location at(0, 0, 0); restitution 1 }\n}\n",
     "benchmark b {\n  world.side 20\n  contact faithful\n"
     "  objects { quantity 1; size 1; location at(0, 0, 0); restitution 1 }\n}\n"},
    {Lint::kLongChain,
     "benchmark b {\n  world { side 100; walls none }\n  cycles 200\n"
     "  objects { quantity 50; type cuboid; size 1; location line; links.type ball }\n}\n",
     "benchmark b {\n  world { side 100; walls none }\n  cycles 200\n  timestep 1 / 480\n"
     "  objects { quantity 50; type cuboid; size 1; location line; links.type ball }\n}\n"},
    {Lint::kSwingingJoint,
     "benchmark b {\n  world { side 100; walls none }\n  objects {\n"
     "    quantity 4; type cuboid; size 1; location line(along: (1, 0, 0)); links.type ball\n  "
     "}\n}\n",
     "benchmark b {\n  world { side 100; walls none }\n  timestep 1 / 960\n  objects {\n"
     "    quantity 4; type cuboid; size 1; location line(along: (1, 0, 0)); links.type ball\n  "
     "}\n}\n"},
    {Lint::kCrush,
     "benchmark b {\n  cycles 180\n  world { side 20; walls floor }\n"
     "  objects ball { quantity 1; size 1; location at(0, -9.4, 0) }\n  objects press {\n"
     "    quantity 1; type cuboid; size 4; mass kinematic; location at(0, -6.8, 0)\n"
     "    linear_velocity (0, -1, 0)\n  }\n}\n",
     "benchmark b {\n  cycles 180\n  world { side 20; walls floor }\n"
     "  objects ball { quantity 1; size 1; location at(0, -9.4, 0) }\n  objects press {\n"
     "    quantity 1; type cuboid; size 4; mass kinematic; location at(0, -6.8, 0)\n"
     "    linear_velocity (0, -0.02, 0)\n  }\n}\n"},
    {Lint::kCreep,
     "benchmark b {\n  world.side 0.1\n  timestep 1 / 3840\n  cycles 7680\n"
     "  objects { quantity 1; type cuboid; size 0.002; location stack }\n}\n",
     "benchmark b {\n  world.side 0.1\n  timestep 1 / 3840\n  cycles 7680\n"
     "  precision double\n"
     "  objects { quantity 1; type cuboid; size 0.002; location stack }\n}\n"},
    {Lint::kRollingGain,
     "benchmark b {\n  world { side 40; walls floor }\n  cycles 300\n"
     "  objects {\n    quantity 1; type cylinder; size 1; orientation (pi / 2, 0, 0)\n"
     "    location at(0, -19.5, 0); linear_velocity (1, 0, 0); angular_velocity (0, 0, -2)\n  "
     "}\n}\n",
     "benchmark b {\n  world { side 40; walls floor }\n  cycles 300\n"
     "  objects {\n    quantity 1; type sphere; size 1\n"
     "    location at(0, -19.5, 0); linear_velocity (1, 0, 0); angular_velocity (0, 0, -2)\n  "
     "}\n}\n"},
    {Lint::kLeaningStack,
     "benchmark b {\n  timestep 1 / 240\n  acceleration (0.6, -9.8, 0)\n  expect rest\n"
     "  objects { quantity 5; type cuboid; size 0.2; location stack }\n}\n",
     "benchmark b {\n  timestep 1 / 960\n  cycles 1000\n  acceleration (0.2, -9.8, 0)\n  expect "
     "rest\n"
     "  objects { quantity 5; type cuboid; size 0.2; location stack }\n}\n"},
    {Lint::kSlidingBox,
     "benchmark b {\n  timestep 1 / 240\n  cycles 720\n  world { side 40; walls floor }\n"
     "  objects {\n    quantity 1; type cuboid; size 0.5; friction 0.4\n"
     "    location at(-10, -19.75, 0); linear_velocity (5, 0, 0)\n  }\n}\n",
     "benchmark b {\n  timestep 1 / 240\n  cycles 720\n  world { side 40; walls floor; wall_shape "
     "box }\n"
     "  objects {\n    quantity 1; type cuboid; size 0.5; friction 0.4\n"
     "    location at(-10, -19.75, 0); linear_velocity (5, 0, 0)\n  }\n}\n"},
    {Lint::kTumblingTree,
     "benchmark b {\n  coordinates reduced\n  sleeping off\n  acceleration 0\n  cycles 240\n  "
     "world { side 10; walls none }\n"
     "  objects a { quantity 1; type cuboid; size 0.2; location at(0, 0, 0)\n"
     "    angular_velocity (1, 4, 2) }\n"
     "  objects b { quantity 1; type cuboid; size 0.2; location at(0, 0.4, 0)\n"
     "    angular_velocity (1, 4, 2) }\n"
     "  joints { parent a; child b; at (0, 0.2, 0) }\n}\n",
     "benchmark b {\n  coordinates reduced\n  sleeping off\n  acceleration 0\n  timestep 1 / "
     "3840\n  cycles 1920\n  world { side 10; walls none }\n"
     "  objects a { quantity 1; type cuboid; size 0.2; location at(0, 0, 0)\n"
     "    angular_velocity (1, 4, 2) }\n"
     "  objects b { quantity 1; type cuboid; size 0.2; location at(0, 0.4, 0)\n"
     "    angular_velocity (1, 4, 2) }\n"
     "  joints { parent a; child b; at (0, 0.2, 0) }\n}\n"},
};

/// The text of a lint in the table, and its limit.
std::string LintText(const lints::LintInfo& info) {
  return fmt::format(
      "{} if a number of the scene is beyond its limit. The number: {}. The limit: {}.",
      fmt::format(fmt::runtime(info.predicts), "may"), info.number, info.threshold);
}

std::vector<Explanation> MakeRows() {
  static std::deque<std::string> texts;  // owns the texts to which the rows refer
  std::vector<Explanation> rows;
  for (const LintExample& example : kExamples) {
    const lints::LintInfo& info = lints::InfoOf(example.lint);
    rows.push_back({&info.kind, texts.emplace_back(LintText(info)), example.wrong, example.right});
  }
  return rows;
}

}  // namespace

std::span<const Explanation> LintExplanations() {
  static const std::vector<Explanation> rows = MakeRows();
  return rows;
}

// Explanations of the kinds in compiler/scenario/diagnostic_kinds.h.

namespace {

constexpr Explanation kScenarioRows[] = {
    {&scenario::kUnknownName,
     "A name is unknown here: no parameter, block, word, let or benchmark has this name. `cdb doc "
     "parameters` and `cdb list` print all names.",
     "benchmark b { detector spa }\n", "benchmark b { detector sap }\n"},
    {&scenario::kWrongPlace,
     "The name is known, but not allowed here: a property of objects belongs in objects { }, a "
     "property of the run outside of it.",
     "benchmark b { size 5 }\n", "benchmark b { objects { size 5 } }\n"},
    {&scenario::kReservedName,
     "An axis becomes a variable of the results, and cannot have the name of another variable, "
     "such as cycle or phase.",
     "benchmark b { timestep sweep(1 / 60, 1 / 120) as cycle }\n",
     "benchmark b { timestep sweep(1 / 60, 1 / 120) as step_size }\n"},
    {&scenario::kSetTwice,
     "A block can set each parameter only once, and a file can define each name only once.",
     "benchmark b {\n  cycles 5\n  cycles 6\n}\n", "benchmark b {\n  cycles 6\n}\n"},
    {&scenario::kWrongKind,
     "The value is of another kind than the parameter takes: a number instead of a vector, a text "
     "instead of a word, a distribution instead of a constant. `cdb doc NAME` states the kinds "
     "that a parameter takes.",
     "benchmark b { acceleration 5 }\n", "benchmark b { acceleration (0, -5, 0) }\n"},
    {&scenario::kOutOfDomain, "The number is outside the domain of the parameter.",
     "benchmark b { cycles 0 }\n", "benchmark b { cycles 1000 }\n"},
    {&scenario::kNotFinite,
     "The arithmetic has no finite result: a division by zero, or a number too large for a double.",
     "benchmark b { cycles 1 / 0 }\n", "benchmark b { cycles 1000 / 2 }\n"},
    {&scenario::kBadArguments,
     "The arguments do not fit the word: too many, too few, unknown names, or values that exclude "
     "each other. The values of an axis must be distinct.",
     "benchmark b { objects.mass uniform(5) }\n", "benchmark b { objects.mass uniform(5, 10) }\n"},
    {&scenario::kBadRange, "The range is empty or never ends, or its count is not a whole number.",
     "benchmark b { cycles sweep(5 .. 1) }\n", "benchmark b { cycles sweep(5 .. 1 step -1) }\n"},
    {&scenario::kMisplacedSweep,
     "A sweep makes an axis, and is not allowed here: inside another sweep, in a condition, or for "
     "a setting that all runs share.",
     "benchmark b { repeats sweep(1, 3) }\n", "benchmark b { repeats 3 }\n"},
    {&scenario::kMisplacedRange, "A range is a list of values, and belongs in a sweep.",
     "benchmark b { cycles 1 .. 5 }\n", "benchmark b { cycles sweep(1 .. 5) }\n"},
    {&scenario::kAxisTwice,
     "Two sweeps would make axes with the same name. Rename one with `as`, or use one let for "
     "both.",
     "benchmark b { objects.friction normal(sweep(0.5, 0.6), sweep(0.1, 0.2)) }\n",
     "benchmark b { objects.friction normal(sweep(0.5, 0.6), sweep(0.1, 0.2) as deviation) }\n"},
    {&scenario::kCircular,
     "A let, a benchmark or a file refers to itself, directly or through others.",
     "let a = b\nlet b = a\nbenchmark c { cycles 5 }\n",
     "let a = b\nlet b = 5\nbenchmark c { cycles a }\n"},
    {&scenario::kNoSuchFile,
     "The file cannot be read. Its name is relative to the folder of the .cdb file; scenarios are "
     "also found in cdb's library.",
     "use \"no_such_file\"\nbenchmark b { }\n", "benchmark b { }\n"},
    {&scenario::kTooManyRuns,
     "The sweeps make more runs than a plan can hold, or a range has more values than an axis can "
     "hold. Sweep fewer values, or split the benchmark.",
     "benchmark b { seed sweep(1 .. 1e9) }\n", "benchmark b { seed sweep(1 .. 100) }\n"},
    {&scenario::kNoRuns,
     "Nothing is left to run: the file has no benchmark, or every point is skipped.",
     "benchmark b { skip when cycles > 1 }\n",
     "benchmark b { cycles sweep(10, 100); seed sweep(1, 50); skip when cycles < seed }\n"},
    {&scenario::kCapacity, "The detector or the layout cannot handle that many objects.",
     "benchmark b { objects.quantity 20000; detector sap }\n",
     "benchmark b { objects.quantity 20000; detector sap32 }\n"},
    {&scenario::kUnavailable,
     "The scenario names something that is not part of this build, or a file that is not a plug-in "
     "with detectors. `cdb list detectors` names the package of each detector.",
     "use detector \"wrong.cdb\"\nbenchmark b { }\n", "benchmark b { detector dbvt }\n"},
    {&scenario::kBadComparison,
     "The two sides cannot be compared: < compares numbers; == and != compare words.",
     "benchmark b { cycles sweep(1, 2); detector sweep(sap, dbvt); skip when cycles < detector }\n",
     "benchmark b { cycles sweep(1, 2); seed sweep(1, 2); skip when cycles < seed }\n"},
    {&scenario::kContradiction, "Two settings exclude each other.",
     "benchmark b { accuracy { interval 1 } }\n",
     "benchmark b { accuracy { metrics energy; interval 1 } }\n"},
    {&scenario::kNeeded,
     "The scene needs a part that `omit` names. `omit auto` omits every part that it does not "
     "need.",
     "benchmark b { omit gravity }\n", "benchmark b { omit auto }\n"},
    {&scenario::kWrongForm,
     "The closed form does not describe this scene, so the scene cannot be compared with it.",
     "benchmark b { accuracy { metrics position; closed_form flight } }\n",
     "benchmark b {\n  world { walls none; side 1000 }\n  sleeping off\n"
     "  objects { quantity 1; size 10; location at(0, 0, 0); linear_velocity (1, 0, 0) }\n"
     "  acceleration 0\n  accuracy { metrics position; closed_form flight }\n}\n"},
    {&scenario::kCannotPlace,
     "The objects cannot be placed: they lie outside of the cube, overlap, or fill too much of it.",
     "benchmark b { world.side 100; objects { quantity 1000; size 20 } }\n",
     "benchmark b { world.side 1000; objects { quantity 1000; size 20 } }\n"},
    {&scenario::kWrongUnit,
     "The unit of a value has another dimension than the parameter, for example a mass instead of "
     "a length, or numbers with and without a unit are added.",
     "benchmark b { objects.size 5 kg }\n", "benchmark b { objects.size 5 m }\n"},
    {&scenario::kBadTable,
     "A table of measured values has an invalid row: each row is a number, or a number, a comma "
     "and its weight. The numbers have no unit, and are in the unit of the parameter; here "
     "masses.csv has `2.5 kg`.",
     "benchmark b { objects.mass empirical(\"masses.csv\") }\n",
     "benchmark b { objects.mass any(1.5, 2.5) }\n"},
    {&scenario::kRunsWillFail, "Some of the runs cannot be placed; the others can.",
     "benchmark b { world.side 1000; objects { size 200; quantity sweep(1, 2, 500) } }\n",
     "benchmark b { world.side 5000; objects { size 200; quantity sweep(1, 2, 500) } }\n"},
    {&scenario::kUnreachable,
     "No run uses this: every point with this value or case is skipped, every case overrides the "
     "setting, or nothing uses the sweep.",
     "benchmark b {\n  detector sweep(sap, dbvt, simple)\n  skip when detector == simple\n}\n",
     "benchmark b { detector sweep(sap, dbvt) }\n"},
    {&scenario::kEllipsoids,
     "Each side of an object is drawn separately, so that spheres with a drawn size become "
     "ellipsoids. same( ) makes one draw for all three sides.",
     "benchmark b { objects { type sphere; size uniform(10, 50) } }\n",
     "benchmark b { objects { type sphere; size same(uniform(10, 50)) } }\n"},
    {&scenario::kNoEffect,
     "A setting has no effect in any run: a velocity of fixed objects, kinematic objects without "
     "velocity or path, the expected behaviour of a driven scene.",
     "benchmark b { objects { mass fixed; linear_velocity (0, 1, 0) } }\n",
     "benchmark b { objects { mass kinematic; linear_velocity (0, 1, 0) } }\n"},
    {&scenario::kPoorFit,
     "The convex hulls of a mesh do not fit it: their common volume is less than 80 % of that of "
     "their union. Objects touch hulls where the mesh is hollow. Thin curved walls need many "
     "hulls; "
     "`surface` keeps the triangles of a mesh that does not move.",
     "benchmark b { objects.type mesh(\"wheel.stl\") }\n",
     "benchmark b { objects.type mesh(\"wheel.stl\", hulls: 200) }\n"},
    {&scenario::kLargeAngle,
     "An orientation, an axis times an angle in rad, turns by more than a full turn, or the limits "
     "of a joint are multiples of 5 rad, and some turns apart. Angles in degrees need a unit.",
     "benchmark b { objects.orientation (0, 90, 0) }\n",
     "benchmark b { objects.orientation (0, 90, 0) deg }\n"},
    {&scenario::kOddInertia,
     "The stated inertia of a compound is that of a body ten times as large as its parts, or of a "
     "tenth. Its parts may be in mm, its inertia in g cm^2, or 1 kg m^2 may stand for an unknown "
     "one. Without `inertia`, it is that of the parts.",
     "benchmark b {\n  objects {\n    size native\n"
     "    type compound(part(cuboid, (10, 20, 10)), inertia: (9000, 9000, 9000))\n  }\n}\n",
     "benchmark b {\n  objects {\n    size native\n"
     "    type compound(part(cuboid, (10, 20, 10)))\n  }\n}\n"},
    {&scenario::kDefaultSize,
     "A group has the default size, and all other groups are much smaller or larger. This may be "
     "an oversight: set the size.",
     "benchmark b {\n  world.side 100\n  objects pebbles { quantity 5; size 1 }\n"
     "  objects plate { quantity 1; type cuboid }\n}\n",
     "benchmark b {\n  world.side 100\n  objects pebbles { quantity 5; size 1 }\n"
     "  objects plate { quantity 1; type cuboid; size 2 }\n}\n"},
};

}  // namespace

std::span<const Explanation> ScenarioExplanations() { return kScenarioRows; }

}  // namespace cdb::manual
