// Compiled by named_parameters_test.py: without FAULTS it must compile; with FAULTS the compiler
// must reject each line that ends in `refused:` and the reason, and no other line.
#include "compiler/plan/plan.h"
#include "compiler/schema/series.h"
#include "library/layouts/initial_state.h"

namespace cdb::tests {

plan::WorldSettings& World();
plan::GroupSettings& Objects();
layouts::DrawnNumbers& Numbers();

double Read() {
  return World().Real("timestep") + World().Real("cycles") + Objects().Real("size") +
         static_cast<double>(World().Count("cycles")) + (World().On("sleeping") ? 1 : 0) +
         static_cast<double>(World().WordOr("timeout").size() + Objects().WordOr("mass").size()) +
         World().Vector("acceleration").x() + (World().Lists("record", "timing") ? 1 : 0);
}

bool Ints(schema::IntSeries series);
bool Reals(schema::RealSeries series);
bool ReadSeries() { return Ints("pairs") && Reals("duration"); }

void Write() { World().Set("cycles", std::uint64_t{1}); }

void SetFriction() { Numbers()["friction"] = Numbers().On("ccd") ? 1 : 0; }

#if defined(FAULTS)
// clang-format off

void MisspeltReal() { World().Real("timestop"); }         // refused: NoSuchParameter
void MisspeltGet() { World().Get("Timestep"); }           // refused: NoSuchParameter
void MisspeltSet() { World().Set("cycle", 1.0); }         // refused: NoSuchParameter
void WorldFromGroup() { Objects().Real("timestep"); }     // refused: NoSuchParameter
void GroupFromWorld() { World().Real("size"); }           // refused: NoSuchParameter
void RealOfWord() { World().Real("detector"); }           // refused: ParameterHasAnotherKind
void CountOfSwitch() { World().Count("sleeping"); }       // refused: ParameterHasAnotherKind
void CountOfReal() { World().Count("timestep"); }         // refused: ParameterHasAnotherKind
void SwitchOfCount() { World().On("cycles"); }            // refused: ParameterHasAnotherKind
void WordOfReal() { World().WordOr("timestep"); }         // refused: ParameterHasAnotherKind
void WordOfList() { World().WordOr("record"); }           // refused: ParameterHasAnotherKind
void VectorOfReal() { Objects().Vector("size"); }         // refused: ParameterHasAnotherKind
void ListOfWord() { World().Lists("detector", "dbvt"); }  // refused: ParameterHasAnotherKind
void MisspeltSeries() { Ints("typo"); }                   // refused: NoSuchSeries
void IntsOfReals() { Ints("duration"); }                  // refused: SeriesHasAnotherType
void RealsOfInts() { Reals("pairs"); }                    // refused: SeriesHasAnotherType
void MisspeltNumber() { Numbers()["frictoin"] = 1; }      // refused: NoSuchParameter
void NumberOfVector() { Numbers()["linear_velocity"] = 1; }  // refused: ParameterHasAnotherKind
void RunTimeName(const char* name) { World().Real(name); }  // refused: constant expression

// clang-format on
#endif

}  // namespace cdb::tests
