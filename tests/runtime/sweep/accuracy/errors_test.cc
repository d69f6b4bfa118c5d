// Errors of hand-made samples, whose exact values follow from simple arithmetic.
#include "runtime/sweep/accuracy/errors.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::ErrorInfo;
using schema::Fold;

/// Two balls of size 2 and 4 and mass 1 and 3, and a fixed one; samples are one second apart.
struct HandMadeSamples {
  explicit HandMadeSamples(std::size_t count) : shape{count, 3}, values(shape.Count(), 0) {
    const double masses[] = {1, 3, 0}, sizes[] = {2, 4, 100};
    for (std::size_t i = 0; i < 3; ++i) {
      values[shape.Body(i)] = masses[i];
      values[shape.Body(i) + 1] = sizes[i];
    }
    for (std::size_t s = 0; s < count; ++s) Set(s, protocol::kAccelerationX, {0, -10, 0});
  }
  void Set(std::size_t sample, std::size_t object, int from, const Vector3d& v) {
    double* place = &values[shape.State(sample, object) + static_cast<std::size_t>(from)];
    std::ranges::copy(v, place);
  }
  void Set(std::size_t sample, protocol::Observable which, const Vector3d& v) {
    double* place = &values[shape.Observables(sample) + which];
    std::ranges::copy(v, place);
  }
  void Set(std::size_t sample, protocol::Observable which, double value) {
    values[shape.Observables(sample) + which] = value;
  }
  protocol::Samples samples() const { return {shape, 1, values}; }

  protocol::SampleShape shape;
  std::vector<double> values;
};

const ErrorInfo& Info(std::string_view name) {
  for (const ErrorInfo& error : schema::Errors())
    if (error.name == name) return error;
  throw std::runtime_error("no such error");
}

/// The error `name` of `run` at sample `at`.
double ErrorAt(std::string_view name, const HandMadeSamples& run, const HandMadeSamples& truth,
               std::size_t at = 1) {
  const ErrorInfo* info = &Info(name);
  const protocol::Samples reference = truth.samples();
  const auto standard = accuracy::StandardOf(reference);
  return accuracy::ErrorSeries({&info, 1}, run.samples(), standard.get())[0].at(at);
}

TEST(Errors, OfPlacesAreInSizesOfEachObject) {
  HandMadeSamples truth(2), run(2);
  run.Set(1, 0, 0, {2, 0, 0});   // one size away
  run.Set(1, 1, 0, {0, 0, 12});  // three
  run.Set(1, 2, 0, {9, 9, 9});   // fixed: ignored
  EXPECT_DOUBLE_EQ(ErrorAt("position", run, truth), std::sqrt((1.0 + 9) / 2));
  EXPECT_EQ(ErrorAt("position", run, truth, 0), 0);
}

TEST(Errors, OfVelocitiesAreInMetresASecond) {
  HandMadeSamples truth(2), run(2);
  truth.Set(1, 0, 7, {0, 5, 0});
  run.Set(1, 0, 7, {3, 1, 0});  // 5 apart
  run.Set(1, 1, 7, {0, 0, 1});
  EXPECT_DOUBLE_EQ(ErrorAt("velocity", run, truth), std::sqrt((25.0 + 1) / 2));
}

TEST(Errors, OfOrientationsAreAngles) {
  HandMadeSamples truth(2), run(2);
  const auto turn = [](HandMadeSamples& samples, std::size_t object, double angle) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
    std::ranges::copy(q.coeffs(), &samples.values[samples.shape.State(1, object) + 3]);
  };
  turn(truth, 0, 0.5);
  turn(run, 0, 0.8);
  turn(truth, 1, -0.2);
  turn(run, 1, 0.2);
  EXPECT_NEAR(ErrorAt("rotation", run, truth), std::sqrt((0.09 + 0.16) / 2), 1e-12);
}

TEST(Errors, OfEnergyCompareChanges) {
  HandMadeSamples truth(2), run(2);
  // A different zero of the potential, as rounding of the start may cause, is not an error.
  run.Set(0, protocol::kPotential, 100);
  run.Set(1, protocol::kPotential, 90);
  run.Set(1, protocol::kKinetic, 16);
  truth.Set(1, protocol::kKinetic, 20);
  truth.Set(1, protocol::kPotential, -20);
  // 6 J too much, relative to 20 J and 10 m/s^2 * (1 * 2 + 3 * 4).
  EXPECT_DOUBLE_EQ(ErrorAt("energy", run, truth), 6.0 / (20 + 140));
}

TEST(Errors, OfMomentaAreOverTheLargestSum) {
  HandMadeSamples truth(2), run(2);
  truth.Set(0, protocol::kMomentumSum, 8);
  truth.Set(1, protocol::kMomentumSum, 4);
  run.Set(1, protocol::kMomentumX, {0, 3, 4});
  EXPECT_DOUBLE_EQ(ErrorAt("momentum", run, truth), 5.0 / 8);
  EXPECT_TRUE(std::isnan(ErrorAt("angular_momentum", run, truth))) << "nothing turns";
  truth.Set(0, protocol::kAngularSum, 10);
  truth.Set(1, protocol::kAngularX, {0, 0, 2});
  EXPECT_DOUBLE_EQ(ErrorAt("angular_momentum", run, truth), 0.2);
}

TEST(Errors, OfHeightsAreAlongTheAcceleration) {
  HandMadeSamples truth(2), run(2);
  run.Set(1, 0, 0, {7, 6, 0});
  truth.Set(1, 1, 0, {0, 3, 0});
  // Mean size 3: heights 6 and 0 compared with 0 and 3.
  EXPECT_DOUBLE_EQ(ErrorAt("height", run, truth), (3 - 1.5) / 3);
  EXPECT_DOUBLE_EQ(ErrorAt("height_w1", run, truth), (0 + 3) / 2.0 / 3);
}

TEST(Errors, OfContactsAndPairsAreOfTheTrueNumber) {
  HandMadeSamples truth(2), run(2);
  truth.Set(1, protocol::kContactCount, 8);
  run.Set(1, protocol::kContactCount, 6);
  run.Set(1, protocol::kPairsExact, 10);
  run.Set(1, protocol::kPairsMissed, 1);
  run.Set(1, protocol::kPairsPhantom, 4);
  run.Set(1, protocol::kDepthMean, 0.25);
  run.Set(1, protocol::kDepthMax, 0.5);
  EXPECT_DOUBLE_EQ(ErrorAt("contacts", run, truth), 0.25);
  EXPECT_DOUBLE_EQ(ErrorAt("pairs_missed", run, truth), 0.1);
  EXPECT_DOUBLE_EQ(ErrorAt("pairs_phantom", run, truth), 0.4);
  EXPECT_DOUBLE_EQ(ErrorAt("penetration", run, truth), 0.25);
  EXPECT_DOUBLE_EQ(ErrorAt("penetration_max", run, truth), 0.5);
}

TEST(Errors, OfGeometryAreOfTheOverlapsThatThereAre) {
  HandMadeSamples truth(2), run(2);
  const auto no_value = [&](const char* name) { return std::isnan(ErrorAt(name, run, truth)); };
  for (const char* name : {"depth_error", "normal_error", "contacts_missed"})
    EXPECT_TRUE(no_value(name)) << "no overlap";
  run.Set(1, protocol::kOverlapsExact, 2);
  run.Set(1, protocol::kOverlapsMissed, 2);
  EXPECT_DOUBLE_EQ(ErrorAt("contacts_missed", run, truth), 1);
  EXPECT_TRUE(no_value("depth_error"));
  EXPECT_TRUE(no_value("normal_error"));
  run.Set(1, protocol::kOverlapsExact, 10);
  run.Set(1, protocol::kDepthErrorSum, 0.4);
  run.Set(1, protocol::kNormalErrorSum, 0.3);
  run.Set(1, protocol::kNormalCount, 6);
  EXPECT_DOUBLE_EQ(ErrorAt("contacts_missed", run, truth), 0.2);
  EXPECT_DOUBLE_EQ(ErrorAt("depth_error", run, truth), 0.05);
  EXPECT_DOUBLE_EQ(ErrorAt("normal_error", run, truth), 0.05);
}

TEST(Folded, LeavesOutTheStartAndWhatFollows) {
  const std::vector<double> series = {100, 3, 4, 12};
  EXPECT_DOUBLE_EQ(accuracy::Folded(series, Fold::kRms, 3), std::sqrt(12.5));
  EXPECT_DOUBLE_EQ(accuracy::Folded(series, Fold::kMean, 4), 19.0 / 3);
  EXPECT_DOUBLE_EQ(accuracy::Folded(series, Fold::kMax, 9), 12);
  EXPECT_TRUE(std::isnan(accuracy::Folded(series, Fold::kRms, 1)));
  EXPECT_TRUE(std::isnan(accuracy::Folded(std::vector<double>{0, NAN}, Fold::kMax, 2)));
}

TEST(Folded, OfSomeIsOverTheSamplesThatHaveAValue) {
  EXPECT_DOUBLE_EQ(accuracy::Folded(std::vector<double>{7, NAN, 2, NAN, 4}, Fold::kMeanOfSome, 5),
                   3);
  EXPECT_TRUE(std::isnan(accuracy::Folded(std::vector<double>{7, NAN, NAN}, Fold::kMeanOfSome, 3)));
  EXPECT_TRUE(
      std::isinf(accuracy::Folded(std::vector<double>{7, INFINITY, 1}, Fold::kMeanOfSome, 3)));
}

TEST(MeanMove, IsW1) {
  EXPECT_DOUBLE_EQ(accuracy::MeanMove({3, 1, 2}, {2, 3, 1}), 0);
  EXPECT_DOUBLE_EQ(accuracy::MeanMove({0, 10}, {11, 1}), 1);
  EXPECT_TRUE(std::isnan(accuracy::MeanMove({0, NAN}, {0, 1})));
}

TEST(Horizon, IsWhereTheTwinIsATenthOfASizeAway) {
  HandMadeSamples reference(4), twin(4);
  twin.Set(1, 0, 0, {0.1, 0, 0});
  EXPECT_EQ(accuracy::HorizonOf(reference.samples(), twin.samples()), 4u);
  // 0.1 sizes of one object are 0.1 / sqrt(2) of both.
  twin.Set(2, 0, 0, {0.2, 0, 0});
  EXPECT_EQ(accuracy::HorizonOf(reference.samples(), twin.samples()), 4u);
  twin.Set(3, 0, 0, {0.3, 0, 0});
  EXPECT_EQ(accuracy::HorizonOf(reference.samples(), twin.samples()), 3u);
}

plan::Scene Asking(schema::WordList metrics) {
  plan::Scene scene;
  scene.world.Set("accuracy.metrics", std::move(metrics));
  scene.world.Set("timestep", 0.5);
  return scene;
}

TEST(CollectErrors, ReachesToTheHorizonWithAFloor) {
  HandMadeSamples reference(4), twin(4), run(4);
  for (std::size_t s = 1; s < 4; ++s) run.Set(s, 0, 0, {2.0 * static_cast<double>(s), 0, 0});
  twin.Set(1, 1, 0, {0.4, 0, 0});
  twin.Set(2, 0, 0, {1, 0, 0});
  const protocol::Samples samples = reference.samples(), others = twin.samples();
  const auto standard = accuracy::StandardOf(samples);
  const protocol::RunErrors errors = accuracy::CollectErrors(Asking({"position"}), run.samples(),
                                                             standard.get(), &samples, &others);
  EXPECT_EQ(errors.message, "");
  EXPECT_EQ(errors.values.at("horizon"), std::vector<double>{2});
  EXPECT_EQ(errors.values.at("timestep"), std::vector<double>{0.5});
  EXPECT_DOUBLE_EQ(errors.values.at("position").at(0), std::sqrt(0.5));
  EXPECT_DOUBLE_EQ(errors.values.at("position_floor").at(0), std::sqrt(0.01 / 2));
  EXPECT_EQ(errors.values.at("position_series").size(), 4u);
  EXPECT_EQ(errors.values.size(), 5u);
}

TEST(CollectErrors, HasNoValueOfWhatIsNotANumber) {
  HandMadeSamples run(3);
  run.Set(2, 0, 0, {NAN, 0, 0});
  const protocol::RunErrors errors =
      accuracy::CollectErrors(Asking({"penetration"}), run.samples(), nullptr, nullptr, nullptr);
  EXPECT_EQ(errors.message, "a state of the run is not finite");
  EXPECT_EQ(errors.values.at("penetration").at(0), 0);
  EXPECT_FALSE(errors.values.contains("penetration_floor"));
}

/// A closed form that states only that energy is conserved.
class OnlyEnergy : public closed_forms::ClosedForm {
 public:
  closed_forms::Truth At(double) const override {
    closed_forms::Truth truth;
    truth.energy = 0;
    return truth;
  }
  double energy_scale() const override { return 4; }
};

TEST(CollectErrors, HoldsAgainstAClosedForm) {
  HandMadeSamples run(3);
  run.Set(1, protocol::kKinetic, 2);
  run.Set(2, protocol::kKinetic, 2);
  const protocol::Samples samples = run.samples();
  const OnlyEnergy form;
  const protocol::RunErrors errors =
      accuracy::CollectErrors(Asking({"energy", "position"}), samples,
                              accuracy::StandardOf(form, samples).get(), nullptr, nullptr);
  EXPECT_DOUBLE_EQ(errors.values.at("energy").at(0), 0.5);
  EXPECT_EQ(errors.values.at("energy_floor").at(0), 0);
  EXPECT_EQ(errors.values.at("horizon").at(0), 2);
  EXPECT_TRUE(std::isnan(errors.values.at("position").at(0)));
}

}  // namespace
}  // namespace cdb::tests
