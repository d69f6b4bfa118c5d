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
    {"from", kModifier, "benchmark NAME from BASE { … }",
     "extends a benchmark: takes the statements of the base and overrides them",
     "benchmark mine from paper_experiment2 { detector dbvt }"},
    {"when", kModifier, "skip when CONDITION", "begins the condition of a skip",
     "skip when quantity > 3000"},
    {"sweep", kFunction, "sweep(VALUE, …), sweep(A .. B [step D | count N [log]]) [as NAME]",
     "an axis: one run for each value; two sweeps make the grid of both",
     "detector sweep(simple, sap, dbvt)"},
    {"as", kModifier, "sweep(…) as NAME",
     "names an axis, which is otherwise named after its parameter", "cycles sweep(1 .. 5) as n"},
    {"step", kModifier, "sweep(A .. B step D)",
     "the difference between the values of a range; without it, a range counts by one",
     "cycles sweep(100 .. 500 step 100)"},
    {"count", kModifier, "sweep(A .. B count N)",
     "the number of values of a range, both ends included", "objects.size sweep(1 .. 2 count 5)"},
    {"log", kModifier, "sweep(A .. B count N log)",
     "the values of a range grow by a factor instead of a difference",
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
    {"and", kModifier, "CONDITION and CONDITION", "both conditions hold; binds closer than or",
     "skip when quantity > 3000 and detector == simple"},
    {"or", kModifier, "CONDITION or CONDITION", "one of the conditions holds, or both",
     "skip when quantity > 3000 or detector == simple"},
    {"not", kModifier, "not CONDITION", "the opposite of all that follows it in its brackets",
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
