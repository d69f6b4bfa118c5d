// Habits from URDF, MJCF, SDF, YAML, Hydra and Python: the help of each diagnostic has the words to
// write instead, and with these words the statement compiles.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

struct Habit {
  std::string_view wrong;
  std::string_view remedy;  ///< in the help of a diagnostic
  std::string_view right;
};
constexpr Habit kHabits[] = {
    // Lists and ranges.
    {"detector [sap, dbvt]", "sweep(sap, dbvt)", "detector sweep(sap, dbvt)"},
    {"detector (sap, dbvt)", "sweep(sap, dbvt)", "detector sweep(sap, dbvt)"},
    {"detector sap, dbvt", "sweep(", "detector sweep(sap, dbvt)"},
    {"solver { iterations [10, 20] }", "sweep(10, 20)", "solver { iterations sweep(10, 20) }"},
    {"objects.size sweep([1, 2, 3])", "1, 2, 3 without", "objects.size sweep(1, 2, 3)"},
    {"objects.linear_velocity [1, 2, 3]", "(1, 2, 3)", "objects.linear_velocity (1, 2, 3)"},
    {"objects.quantity 100 to 1000", "sweep(100 .. 1000)", "objects.quantity sweep(100 .. 1000)"},
    {"objects.quantity sweep(100..1000, 100)", "sweep(100..1000 step 100)",
     "objects.quantity sweep(100..1000 step 100)"},
    {"objects.quantity range(100, 1000, 100)", "sweep(100 .. 1000 step 100)",
     "objects.quantity sweep(100 .. 1000 step 100)"},
    {"objects.quantity range(1, 5)", "sweep(1 .. 5)", "objects.quantity sweep(1 .. 5)"},
    {"objects.size linspace(1, 10, 5)", "sweep(1 .. 10 count 5)",
     "objects.size sweep(1 .. 10 count 5)"},
    {"objects.size geomspace(1, 100, 3)", "sweep(1 .. 100 count 3 log)",
     "objects.size sweep(1 .. 100 count 3 log)"},
    {"objects.size logspace(0, 2, 3)", "sweep(10 ^ 0 .. 10 ^ 2 count 3 log)",
     "objects.size sweep(10 ^ 0 .. 10 ^ 2 count 3 log)"},
    {"objects.size sweep(1 .. 3 by 1)", "step", "objects.size sweep(1 .. 3 step 1)"},
    {"seed 1..5", "sweep(", "seed sweep(1 .. 5)"},
    // Signs and quotes.
    {"objects { size: 5 }", "size 5", "objects { size 5 }"},
    {"objects { size = 5 }", "size 5", "objects { size 5 }"},
    {"timestep = 1/60", "timestep 1/60", "timestep 1/60"},
    {"n = 100", "let n = 100", "let n = 100; objects.quantity n"},
    {"let n = 100, m = 5", "let m = ", "let n = 100; let m = 5; objects.quantity n * m"},
    {"objects.size normal(5, sd = 1)", "sd: 1", "objects.size normal(5, sd: 1)"},
    {"objects.type \"sphere\"", "sphere without quotes", "objects.type sphere"},
    {"objects.type 'sphere'", "without quotes", "objects.type sphere"},
    {"objects { type mesh(plate.obj) }", "\"plate.obj\"", "objects { type mesh(\"plate.obj\") }"},
    {"objects { type \"plate.obj\" }", "mesh(\"plate.obj\")",
     "objects { type mesh(\"plate.obj\") }"},
    {"// a comment", "#", "# a comment\ncycles 5"},
    {"objects.size .5", "0.5", "objects.size 0.5"},
    // Units.
    {"let hz = 60; timestep 1/hz s", "(1/hz) s", "let hz = 60; timestep (1/hz) s"},
    {"timestep 60 Hz", "1/60 s", "timestep 1/60 s"},
    {"objects.size 5cm", "5 cm", "objects.size 5 cm"},
    {"objects { size same(uniform(1, 5)) cm }", "same(uniform(1, 5) cm)",
     "objects { size same(uniform(1, 5) cm) }"},
    {"objects { orientation (0, 90, 0) }", "(0, 90, 0) deg",
     "objects { orientation (0, 90, 0) deg }"},
    // Values of another kind.
    {"objects { location (0, 1, 0) }", "at(0, 1, 0)", "objects { location at(0, 1, 0) }"},
    {"objects { aspect (1, 2, 3) }", "1 : 2 : 3", "objects { aspect 1 : 2 : 3 }"},
    {"objects { size (2, 4, 6) }", "size 2; aspect 1 : 2 : 3",
     "objects { size 2; aspect 1 : 2 : 3 }"},
    {"objects { mass 0 }", "mass fixed", "objects { mass fixed }"},
    {"objects { mass static }", "fixed", "objects { mass fixed }"},
    {"objects { mass infinite }", "fixed", "objects { mass fixed }"},
    {"objects { linear_velocity 5 }", "(0, 5, 0)", "objects { linear_velocity (0, 5, 0) }"},
    {"sleeping 1", "on", "sleeping on"},
    {"sleeping yes", "on", "sleeping on"},
    {"precision float64", "double", "precision double"},
    {"objects.type box", "cuboid", "objects.type cuboid"},
    {"objects.type ball", "sphere", "objects.type sphere"},
    {"objects.size gauss(5, 1)", "normal", "objects.size normal(5, 1)"},
    {"objects.size random(1, 5)", "uniform", "objects.size uniform(1, 5)"},
    {"objects.size choice(1, 5)", "any", "objects.size any(1, 5)"},
    // Names.
    {"iterations 20", "solver.iterations", "solver.iterations 20"},
    {"repeat 5", "repeats 5", "repeats 5"},
    {"steps 300", "cycles", "cycles 300"},
    {"dt 0.01", "timestep", "timestep 0.01"},
    {"gravity (0, -9.81, 0)", "acceleration", "acceleration (0, -9.81, 0)"},
    {"broadphase sap", "detector", "detector sap"},
    {"walls none", "world.walls", "world.walls none"},
    {"quantity 5", "objects.quantity", "objects.quantity 5"},
    {"objects { count 5 }", "quantity", "objects { quantity 5 }"},
    {"objects { shape sphere }", "type", "objects { type sphere }"},
    {"objects { radius 1 }", "size", "objects { size 1 }"},
    {"objects { density 1000 }", "density( )", "objects { mass density(1000) }"},
    {"objects { position at(0, 1, 0) }", "location", "objects { location at(0, 1, 0) }"},
    {"objects { pose at(0, 1, 0) }", "location", "objects { location at(0, 1, 0) }"},
    {"objects { rpy (0, 0, 1) }", "orientation", "objects { orientation (0, 0, 1) }"},
    {"objects { euler (0, 0, 1) }", "orientation", "objects { orientation (0, 0, 1) }"},
    {"objects { velocity (0, 1, 0) }", "linear_velocity", "objects { linear_velocity (0, 1, 0) }"},
    {"objects { joint hinge }", "links.type", "objects { links.type hinge }"},
    {"objects { mesh \"plate.obj\" }", "type", "objects { type mesh(\"plate.obj\") }"},
    // Blocks and statements.
    {"objects { quantity 5 } objects { quantity 6 }", "objects a { … } objects b { … }",
     "objects a { quantity 5 } objects b { quantity 6 }"},
    {"for n in (1, 2) { objects.size n }", "sweep(", "let n = sweep(1, 2); objects.size n"},
    {"if detector == sap { timestep 1/60 }", "skip when", "skip when detector == sap"},
};

std::string Helps(const dsl::Diagnostics& diagnostics) {
  std::string helps;
  for (const dsl::Diagnostic& one : diagnostics.all()) helps += one.help + "\n";
  return helps;
}

TEST(Habits, HaveRemediesThatCompile) {
  const auto compile = [](std::string_view statement) {
    return CompileText("benchmark b {\n" + std::string(statement) + "\n}",
                       {{"plate.obj", "v 0 0 0"}});
  };
  for (const Habit& habit : kHabits) {
    const auto wrong = compile(habit.wrong);
    EXPECT_FALSE(wrong.diagnostics.all().empty()) << habit.wrong;
    EXPECT_NE(Helps(wrong.diagnostics).find(habit.remedy), std::string::npos)
        << habit.wrong << "\n"
        << dsl::Render(wrong.diagnostics);
    const auto right = compile(habit.right);
    EXPECT_FALSE(right.diagnostics.has_errors()) << habit.right << "\n"
                                                 << dsl::Render(right.diagnostics);
  }
}

}  // namespace
}  // namespace cdb::tests
