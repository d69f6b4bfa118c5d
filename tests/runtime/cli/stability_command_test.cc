// Verdicts in `cdb run`, in `cdb show`, and on the map of `cdb stability`.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/program.h"

namespace cdb::tests {
namespace {

TEST(Verdicts, TimingsThatDoNotCountAreMarked) {
  const Program program;
  // In single precision, adjacent positions near 9e5 m are 1/16 m apart, and the object moves 1/60
  // m a cycle.
  program.Write("far.cdb",
                "benchmark far { cycles 60; acceleration 0; precision sweep(single, double)\n"
                "  world { side 2e6; walls none }\n"
                "  objects { quantity 1; size 1; location at(9e5, 0, 0)\n"
                "    linear_velocity (1, 0, 0) } }");
  const Finished run = program.Run({"run", "far.cdb"});
  EXPECT_EQ(run.status, 3) << run.err;
  EXPECT_NE(run.err.find("precision single: frozen from cycle 0 on: its timings do not count"),
            std::string::npos)
      << run.err;
  const Finished shown = program.Run({"show", "far.h5", "--all"});
  EXPECT_EQ(shown.status, 3);
  EXPECT_NE(shown.out.find("1 did not end well (1 frozen), marked below, and not pooled with "
                           "others in means and ratios:\n"),
            std::string::npos)
      << shown.out;
  EXPECT_NE(shown.out.find("precision single, rep 0: frozen from cycle 0 on"), std::string::npos);
  EXPECT_NE(shown.out.find(
                "  Verdict: 1 of 2 stable (checked: energy, losses, passing, impacts, sleep).\n"),
            std::string::npos);
  const std::size_t row = shown.out.find("\n  single");
  ASSERT_NE(row, std::string::npos) << shown.out;
  const std::string line = shown.out.substr(row + 1, shown.out.find('\n', row + 1) - row - 1);
  EXPECT_TRUE(line.ends_with("  frozen")) << shown.out;
  EXPECT_NE(shown.out.find("\n  double"), std::string::npos) << shown.out;
  const Finished sound = program.Run({"show", "far.h5", "--sound"});
  EXPECT_EQ(sound.status, 3);
  EXPECT_EQ(sound.out.find("\n  single"), std::string::npos) << sound.out;
  EXPECT_NE(sound.out.find("\n  double"), std::string::npos) << sound.out;
  // Shards report it as well.
  EXPECT_EQ(program.Run({"run", "far.cdb", "--fresh", "-q", "--shard", "1/1"}).status, 3);
}

TEST(Verdicts, UnsoundRunsAreNamedAndStay) {
  const Program program;
  program.Write("drift.cdb",
                "benchmark drift { cycles 300; expect energy; world { side 500; walls none }\n"
                "  objects { quantity 1; linear_damping sweep(0, 0.9) } }");
  const Finished run = program.Run({"run", "drift.cdb"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find(
                "Not stable: 1 of 2 runs; their times are shown, but are those of another motion"),
            std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("1 drifting: linear_damping 0.9, rep 0 by energy from cycle "),
            std::string::npos);
}

TEST(Stability, ARatioHasNoUnit) {
  const Program program;
  const Finished map =
      program.Run({"stability", "mass_ratio", "--precision", "single", "--detector", "dbvt", "-q"});
  EXPECT_NE(map.out.find("\n  precision  detector  ratio\n"), std::string::npos)
      << map.out << map.err;
}

TEST(Stability, SetsNarrowPhasesSideBySide) {
  const Program program;
  const Finished map = program.Run(
      {"stability", "size_ratio", "--precision", "double", "--narrow-phase", "bullet,batch", "-q"});
  EXPECT_EQ(map.status, 0) << map.err;
  EXPECT_NE(map.out.find("\n  precision  detector  narrow_phase  "), std::string::npos) << map.out;
  EXPECT_NE(map.out.find("\n  double     dbvt      bullet        "), std::string::npos) << map.out;
  EXPECT_NE(map.out.find("\n  double     dbvt      batch         "), std::string::npos) << map.out;
}

TEST(Stability, SearchesWhereASceneStopsBeingSound) {
  const Program program;
  const Finished found =
      program.Run({"stability", "mass_ratio", "--boundaries", "--precision", "single", "-q"});
  EXPECT_EQ(found.status, 0) << found.err;
  EXPECT_NE(found.out.find("Boundary: heavy on light: verdict != stable along ratio\n"),
            std::string::npos)
      << found.out;
  EXPECT_NE(found.out.find("nowhere up to 100000"), std::string::npos) << found.out;
  EXPECT_NE(found.out.find("95 % interval over the seeds"), std::string::npos) << found.out;
  const Finished unknown = program.Run({"stability", "nothing", "--boundaries"});
  EXPECT_EQ(unknown.status, 2);
}

TEST(Stability, MapsWhereASceneStopsBeingSound) {
  const Program program;
  const std::vector<std::string> command = {"stability",  "spin",       "--precision", "double",
                                            "--detector", "dbvt,sap32", "-q"};
  const Finished map = program.Run(command);
  EXPECT_EQ(map.status, 0) << map.err;
  EXPECT_EQ(map.err, "");
  EXPECT_NE(map.out.find("Stability: spin\n"), std::string::npos) << map.out;
  EXPECT_NE(map.out.find("\n  double     sap32     ball   stable 1 .. 30 | clamped 100 .. 1e+05\n"),
            std::string::npos)
      << map.out;
  EXPECT_EQ(map.out.find("single"), std::string::npos);
  EXPECT_TRUE(program.Exists("stability/stability_spin.h5"));
  // Existing results are not run again, and those of another sweep are not accepted.
  EXPECT_EQ(program.Run(command).out, map.out);
  const Finished other = program.Run({"stability", "spin", "-q"});
  EXPECT_EQ(other.status, 2);
  EXPECT_NE(other.err.find("another plan"), std::string::npos) << other.err;
}

TEST(Stability, RefusesWhatItHasNot) {
  const Program program;
  const auto error = [&](const std::vector<std::string>& arguments) {
    const Finished finished = program.Run(arguments);
    EXPECT_EQ(finished.status, 2);
    return finished.err;
  };
  EXPECT_NE(error({"stability", "tall_stak"}).find("did you mean 'tall_stack'?"),
            std::string::npos);
  EXPECT_NE(error({"stability", "--narrow-phase", "bulet"})
                .find("--narrow-phase bulet: did you mean 'bullet'?"),
            std::string::npos);
  EXPECT_NE(error({"stability", "--detector", "dvbt"}).find("did you mean 'dbvt'?"),
            std::string::npos);
  EXPECT_NE(error({"stability", "--precision", "half"}).find("single, double"), std::string::npos);
  EXPECT_NE(error({"stability", "--precision", "single,single"}).find("twice"), std::string::npos);
  EXPECT_FALSE(program.Exists("stability"));
}

}  // namespace
}  // namespace cdb::tests
