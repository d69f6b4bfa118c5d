// Errors beside timings, through the whole program.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "compiler/compile.h"
#include "runtime/report/show_error.h"
#include "runtime/store/shards/shards.h"
#include "runtime/store/store.h"
#include "tests/runtime/store/store_fixture.h"
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
    const store::ResultFile file(program.folder() / "flight.h5");
    std::vector<double> timesteps, errors;
    for (std::size_t i = 0; i < 4; ++i) {
      const store::ResultFile::Cell cell{{i}, 0};
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
  const store::ResultFile file(program.folder() / "gas.h5");
  for (std::size_t i = 0; i < 2; ++i) {
    const store::ResultFile::Cell cell{{i}, 0};
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
  const std::string reference = "gas.runs/" + plans[0].references[0].id + ".h5";
  const std::string perturbed = "gas.runs/" + plans[0].references[1].id + ".h5";
  ASSERT_EQ(program.Run({"run", "gas.cdb", "-q", "--shard", "1/2"}).status, 0);
  ASSERT_TRUE(program.Exists(reference) && program.Exists(perturbed));
  const std::string before = program.Read(reference);
  fs::remove(program.folder() / perturbed);
  // A damaged perturbed run is executed again, as any shard.
  program.Write(perturbed, before.substr(0, before.size() / 2));
  const Finished second = program.Run({"run", "gas.cdb", "--shard", "2/2"});
  ASSERT_EQ(second.status, 0) << second.err;
  EXPECT_EQ(program.Read(reference), before) << "it was there";
  EXPECT_TRUE(program.Exists(perturbed));
  const Finished all = program.Run({"run", "gas.cdb"});
  EXPECT_EQ(all.status, 0) << all.err;
  EXPECT_FALSE(program.Exists(reference));
  const store::ResultFile file(program.folder() / "gas.h5");
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
  const store::ResultFile file(program.folder() / "far.h5");
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
  const store::ResultFile file(program.folder() / (id + ".h5"));
  EXPECT_GT(file.ReadReal("accuracy/position", {{0}, 0}), 0);
}

/// The table of a result with known times and errors: a cycle of 1 / hz s takes `hz` * `us`.
std::string ShownError(const statistics::ErrorOptions& options) {
  plan::Plan plan =
      MakePlan({NumberAxis("hz", {60, 120, 240}), TextAxis("precision", {"single", "double"})}, 2,
               {.cycles = 4, .record = {"timing"}, .metrics = {"position", "pairs"}});
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs) {
    FakeResult fake(run);
    const auto hz = std::get<double>(plan.axes[0].values[run.at[0]]);
    const bool is_double = run.at[1] == 1;
    std::vector<double> durations(measure::kPhaseCount * 4, 0);
    for (std::size_t i = 0; i < 4; ++i)
      durations[measure::IndexOf(measure::Phase::kStep) * 4 + i] =
          (is_double ? 2000 : 1000) * (1 + 0.5 * static_cast<double>(run.rep));
    fake.result.series = {{measure::FindSeries("duration"), std::as_bytes(std::span(durations))}};
    auto& values = fake.result.errors.values;
    values["timestep"] = {1 / hz};
    values["horizon"] = {1.5};
    values["position"] = {is_double && hz == 240 ? NAN : (is_double ? 1 : 1.5) / hz};
    values["position_floor"] = {hz == 240 ? 0.01 : 0.001};
    if (std::isnan(values["position"][0])) fake.result.errors.message = "a test";
    if (is_double && hz == 60) {
      fake.result.status = store::Status::kCrashed;
      fake.result.message = "of old age";
    }
    shards::WriteShard(plan, run, fake.result, {{"build_type", "Release"}}, folder.path());
  }
  shards::Merge(plan, {{"build_type", "Release"}}, folder.path(), folder / "out.h5");
  return report::ShowError(store::ResultFile(folder / "out.h5"), options).text;
}

TEST(ShowError, IsSortedByTimeAndMarksTheFront) {
  EXPECT_EQ(ShownError({"position", {}, {}}), R"(A plan for tests – µ
  position: distance from the true position, in sizes of the object; root mean square over objects and samples
  1 not on the plot, as the error is not known:
    hz 240, precision double: a test
  1 did not end well; marked, and not on the front:
    hz 60, precision double: crashed: of old age

   hz  precision  x real time  ms per s           range  position     floor  horizon, s
  -------------------------------------------------------------------------------------------------------
   60  single           13330    0.0750  0.0600..0.0900  2.50e-02  1.00e-03        1.50  front
  120  single            6667     0.150    0.120..0.180  1.25e-02  1.00e-03        1.50  front
  120  double            3333     0.300    0.240..0.360  8.33e-03  1.00e-03        1.50  front
  240  single            3333     0.300    0.240..0.360  6.25e-03  1.00e-02        1.50  tie, below floor
   60  double            6667     0.150    0.120..0.180  1.67e-02  1.00e-03        1.50  crashed
  Median over 2 repeats per cycle, then mean over cycles; range over all draws of repeats.
  tie: every configuration that is as fast and as accurate lies within the range and the floor.

position, * front, = tie, x void
 2.50e-02 |                                                           *
          |
          |
          |
          |                              x
          |
          |                              *
          |
          |
          |
          |*
          |
          |
 6.25e-03 |=
          +------------------------------------------------------------
           3333                    x real time                    13330

An error below its floor is not significant: the reference and its perturbed run differ by as much.
)");
}

TEST(ShowError, MakesATableForEachValue) {
  const std::string text = ShownError({"position", {}, {"precision"}});
  EXPECT_NE(text.find("\nprecision single\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nprecision double\n"), std::string::npos) << text;
}

TEST(ShowError, TakesTheMeanOverTheCellsThatAllRowsHave) {
  const std::string text = ShownError({"position", {"precision"}, {}});
  EXPECT_NE(text.find("\n  the mean over hz\n"), std::string::npos) << text;
  // Only the double-precision run at 120 Hz is left.
  EXPECT_NE(text.find("\n  single     1 of 3 "), std::string::npos) << text;
  EXPECT_NE(text.find("1.25e-02"), std::string::npos) << text;
  EXPECT_NE(text.find("8.33e-03"), std::string::npos) << text;
}

TEST(ShowError, NamesWhatThereIs) {
  const auto said = [](const statistics::ErrorOptions& options) -> std::string {
    try {
      ShownError(options);
    } catch (const files::StoreError& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_EQ(said({"energy", {}, {}}),
            "there is no error 'energy' in this file; there are position, pairs_missed, "
            "pairs_phantom");
  EXPECT_EQ(said({"position", {"size"}, {}}), "there is no axis 'size'; there are hz, precision");
}

}  // namespace
}  // namespace cdb::tests
