#include "library/closed_forms/closed_form.h"

#include <algorithm>

#include "dsl/text/check.h"
#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {
namespace {

struct Row {
  std::string_view name;
  std::unique_ptr<ClosedForm> (*make)(const Fit& fit);
};

constexpr Row kForms[] = {
    {"flight", MakeFlight},   {"bounce", MakeBounce}, {"oblique", MakeOblique},
    {"head_on", MakeHeadOn},  {"slide", MakeSlide},   {"stick", MakeStick},
    {"braking", MakeBraking}, {"roll", MakeRoll},     {"bowl", MakeBowl},
    {"rolling", MakeRolling}, {"stack", MakeStack},   {"spin", MakeSpin},
    {"flip", MakeFlip},       {"spring", MakeSpring}, {"pendulum", MakePendulum},
};

}  // namespace

std::unique_ptr<ClosedForm> MakeClosedForm(std::string_view name, const plan::Scene& scene,
                                           const layouts::InitialState& state) {
  const auto* row = std::ranges::find(kForms, name, &Row::name);
  CDB_CHECK(row != std::end(kForms));
  return row->make(Fit(name, scene, state));
}

}  // namespace cdb::closed_forms
