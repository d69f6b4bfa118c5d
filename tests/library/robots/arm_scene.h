// Scenes of configurations, from texts; an arm of balls among fixed solids.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>

#include "tests/support/compile_text.h"

namespace cdb::tests {

/// The scene of the only run of a scenario.
inline plan::Scene SceneOfText(const std::string& text,
                               std::map<std::string, std::string> files = {}) {
  const compiler::Compilation compiled = CompileText(text, std::move(files));
  EXPECT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  return compiled.plans.at(0).runs.at(0).scene;
}

/// Seven hinges about turning axes and, if asked for, a slider; links of nine balls each, which
/// collide unless they are neighbours. 20 obstacles.
inline std::string BallArm(const std::string& settings, bool has_slider = false,
                           bool only_boxes = false) {
  const bool is_path = settings.find("positions path") != settings.npos;
  std::string text =
      "benchmark b {\n  configurations.ask hit" +
      std::string(is_path ? "" : "; configurations.positions uniform") + "\n" + settings +
      "\n  objects base { type cuboid; size 0.2; mass fixed; location at(0.1, 0, 0) }\n";
  std::string parent = "base";
  for (int link = 0; link < 7; ++link) {
    std::string parts;
    for (int ball = 0; ball < 9; ++ball)
      parts +=
          fmt::format("{}part(sphere, ({:.2f}, {:.2f}, {:.2f}), at: ({:.3f}, {:.3f}, 0.01))",
                      ball == 0 ? "" : ", ", 0.09, 0.09, 0.09, 0.002 * ball, 0.01 + 0.02 * ball);
    text += fmt::format(
        "  objects link{0} {{ type compound({1}); size native; overlap on; mass 1\n"
        "    location relative_to({2}, (0.01, 0.19, 0)); orientation ({3}, 0.2, 0) }}\n"
        "  joints joint{0} {{ parent {2}; child link{0}; at (0.01, 0.19, 0); axis {4}\n"
        "    limits {{ lower -2.5; upper 2.5 }} }}\n",
        link, parts, parent, link % 2 == 0 ? "0.3" : "-0.4",
        link % 3 == 0   ? "(0, 1, 0)"
        : link % 3 == 1 ? "(0, 0.1, 1)"
                        : "(1, 0, 0.2)");
    parent = fmt::format("link{}", link);
  }
  if (has_slider)
    text +=
        "  objects hand { type sphere; size 0.1; overlap on\n"
        "    location relative_to(link6, (0, 0.2, 0)) }\n"
        "  joints slide { parent link6; child hand; type slider; axis (0, 1, 0)\n"
        "    limits { lower 0; upper 0.3 } }\n";
  text += fmt::format(
      "  objects bins {{ quantity {}; type cuboid; size uniform(0.05, 0.4); mass fixed\n"
      "    location uniform; region box((-1.2, -0.8, -1.2), (1.2, 1.4, 1.2)); orientation random\n"
      "    overlap on }}\n",
      only_boxes ? 20 : 12);
  if (!only_boxes)
    text +=
        "  objects rods { quantity 4; type any(capsule, cylinder); aspect 1 : 3 : 1; size 0.1\n"
        "    mass fixed; location uniform; region box((-1, -0.6, -1), (1, 1, 1)); overlap on\n"
        "    orientation random }\n"
        "  objects balls { quantity 4; type sphere; size 0.2; mass fixed; location uniform\n"
        "    region box((-1, -0.6, -1), (1, 1, 1)); overlap on }\n";
  return text + "  world.side 4\n}\n";
}

}  // namespace cdb::tests
