#include "runtime/pages/view/selection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

using ::testing::HasSubstr;

template <typename Act>
std::string MessageOf(Act act) {
  try {
    act();
  } catch (const files::StoreError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Selection, FindsCoordinatesByTextAndByNearlyEqualNumbers) {
  const std::vector<plan::Axis> axes = {NumberAxis("dt", {1.0 / 60, 1.0 / 120}),
                                        TextAxis("detector", {"simple", "dbvt"})};
  results::ResultFile::Cell cell{{0, 0}, 0};
  view::Select(axes, 3,
               {figures::ParseSelection("dt=0.008333"), figures::ParseSelection("detector=dbvt"),
                figures::ParseSelection("rep=2")},
               cell);
  EXPECT_EQ(cell.at, (std::vector<std::size_t>{1, 1}));
  EXPECT_EQ(cell.rep, 2U);
  EXPECT_EQ(view::CellName(axes, 3, cell), "dt 0.008333, detector dbvt, rep 2");
  EXPECT_EQ(view::CellName({}, 1, {{}, 0}), "");
}

TEST(Selection, RefusesByName) {
  const std::vector<plan::Axis> axes = {TextAxis("detector", {"simple", "dbvt"})};
  results::ResultFile::Cell cell{{0}, 0};
  const auto select = [&](const char* word) {
    return MessageOf([&] { view::Select(axes, 2, {figures::ParseSelection(word)}, cell); });
  };
  EXPECT_EQ(select("detector"),
            "'detector' selects nothing; write AXIS=VALUE, such as detector=dbvt");
  EXPECT_EQ(select("detector=sap"), "detector=sap: the axis has the values simple, dbvt");
  EXPECT_EQ(select("detector=simple,dbvt"),
            "detector=simple,dbvt: there are several; the axis has the values simple, dbvt");
  EXPECT_EQ(select("detector=sap,size=1"),
            "detector=sap,size=1: this needs one value of the axis; for several axes, repeat the "
            "option: --select detector=… --select OTHER=…");
  EXPECT_EQ(select("size=1"), "there is no axis 'size'; there are detector, rep");
  EXPECT_EQ(select("rep=2"), "rep=2: the repeats are 0 to 1");
}

}  // namespace
}  // namespace cdb::tests
