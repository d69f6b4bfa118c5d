// Tables of error against run time.
#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "runtime/printers/show.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

/// The table of a result with known times and errors: a cycle of 1 / hz s takes `hz` * `us`.
std::string ShownError(const figures::ErrorOptions& options) {
  plan::Plan plan =
      MakePlan({NumberAxis("hz", {60, 120, 240}), TextAxis("precision", {"single", "double"})}, 2,
               {.cycles = 4, .record = {"timing"}, .metrics = {"position", "pairs"}});
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs) {
    FakeResult fake(run);
    const auto hz = std::get<double>(plan.axes[0].values[run.at[0]]);
    const bool is_double = run.at[1] == 1;
    std::vector<double> durations(protocol::kPhaseCount * 4, 0);
    for (std::size_t i = 0; i < 4; ++i)
      durations[protocol::IndexOf(protocol::Phase::kStep) * 4 + i] =
          (is_double ? 2000 : 1000) * (1 + 0.5 * static_cast<double>(run.rep));
    fake.result.series = {{protocol::FindSeries("duration"), std::as_bytes(std::span(durations))}};
    auto& values = fake.result.errors.values;
    values["timestep"] = {1 / hz};
    values["horizon"] = {1.5};
    values["position"] = {is_double && hz == 240 ? NAN : (is_double ? 1 : 1.5) / hz};
    values["position_floor"] = {hz == 240 ? 0.01 : 0.001};
    if (std::isnan(values["position"][0])) fake.result.errors.message = "a test";
    if (is_double && hz == 60) {
      fake.result.status = results::Status::kCrashed;
      fake.result.message = "of old age";
    }
    WriteRun(plan, run, fake.result, {{"build_type", "Release"}}, folder.path());
  }
  journal::Merge(plan, {{"build_type", "Release"}}, folder.path(), folder / "out.h5");
  return printers::ShowError(results::ResultFile(folder / "out.h5"), {options}).text;
}

TEST(ShowError, IsSortedByTimeAndMarksTheFront) {
  EXPECT_EQ(ShownError({"position", {}, {}}), R"(A plan for tests – µ
  position: distance from the true position, in sizes of the object; root mean square over objects and samples
  1 not on the plot, as the error is not known:
    hz 240, precision double: a test
  1 did not end well; marked, and not on the front:
    hz 60, precision double: crashed: of old age

   hz  precision  x real time  ms per s             range  position    floor  horizon, s
  --------------------------------------------------------------------------------------------------------
   60  single           13330    0.0750  0.0600 .. 0.0900    0.0250  0.00100        1.50  front
  120  single            6667     0.150    0.120 .. 0.180    0.0125  0.00100        1.50  front
  120  double            3333     0.300    0.240 .. 0.360   0.00833  0.00100        1.50  front
  240  single            3333     0.300    0.240 .. 0.360   0.00625   0.0100        1.50  tie, below floor
   60  double            6667     0.150    0.120 .. 0.180    0.0167  0.00100        1.50  crashed
  Median over 2 repeats per cycle, then mean over cycles; range over all draws of repeats.
  tie: every configuration that is as fast and as accurate lies within the range and the floor.

position, * front, = tie, x void
   0.0250 |                                                           *
          |
          |
          |
          |
          |                              x
          |
          |
          |                              *
          |
          |
          |=
          |
  0.00833 |*
          +------------------------------------------------------------
           3333                    x real time                    13330

An error below its floor is not significant: the reference changes by as much with twice its time step and a displaced start.
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
  EXPECT_NE(text.find("0.0125"), std::string::npos) << text;
  EXPECT_NE(text.find("0.00833"), std::string::npos) << text;
}

TEST(ShowError, NamesWhatThereIs) {
  const auto said = [](const figures::ErrorOptions& options) -> std::string {
    try {
      ShownError(options);
    } catch (const files::StoreError& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_EQ(
      said({"energy", {}, {}}),
      "there is no error 'energy' in this file; there are position, pairs_missed, pairs_phantom");
  EXPECT_EQ(said({"position", {"size"}, {}}), "there is no axis 'size'; there are hz, precision");
}

}  // namespace
}  // namespace cdb::tests
