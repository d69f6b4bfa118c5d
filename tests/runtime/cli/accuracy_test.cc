// Errors beside timings, through the whole program.
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
      EXPECT_LT(file.ReadReal("accuracy/position_floor", cell), 1e-6);
      EXPECT_EQ(file.ReadText("accuracy/message", cell), "");
    }
    EXPECT_NEAR(Order(timesteps, errors), 1, 0.05) << truth;
    // The error is g t dt / 2, because the integrator moves by the new velocity.
    EXPECT_NEAR(errors[0], 9.8 * timesteps[0] * std::sqrt(4.0 / 3) / 2 / 50, 2e-4) << truth;
  }
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
  EXPECT_NE(plan.out.find("compared with 2 reference runs"), std::string::npos) << plan.out;
  const Finished run = program.Run({"run", "gas.cdb"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("4/4"), std::string::npos) << run.err;
  EXPECT_FALSE(program.Exists("gas.runs"));
  const results::ResultFile file(program.folder() / "gas.h5");
  for (std::size_t i = 0; i < 2; ++i) {
    const results::ResultFile::Cell cell{{i}, 0};
    for (const std::string error : {"position", "height", "height_w1"}) {
      EXPECT_GT(file.ReadReal("accuracy/" + error + "_floor", cell), 0) << error;
      EXPECT_GT(file.ReadReal("accuracy/" + error, cell),
                file.ReadReal("accuracy/" + error + "_floor", cell))
          << error;
    }
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
  const std::string reference = plans[0].references[0].id, perturbed = plans[0].references[1].id;
  const fs::path folder = program.folder() / "gas.runs";
  ASSERT_EQ(program.Run({"run", "gas.cdb", "-q", "--shard", "1/2"}).status, 0);
  const auto before = RunsIn(folder);
  ASSERT_TRUE(before.contains(reference) && before.contains(perturbed));
  // A perturbed run that is missing is executed again, as any run.
  journal::Journal::OpenToWrite(folder, plans[0].Sha256()).Forget(perturbed);
  const Finished second = program.Run({"run", "gas.cdb", "--shard", "2/2"});
  ASSERT_EQ(second.status, 0) << second.err;
  EXPECT_EQ(RunsIn(folder).at(reference), before.at(reference)) << "it was there";
  EXPECT_GT(RunsIn(folder).at(perturbed), before.at(perturbed));
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
