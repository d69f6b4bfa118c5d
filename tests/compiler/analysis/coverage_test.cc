#include "compiler/analysis/coverage.h"

#include <gtest/gtest.h>

#include <set>

#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

analysis::Coverage CoverageOf(const std::string& statements) {
  const compiler::Compilation result =
      CompileText("benchmark b { " + statements + " }", {{"flat.csv", "0,0\n0,0\n"}});
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return analysis::CoverageOf(result.plans.at(0).runs.at(0).scene);
}

TEST(Coverage, NamesWhatTheVerdictAnswersAndWhatItLeavesOpen) {
  struct Case {
    const char *statements, *checked, *unchecked;
  };
  constexpr Case kCases[] = {
      {"objects a { quantity 3 }", "energy, losses, passing, impacts, sleep", ""},
      {"objects a { quantity 3; } sleeping off", "energy, losses, passing, impacts", ""},
      {"objects a { quantity 3; location stack }", "energy, losses, rest, passing, impacts, sleep",
       ""},
      {"objects a { quantity 3; location stack } objects top { quantity 1; location at(0, 4, 0) }",
       "energy, losses, passing, impacts, sleep", "rest: group top is placed by at"},
      {"objects a { quantity 3; location stack; linear_velocity (1, 0, 0) }",
       "energy, losses, passing, impacts, sleep", "rest: group a moves at the start"},
      {"objects a { quantity 3; location stack } acceleration (1, -9, 0)",
       "energy, losses, passing, impacts, sleep", "rest: gravity does not point straight down"},
      {"objects a { quantity 3; location stack } expect rest; acceleration (1, -9, 0)",
       "energy, losses, rest, passing, impacts, sleep", ""},
      {"objects a { quantity 3; location stack } expect anything",
       "energy, passing, impacts, sleep",
       "losses: the scene says expect anything; rest: the scene says expect anything"},
      {"objects a { quantity 3; linear_damping 0.1 }", "energy, passing, impacts, sleep",
       "losses: group a has damping"},
      {"objects a { quantity 3; rolling_friction 0.1 }", "energy, passing, sleep",
       "losses: group a has rolling friction; impacts: only the direction is examined with rolling "
       "or spinning friction, as of group a"},
      {"objects a { quantity 3; spinning_friction 0.1 }", "energy, passing, sleep",
       "losses: group a has spinning friction; impacts: only the direction is examined with "
       "rolling "
       "or spinning friction, as of group a"},
      {"objects a { quantity 3; contact_stiffness 1000 }", "energy, passing, sleep",
       "losses: group a has soft contacts; impacts: group a has soft contacts"},
      {"objects a { quantity 3 } objects blade { quantity 1; mass kinematic }",
       "passing, impacts, sleep",
       "energy: group blade is kinematic; losses: group blade is kinematic"},
      {"objects a { quantity 3; linear_velocity every(60, (0, 1, 0)) }", "passing, sleep",
       "energy: a schedule moves group a; losses: a schedule moves group a; impacts: a schedule "
       "moves "
       "group a"},
      {"objects a { quantity 3 } acceleration every(60, (0, 1, 0))", "passing, impacts, sleep",
       "energy: a schedule changes the acceleration; losses: a schedule changes the acceleration"},
      {"objects a { quantity 3; links { type ball } }", "energy, losses, passing, joints",
       "impacts: only the direction is examined of objects with links or joints, as of group a; "
       "sleep: links may hold the objects of group a, and their forces are not judged"},
      {"objects a { quantity 3 } joints { child a; type ball }", "energy, losses, passing, joints",
       "impacts: only the direction is examined of objects with links or joints, as of group a; "
       "sleep: joints may hold the objects of group a, and their forces are not judged"},
      {"objects a { quantity 3 } joints elbow { child a; damping 1 }", "energy, passing, joints",
       "losses: the joint elbow has damping; impacts: only the direction is examined of objects "
       "with links or joints, as of group a; sleep: joints may hold the objects of group a, and "
       "their forces are not judged"},
      {"objects a { quantity 3 } joints { child a; limits { lower -1; upper 1 } }",
       "energy, passing, joints",
       "losses: the joint has limits; impacts: only the direction is examined of objects with "
       "links or joints, as of group a; sleep: joints may hold the objects of group a, and their "
       "forces are not judged"},
      {"objects a { quantity 1; angular_velocity (0, 9, 0) } joints { child a; type ball }",
       "energy, losses, passing",
       "impacts: only the direction is examined of objects with links or joints, as of group a; "
       "joints: group a spins on a ball joint, and its angular momentum is not examined; sleep: "
       "joints may hold the objects of group a, and their forces are not judged"},
      {"objects a { quantity 3 } joints elbow { child a; motor { velocity 1; effort 2 } }",
       "passing, joints",
       "energy: a motor drives the joint elbow; losses: a motor drives the joint elbow; impacts: "
       "only the direction is examined of objects with links or joints, as of group a; sleep: "
       "joints may hold the objects of group a, and their forces are not judged"},
      {"objects a { quantity 3 } objects b { quantity 0 } joints elbow { parent b; child a; "
       "damping "
       "1 }",
       "energy, losses, passing, impacts, sleep", ""},
      {"objects a { quantity 3 } objects floor { quantity 9; type cuboid; mass fixed }",
       "energy, losses, passing, edges, impacts, sleep", ""},
      {"objects a { quantity 3; type cuboid }", "energy, losses, passing, friction, impacts, sleep",
       ""},
      {"objects a { quantity 3; type cuboid; angular_velocity (0, 1, 0) }",
       "energy, losses, passing, impacts, sleep",
       "friction: group a spins, and how objects turn on a face or a rim is not examined"},
      {"objects a { quantity 3; type cuboid } objects belt { quantity 1; mass kinematic }",
       "passing, impacts, sleep",
       "energy: group belt is kinematic; losses: group belt is kinematic; friction: sliding on "
       "moving ground, such as group belt, is not examined"},
      {"objects a { quantity 3; type any(cuboid, cylinder); linear_damping 0.1 }",
       "energy, passing, impacts, sleep",
       "losses: group a has damping; friction: rolling with damping, as of group a, is not "
       "examined"},
      {"objects a { quantity 3; type superellipsoid; e1 1 }",
       "energy, losses, passing, impacts, sleep",
       "friction: rolling of superellipsoids, as of group a, is not examined"},
      {"objects a { quantity 3; type capsule; rolling_friction 0.1 }", "energy, passing, sleep",
       "losses: group a has rolling friction; friction: rolling with rolling friction, as of group "
       "a, is not examined; impacts: only the direction is examined with rolling or spinning "
       "friction, as of group a"},
      {"objects a { quantity 3; type cuboid } objects belt { quantity 1; mass kinematic } "
       "world.walls "
       "none",
       "passing, impacts, sleep",
       "energy: group belt is kinematic; losses: group belt is kinematic; friction: sliding on "
       "moving ground, such as group belt, is not examined"},
      {"objects a { quantity 3; type cylinder } objects hub { quantity 1; mass fixed }",
       "energy, losses, passing, impacts, sleep",
       "friction: rolling on group hub, which is not of cuboids, is not examined"},
      {"objects a { quantity 3; type capsule } objects slab { quantity 1; type cuboid }",
       "energy, losses, passing, impacts, sleep",
       "friction: rolling on objects that can move, such as those of group slab, is not examined"},
      {"objects a { quantity 3; type any(cuboid, cylinder) }",
       "energy, losses, passing, impacts, sleep",
       "friction: rolling on objects that can move, such as those of group a, is not examined"},
      {"objects a { quantity 1; type any(cuboid, cylinder) }",
       "energy, losses, passing, friction, impacts, sleep", ""},
      {"objects a { quantity 3; links { type spring } }", "energy, losses, passing",
       "impacts: only the direction is examined of objects with links or joints, as of group a; "
       "springs: the motion of group a is not compared with the stiffness of its springs; sleep: "
       "links may hold the objects of group a, and their forces are not judged"},
      {"objects a { quantity 3; type cuboid; friction 0 }",
       "energy, losses, passing, impacts, sleep", ""},
      {"objects a { quantity 3; type cuboid } world.wall_friction 0",
       "energy, losses, passing, impacts, sleep", ""},
      {"objects a { quantity 3; type cuboid } objects ground { quantity 1; size 20; mass fixed\n"
       "type heights(\"flat.csv\"); edges smooth; location at(0, 0, 0) }",
       "energy, losses, passing, edges, sleep",
       "friction: sliding on surfaces, such as group ground, is not examined; impacts: impacts on "
       "surfaces, such as group ground, are not examined"},
      {"objects a { quantity 3 } objects floor { quantity 9; type cuboid; mass kinematic }",
       "passing, impacts, sleep",
       "energy: group floor is kinematic; losses: group floor is kinematic; edges: group floor is "
       "kinematic, and only fixed ground is examined"},
      {"objects a { quantity 3 } objects floor { quantity 1; type cuboid; mass fixed }",
       "energy, losses, passing, impacts, sleep", ""},
      {"objects a { quantity 3 } objects ground { quantity 2; type heights(\"flat.csv\"); mass "
       "fixed }",
       "energy, losses, passing, sleep",
       "edges: seams between surfaces of group ground are not examined; impacts: impacts on "
       "surfaces, such as group ground, are not examined"},
      {"objects a { quantity 3 } objects ground { quantity 1; type heights(\"flat.csv\"); mass "
       "fixed }"
       "objects slab { quantity 1; type cuboid; mass fixed }",
       "energy, losses, passing, sleep",
       "edges: seams between groups ground and slab are not examined; impacts: impacts on "
       "surfaces, such as group ground, are not examined"},
      {"objects a { quantity 3 } objects hill { quantity 2; type cuboid; mass fixed; overlap on }",
       "energy, losses, passing, impacts, sleep",
       "edges: seams between group hill and the walls are not examined"},
      {"objects floor { quantity 2; mass fixed }", "", ""},
      {"objects a { quantity 3; location stack } record timing", "",
       "energy: record lacks stability; losses: record lacks stability; rest: record lacks "
       "stability; passing: record lacks stability; impacts: record lacks stability; sleep: record "
       "lacks stability"},
  };
  for (const Case& row : kCases) {
    const analysis::Coverage coverage = CoverageOf(row.statements);
    EXPECT_EQ(CheckedText(coverage), row.checked) << row.statements;
    EXPECT_EQ(UncheckedText(coverage), row.unchecked) << row.statements;
  }
}

TEST(Coverage, HasOneRowForEachQuestion) {
  std::set<std::string_view> names;
  std::size_t next = 0;
  for (const analysis::QuestionInfo& info : analysis::Questions()) {
    EXPECT_EQ(static_cast<std::size_t>(info.question), next++);
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    // Texts are separated by these.
    EXPECT_EQ(info.name.find_first_of(":;, "), std::string_view::npos) << info.name;
  }
}

}  // namespace
}  // namespace cdb::tests
