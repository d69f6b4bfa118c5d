#include "library/closed_forms/closed_form.h"

#include <algorithm>
#include <iterator>

#include "compiler/schema/catalogue_table.h"
#include "dsl/text/check.h"
#include "library/closed_forms/fit.h"

namespace cdb::closed_forms {

using MakeForm = std::unique_ptr<ClosedForm>(const Fit& fit);

// Each is in the file of its name; slide and stick in incline.cc, roll and bowl in
// ball_on_floor.cc, flip in spin.cc.
MakeForm MakeFlight, MakeBounce, MakeOblique, MakeHeadOn, MakeSlide, MakeStick, MakeBraking,
    MakeRoll, MakeBowl, MakeRolling, MakeStack, MakeSpin, MakeFlip, MakeSpring, MakePendulum;

namespace {

struct Row {
  std::string_view name;
  MakeForm* make;
};

/// A name that is not in the table is a compile error.
consteval Row Of(std::string_view name, MakeForm* make) {
  for (const schema::ClosedFormInfo& info : schema::kClosedFormTable)
    if (info.name == name) return {name, make};
  throw "no such closed form in the table";
}

constexpr Row kForms[] = {
    Of("flight", MakeFlight),   Of("bounce", MakeBounce), Of("oblique", MakeOblique),
    Of("head_on", MakeHeadOn),  Of("slide", MakeSlide),   Of("stick", MakeStick),
    Of("braking", MakeBraking), Of("roll", MakeRoll),     Of("bowl", MakeBowl),
    Of("rolling", MakeRolling), Of("stack", MakeStack),   Of("spin", MakeSpin),
    Of("flip", MakeFlip),       Of("spring", MakeSpring), Of("pendulum", MakePendulum),
};
static_assert(std::size(kForms) == std::size(schema::kClosedFormTable),
              "a form of the table is missing");

}  // namespace

std::unique_ptr<ClosedForm> MakeClosedForm(std::string_view name, const plan::Scene& scene,
                                           const layouts::InitialState& state) {
  const auto* row = std::ranges::find(kForms, name, &Row::name);
  CDB_CHECK(row != std::end(kForms));
  return row->make(Fit(name, scene, state));
}

}  // namespace cdb::closed_forms
