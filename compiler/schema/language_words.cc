#include "compiler/schema/language_words.h"

#include <algorithm>

namespace cdb::schema {
namespace {

using enum WordRole;

constexpr LanguageWord kLanguageWords[] = {
    {"benchmark", kStatement, "benchmark NAME [from BASE] [\"TITLE\"] { … }",
     "defines a benchmark, which yields one results file",
     "benchmark rain \"Rain in a walled cube\" { cycles 300 }"},
    {"use", kStatement, "use \"FILE\", use detector \"LIBRARY.so\"",
     "imports the lets and benchmarks of another file, or the detectors of a shared library",
     "use \"paper/experiment2\""},
    {"let", kStatement, "let NAME = VALUE",
     "names a value; if the value is a sweep, every use of the name is the same axis",
     "let n = sweep(10, 100)"},
    {"cases", kStatement, "cases [NAME] { CASE { … } CASE { … } }",
     "an axis of named sets of settings, which override the other settings; without a name, the "
     "axis is called `case`",
     "cases load { calm { cycles 100 } storm { cycles 200 } }"},
    {"skip", kStatement, "skip when CONDITION",
     "skips points of the grid, which remain as cells of the results",
     "skip when quantity > 3000 and detector == simple"},
    {"objects", kStatement, "objects [NAME] { … }",
     "a group of objects; if there are several groups, they have names",
     "objects pebbles { quantity 100; size 5 }"},
    {"joints", kStatement, "joints [NAME] { … }",
     "joints between the objects of two groups; if there are several, they have names",
     "joints axle { parent objects; child world; type hinge; axis (0, 1, 0) }"},
    {"queries", kStatement, "queries [NAME] { … }",
     "rays, or shapes, for which bodies are found in each cycle; if there are several, they have "
     "names",
     "queries sight { type ray; count 1000; from (0, 5, 0); length 100; hits closest }"},
    {"robot", kStatement, "robot NAME { file \"FILE\"; … }",
     "a robot from a URDF, SDF or MJCF file: a group of objects for each link, and a joint for "
     "each joint",
     "robot arm { file \"arm.urdf\"; base fixed; location at(0, 0, 0) }"},
    {"only", kStatement, "only when CONDITION",
     "keeps these points of the grid and skips all others",
     "only when quantity in (10, 100) or detector == dbvt"},
    {"require", kStatement, "require FIGURE < VALUE",
     "requires a figure of the results, at each point: exit status 5 if one is not met; figures "
     "are "
     "verdict, p99(PHASE), max(SERIES), error(NAME) and facts of a run such as peak_rss",
     "require p99(step) < 4 ms and verdict == stable"},
    {"from", kModifier, "benchmark NAME from BASE { … }",
     "extends a benchmark: takes the statements of the base and overrides them",
     "benchmark mine from paper_experiment2 { detector dbvt }"},
    {"when", kModifier, "skip when CONDITION, only when CONDITION", "begins a condition",
     "skip when quantity > 3000"},
    {"sweep", kFunction,
     "sweep(VALUE, …), sweep(A .. B [step D | count N [log]]) [as [NAME] [\"TITLE\"]]",
     "an axis: one run for each value; two sweeps make the grid of both",
     "detector sweep(simple, sap, dbvt)"},
    {"zip", kFunction, "let A, B = zip(sweep(…), sweep(…)) [as [NAME] [\"TITLE\"]]",
     "sweeps of equal length that change together: one axis for several values",
     "let n, side = zip(sweep(10, 100), sweep(500, 5000))"},
    {"find", kFunction,
     "find(A .. B [log], [tolerance: T], until: FIGURE < VALUE) [as [NAME] [\"TITLE\"]]",
     "searches for the first value from A on at which a condition on the results holds, for each "
     "point "
     "of the other axes; runs only the values that the search needs",
     "objects.mass find(1 .. 1e5 log, until: verdict != stable)"},
    {"race", kFunction, "race(VALUE, …, [by: TIME], [tolerance: T]) [as [NAME] [\"TITLE\"]]",
     "finds the fastest of its values, for each point of the other axes: values that are surely "
     "slower get no more repeats",
     "detector race(sap, dbvt, grid, auto)"},
    {"by", kModifier, "race(VALUE, …, by: TIME)",
     "the time by which a race is decided, a statistic as in require; without it, mean(step)",
     "detector race(sap, dbvt, grid, by: median(detect))"},
    {"until", kModifier, "find(A .. B, until: FIGURE < VALUE)",
     "the condition of a search, on a figure as in require",
     "objects.quantity find(100 .. 5000, until: mean(step) > 4 ms)"},
    {"tolerance", kModifier,
     "find(A .. B, tolerance: T, until: FIGURE < VALUE), race(VALUE, …, tolerance: T)",
     "how well a search knows its boundary: a part of the range, or of the value if the range is "
     "logarithmic; without it, 5 %. In a race, the part by which times may differ that need not be "
     "told apart; without it, 1 %",
     "objects.size find(0.1 .. 10 log, tolerance: 1 %, until: verdict != stable)"},
    {"as", kModifier, "sweep(…) as NAME, sweep(…) as \"TITLE\", sweep(…) as NAME \"TITLE\"",
     "names an axis, which is otherwise named after its parameter; gives it a title for figures",
     "cycles sweep(1 .. 5) as n \"number of cycles\""},
    {"step", kModifier, "sweep(A .. B step D)",
     "the difference between the values of a range; without it, a range counts by one",
     "cycles sweep(100 .. 500 step 100)"},
    {"count", kModifier, "sweep(A .. B count N)",
     "the number of values of a range, both ends included", "objects.size sweep(1 .. 2 count 5)"},
    {"sobol", kModifier, "zip(sweep(A .. B sobol N [log]), …) as NAME",
     "N points that fill the ranges of several values evenly, by Sobol's sequence; a larger N "
     "keeps "
     "them",
     "let mu, bounce = zip(sweep(0 .. 1 sobol 64), sweep(0 .. 1 sobol 64)) as design"},
    {"latin", kModifier, "zip(sweep(A .. B latin N [log]), …) as NAME",
     "N points that fill the ranges of several values evenly, as a Latin hypercube",
     "let mu, bounce = zip(sweep(0 .. 1 latin 64), sweep(0 .. 1 latin 64)) as design"},
    {"log", kModifier, "sweep(A .. B count N log), log(X)",
     "the values of a range grow by a factor instead of a difference; as a function, the natural "
     "logarithm",
     "objects.size sweep(1 .. 100 count 3 log)"},
    {"uniform", kFunction, "uniform(A, B)",
     "drawn for each object, uniform between A and B; vectors component by component",
     "objects.size uniform(1, 5)"},
    {"normal", kFunction, "normal(MEAN, DEVIATION), normal(MEAN, variance: V)",
     "drawn for each object from a normal distribution", "objects.size normal(50, variance: 10)"},
    {"log_uniform", kFunction, "log_uniform(A, B)",
     "drawn for each object, uniform in the logarithm; A, B > 0",
     "objects.mass log_uniform(1, 1000)"},
    {"any", kFunction, "any(VALUE [WEIGHT], …)",
     "drawn for each object: one of the values, with these weights",
     "objects.type any(sphere, cone 3)"},
    {"lognormal", kFunction, "lognormal(MU, SIGMA), lognormal(median: M, sigma: S)",
     "drawn for each object; the natural logarithm is normal with mean MU and standard deviation "
     "SIGMA",
     "objects.size lognormal(median: 10, sigma: 0.5)"},
    {"exponential", kFunction, "exponential(MEAN)",
     "drawn for each object from an exponential distribution", "objects.size exponential(10)"},
    {"gamma", kFunction, "gamma(SHAPE, SCALE)",
     "drawn for each object from a gamma distribution with mean SHAPE * SCALE",
     "objects.size gamma(2, 5)"},
    {"weibull", kFunction, "weibull(SHAPE, SCALE)",
     "drawn for each object from a Weibull distribution", "objects.size weibull(2, 10)"},
    {"empirical", kFunction,
     "empirical(\"FILE\"), empirical(\"FILE\", column: \"HEADING\", weight: \"HEADING\")",
     "drawn for each object: a value of a table, whose lines are `VALUE` or `VALUE, WEIGHT`, or "
     "whose "
     "columns are named",
     "objects.size empirical(\"sizes.csv\")"},
    {"in", kModifier, "VALUE in (A, B), DISTRIBUTION in A .. B",
     "in a condition, tests for one of several values; after a distribution, sets limits: values "
     "outside are drawn again",
     "objects.size normal(5, 1) in 2 .. 8"},
    {"round", kFunction, "round(X)", "the nearest whole number", "cycles round(99.6)"},
    {"floor", kFunction, "floor(X)", "the largest whole number not above X", "cycles floor(99.6)"},
    {"ceil", kFunction, "ceil(X)", "the smallest whole number not below X", "cycles ceil(99.6)"},
    {"abs", kFunction, "abs(X)", "the absolute value", "objects.size abs(-5)"},
    {"min", kFunction, "min(X, Y, …)", "the smallest of the numbers", "objects.size min(5, 7)"},
    {"max", kFunction, "max(X, Y, …)", "the largest of the numbers", "objects.size max(5, 7)"},
    {"sqrt", kFunction, "sqrt(X)", "the square root", "objects.size sqrt(25)"},
    {"sin", kFunction, "sin(X)", "the sine of an angle in rad, or with a unit: sin(30 deg)",
     "objects.size 10 * sin(30 deg)"},
    {"cos", kFunction, "cos(X)", "the cosine of an angle in rad, or with a unit: cos(60 deg)",
     "objects.size 10 * cos(60 deg)"},
    {"exp", kFunction, "exp(X)", "e to the power X", "objects.size exp(2)"},
    {"pi", kConstant, "pi", "3.14159…", "objects.size pi"},
    {"and", kModifier, "CONDITION and CONDITION",
     "both conditions hold; binds more tightly than or",
     "skip when quantity > 3000 and detector == simple"},
    {"or", kModifier, "CONDITION or CONDITION", "at least one of the conditions holds",
     "skip when quantity > 3000 or detector == simple"},
    {"not", kModifier, "not CONDITION", "negates everything that follows it within its brackets",
     "skip when not (quantity > 3000 and detector == simple)"},
    {"on", kConstant, "NAME on", "a switch that is on; also `true`", "sleeping on"},
    {"off", kConstant, "NAME off", "a switch that is off; also `false`", "sleeping off"},
    {"true", kConstant, "NAME true", "a switch that is on; also `on`", "sleeping true"},
    {"false", kConstant, "NAME false", "a switch that is off; also `off`", "sleeping false"},
};

}  // namespace

std::span<const LanguageWord> LanguageWords() { return kLanguageWords; }

const LanguageWord* FindLanguageWord(std::string_view name) {
  const auto found = std::ranges::find(kLanguageWords, name, &LanguageWord::name);
  return found == std::end(kLanguageWords) ? nullptr : found;
}

}  // namespace cdb::schema
