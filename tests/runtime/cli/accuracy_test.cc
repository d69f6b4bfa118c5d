// Errors beside timings, through the whole program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "compiler/compile.h"
#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// Slope of log(y) on log(x), by least squares.
double Order(const std::vector<double>& x, const std::vector<double>& y) {
  Eigen::MatrixX2d a(static_cast<long>(x.size()), 2);
  a.col(0).setOnes();
  a.col(1) = Eigen::Map<const Eigen::ArrayXd>(x.data(), a.rows()).log();
  const Eigen::VectorXd b = Eigen::Map<const Eigen::ArrayXd>(y.data(), a.rows()).log();
  return a.colPivHouseholderQr().solve(b)[1];
}

const char kFlight[] =
    "benchmark flight { let hz = sweep(30, 60, 120, 240); timestep 1 / hz; cycles 2 * hz\n"
    "  precision double; world.side 500; world.walls none\n"
    "  objects { quantity 4; linear_velocity uniform((-9, 5, -9), (9, 20, 9)) }\n"
    "  accuracy { metrics position, velocity";

TEST(Accuracy, OfAFlightIsOfOrderOne) {
  const auto error_of_step = [](double timestep) {
    // g t dt / 2, because the integrator moves by the new velocity; sizes are 50 m.
    return 9.8 * timestep * std::sqrt(4.0 / 3) / 2 / 50;
  };
  for (const char* truth : {"; closed_form flight } }", "; reference { timestep 1 / 7680 } } }"}) {
    const Program program;
    program.Write("flight.cdb", std::string(kFlight) + truth);
    const Finished run = program.Run({"run", "flight.cdb", "-q"});
    ASSERT_EQ(run.status, 0) << run.err;
    const results::ResultFile file(program.folder() / "flight.h5");
    std::vector<double> timesteps, errors;
    for (std::size_t i = 0; i < 4; ++i) {
      const results::ResultFile::Cell cell{{i}, 0};
      timesteps.push_back(file.ReadReal("accuracy/timestep", cell));
      errors.push_back(file.ReadReal("accuracy/position", cell));
      EXPECT_DOUBLE_EQ(file.ReadReal("accuracy/horizon", cell), 2) << "nothing is chaotic here";
      // The floor is the error of the reference.
      const double floor = file.ReadReal("accuracy/position_floor", cell);
      if (std::string(truth).find("reference") != std::string::npos)
        EXPECT_NEAR(floor / error_of_step(1.0 / 7680), 1, 0.05);
      else
        EXPECT_EQ(floor, 0);
      EXPECT_EQ(file.ReadText("accuracy/message", cell), "");
    }
    EXPECT_NEAR(Order(timesteps, errors), 1, 0.05) << truth;
    EXPECT_NEAR(errors[0], error_of_step(timesteps[0]), 2e-4) << truth;
    const Finished show = program.Run({"show", "flight.h5"});
    EXPECT_THAT(show.out, HasSubstr("Does the error of position fall with the time step?\n"
                                    "    Yes: as the time step to the power 1.0"));
  }
}

TEST(Accuracy, HasNoTruthInAReferenceThatIsNotSound) {
  const Program program;
  // In a cycle of 1/15 s, the ball moves by 20 m: through the plate.
  program.Write("through.cdb", R"(benchmark through {
    let hz = sweep(1200, 2400); timestep 1 / hz; cycles hz; acceleration 0; world.walls none
    objects ball { quantity 1; type sphere; size 1; location at(0, 0, 7.5); linear_velocity (0, 0, -300) }
    objects plate { quantity 1; type cuboid; size 10; aspect 1 : 1 : 0.1; mass 1e6; location at(0, 0, 0) }
    accuracy { metrics energy, penetration; reference { timestep 1 / 15 } }
  })");
  EXPECT_EQ(program.Run({"run", "through.cdb", "-q"}).status, 0);
  const results::ResultFile file(program.folder() / "through.h5");
  ASSERT_EQ(file.ReadReferenceTroubles().size(), 1u);
  EXPECT_THAT(file.ReadReferenceTroubles()[0].text, StartsWith("tunnelled"));
  const std::string show = program.Run({"show", "through.h5"}).out;
  EXPECT_THAT(show, HasSubstr("A reference is not sound: tunnelled")) << show;
  const std::string energy = program.Run({"show", "through.h5", "--error", "energy"}).out;
  EXPECT_THAT(energy, HasSubstr("reference tunnelled"));
  EXPECT_THAT(energy, Not(HasSubstr("front")));
  // What needs no truth does not suffer.
  EXPECT_THAT(program.Run({"show", "through.h5", "--error", "penetration"}).out,
              Not(HasSubstr("reference")));
}

TEST(Accuracy, OfASlideIsNotComparedWithSleepers) {
  const Program program;
  program.Write("slope.cdb", R"(benchmark slope {
    let hz = sweep(60, 120); timestep 1 / hz; cycles 8 * hz; acceleration (0.05, -9.8, 0)
    world { walls floor; side 100 }
    objects { quantity 1; type sphere; size 1; location at(0, -49.5, 0) }
    accuracy { metrics position; reference { timestep 1 / 960 } }
  })");
  EXPECT_EQ(program.Run({"run", "slope.cdb", "-q"}).status, 0);
  const results::ResultFile file(program.folder() / "slope.h5");
  EXPECT_TRUE(file.ReadReferenceTroubles().empty());
  // It rolls by 5/7 a t^2 / 2 in truth, 1.1 m, and falls asleep in the run.
  for (std::size_t i = 0; i < 2; ++i) EXPECT_GT(file.ReadReal("accuracy/position", {{i}, 0}), 0.2);
}

const char kGas[] =
    "benchmark gas { let hz = sweep(60, 120); timestep 1 / hz; cycles 1 * hz\n"
    "  world.side 200; acceleration 0\n"
    "  objects { quantity 20; size 20; restitution 1; linear_velocity uniform(-200, 200) }\n"
    "  accuracy { metrics position, height; reference { timestep 1 / 480 } } }";

TEST(Accuracy, OfAGasHasAFloor) {
  const Program program;
  program.Write("gas.cdb", kGas);
  const Finished plan = program.Run({"plan", "gas.cdb"});
  EXPECT_NE(plan.out.find("compared with a reference run, checked by a twin"), std::string::npos)
      << plan.out;
  const Finished run = program.Run({"run", "gas.cdb"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("4/4"), std::string::npos) << run.err;
  EXPECT_FALSE(program.Exists("gas.runs"));
  const results::ResultFile file(program.folder() / "gas.h5");
  for (std::size_t i = 0; i < 2; ++i) {
    const results::ResultFile::Cell cell{{i}, 0};
    for (const std::string error : {"position", "height", "height_w1"})
      EXPECT_GT(file.ReadReal("accuracy/" + error + "_floor", cell), 0) << error;
    EXPECT_GT(file.ReadReal("accuracy/position", cell),
              file.ReadReal("accuracy/position_floor", cell));
    EXPECT_EQ(file.ReadText("accuracy/truth", cell), file.ReadText("accuracy/truth", {{0}, 0}));
  }
}

TEST(Accuracy, GoesOnWithTheReferencesThatAreThere) {
  const Program program;
  program.Write("gas.cdb", kGas);
  std::string why;
  const auto plans =
      compiler::Compile((program.folder() / "gas.cdb").string(), compiler::ReadFromDisk).plans;
  ASSERT_EQ(plans.at(0).references.size(), 2u);
  const std::string reference = plans[0].references[0].id, twin = plans[0].references[1].id;
  const fs::path folder = program.folder() / "gas.runs";
  ASSERT_EQ(program.Run({"run", "gas.cdb", "-q", "--shard", "1/2"}).status, 0);
  const auto before = RunsIn(folder);
  ASSERT_TRUE(before.contains(reference) && before.contains(twin));
  // A twin that is missing is executed again, as any run.
  journal::Journal::OpenToWrite(folder, plans[0].Sha256()).Forget(twin);
  const Finished second = program.Run({"run", "gas.cdb", "--shard", "2/2"});
  ASSERT_EQ(second.status, 0) << second.err;
  EXPECT_EQ(RunsIn(folder).at(reference), before.at(reference)) << "it was there";
  EXPECT_GT(RunsIn(folder).at(twin), before.at(twin));
  const Finished checked = program.Run({"check", "gas.runs/runs.journal"});
  EXPECT_NE(checked.out.find("whole: a journal of 4 finished runs"), std::string::npos)
      << checked.out << checked.err;
  const Finished all = program.Run({"run", "gas.cdb"});
  EXPECT_EQ(all.status, 0) << all.err;
  EXPECT_FALSE(program.Exists("gas.runs"));
  const results::ResultFile file(program.folder() / "gas.h5");
  for (std::size_t i = 0; i < 2; ++i) EXPECT_GT(file.ReadReal("accuracy/position", {{i}, 0}), 0);
}

TEST(Accuracy, HasNoValueWhereTheReferenceFails) {
  const Program program;
  // The value is not representable in the reference's precision.
  program.Write("far.cdb",
                "benchmark far { cycles 12; precision double; acceleration (0, -1e39, 0)\n"
                "  world.walls none; timestep 1 / 60\n"
                "  accuracy { metrics position, penetration; interval 1 / 60\n"
                "    reference { precision single; timestep 1 / 60 } } }");
  const Finished run = program.Run({"run", "far.cdb"});
  EXPECT_EQ(run.status, 3) << run.err;
  EXPECT_NE(run.err.find("errors without a value: reference"), std::string::npos) << run.err;
  const results::ResultFile file(program.folder() / "far.h5");
  EXPECT_TRUE(std::isnan(file.ReadReal("accuracy/position", {{}, 0})));
  EXPECT_EQ(file.ReadReal("accuracy/penetration", {{}, 0}), 0);
  EXPECT_NE(file.ReadText("accuracy/message", {{}, 0}).find("out of reach of single precision"),
            std::string::npos);
  const Finished shown = program.Run({"show", "far.h5", "--error", "position"});
  EXPECT_NE(shown.out.find("not on the plot, as the error is not known"), std::string::npos)
      << shown.out;
}

TEST(Accuracy, OfAFormThatDoesNotFitSaysWhy) {
  const Program program;
  program.Write("no.cdb",
                "benchmark no { cycles 12; accuracy { metrics position; closed_form spin } }");
  for (const std::string command : {"check", "run"}) {
    const Finished refused = program.Run({command, "no.cdb"});
    EXPECT_EQ(refused.status, 1);
    EXPECT_NE(refused.err.find("no.cdb:1:68: error: closed form `spin` does not apply to this "
                               "scene: there are 10 objects [E0222 wrong-form]"),
              std::string::npos)
        << refused.err;
  }
  EXPECT_FALSE(program.Exists("no.h5"));
}

TEST(Accuracy, OfOneRunBringsItsReference) {
  const Program program;
  program.Write("gas.cdb", kGas);
  const auto plans =
      compiler::Compile((program.folder() / "gas.cdb").string(), compiler::ReadFromDisk).plans;
  const std::string id = plans.at(0).runs[1].id;
  ASSERT_EQ(program.Run({"run", "gas.cdb", "-q", "--only", id}).status, 0);
  const results::ResultFile file(program.folder() / (id + ".h5"));
  EXPECT_GT(file.ReadReal("accuracy/position", {{0}, 0}), 0);
}

}  // namespace
}  // namespace cdb::tests
