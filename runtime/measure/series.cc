#include "runtime/measure/series.h"

#include <algorithm>

#include "compiler/plan/trace.h"
#include "compiler/schema/schema.h"

namespace cdb::measure {
namespace {

using enum SeriesType;
using enum SeriesShape;

constexpr Series kSeries[] = {
    {"duration", "timing", kFloat64, kPhase, "ns", "time of each phase of a cycle", true},
    {"pairs", "counts stability", kInt32, kScalar, "",
     "potentially colliding pairs of the broad phase", true},
    {"manifolds", "counts stability", kInt32, kScalar, "", "contact manifolds that hold a point"},
    {"contacts", "counts contacts stability", kInt32, kScalar, "", "contact points"},
    {"kinetic_energy", "energy stability", kFloat64, kScalar, "J", "translation and rotation"},
    {"energy", "energy stability", kFloat64, kScalar, "J",
     "kinetic and potential energy, that of springs too, with the integrator's own term, dt F.v / "
     "2"},
    {"max_penetration", "stability", kFloat64, kScalar, "m",
     "deepest contact; 0 where none overlaps"},
    {"penetration_ratio", "stability", kFloat64, kScalar, "",
     "deepest contact over the least side of the smaller object"},
    {"max_speed", "stability", kFloat64, kScalar, "m/s", "of any object's centre of mass"},
    {"escaped", "stability", kInt32, kScalar, "", "objects with their centre beyond a wall"},
    {"asleep", "stability", kInt32, kScalar, "", "objects that Bullet has put to sleep"},
    {"removed", "stability", kInt32, kScalar, "",
     "objects that Bullet has switched off, or whose box it cannot hold"},
    {"non_finite", "stability", kInt32, kScalar, "", "objects with a state that is not a number"},
    {"displacement", "stability", kFloat64, kScalar, "",
     "farthest way of an object from its place before the first cycle, over its least side"},
    {"motion_ratio", "stability", kFloat64, kScalar, "",
     "way gone over way to go, |v| dt, since it was last pushed, of the object where it is "
     "farthest "
     "from 1"},
    {"fall_ratio", "stability", kFloat64, kScalar, "",
     "least gain of speed over what gravity gives, dv / (g dt), since the last contact"},
    {"turn_ratio", "stability", kFloat64, kScalar, "",
     "least angle turned over angle to turn, of the objects that turn"},
    {"heap", "memory", kFloat64, kScalar, "bytes", "heap in use after the cycle", true},
    {"joint_gap", "stability", kFloat64, kScalar, "m",
     "largest gap of a joint: distance of its two pivots"},
    {"poses", "poses", kFloat64, kPose, "",
     "centre of mass and orientation quaternion after the cycle"},
    {"boxes", "boxes", kFloat64, kBox, "m",
     "as the broad phase was given them in the cycle; a plane's is infinite, a wall that is left "
     "out has none"},
    {"box_filters", "boxes", kFloat64, kFilter, "",
     "whom a body may meet: two may where each one's group is in the other's mask and not both "
     "are fixed"},
    {"exact_pairs", "pairs", kInt32, kScalar, "",
     "pairs that may collide and whose boxes overlap, by brute force in double", true},
    {"missed_pairs", "pairs", kInt32, kScalar, "", "of those, pairs that the detector did not list",
     true},
    {"phantom_pairs", "pairs", kInt32, kScalar, "",
     "pairs that the detector listed and whose boxes do not overlap", true},
    {"duplicate_pairs", "pairs", kInt32, kScalar, "", "pairs that the detector listed again", true},
    {"missed_contacts", "pairs", kInt32, kScalar, "",
     "overlaps known in closed form that have no contact"},
    {"depth_error", "pairs", kFloat64, kScalar, "",
     "mean error of the depth of the others, in sizes of the smaller object"},
    {"normal_error", "pairs", kFloat64, kScalar, "rad", "mean error of their normals"},
};

constexpr std::string_view kPhaseNames[] = {"broad", "narrow",    "detect",
                                            "solve", "integrate", "step"};

}  // namespace

std::size_t Series::ValueCount(std::uint64_t cycles, std::uint64_t objects,
                               std::uint64_t bodies) const {
  switch (shape) {
    case kScalar:
      return cycles;
    case kPhase:
      return cycles * kPhaseCount;
    case kPose:
      return cycles * objects * kPoseSize;
    case kBox:
      return cycles * bodies * kBoxSize;
    case kFilter:
      return bodies * kFilterSize;
    case kSample:
      break;
  }
  return 0;
}

bool Series::IsRecordedBy(const plan::Scene& scene) const {
  if (!on_traces && plan::TraceOf(scene)) return false;
  const auto* asked = std::get_if<schema::WordList>(&scene.world.Get("record"));
  return asked != nullptr &&
         std::any_of(asked->begin(), asked->end(),
                     [&](const std::string& word) { return schema::ListsWord(records, word); });
}

bool Series::IsRecordedBy(const plan::Plan& plan) const {
  return std::any_of(plan.runs.begin(), plan.runs.end(),
                     [&](const plan::Run& run) { return IsRecordedBy(run.scene); });
}

std::span<const Series> AllSeries() { return kSeries; }

const Series* FindSeries(std::string_view name) {
  const auto* row = std::find_if(std::begin(kSeries), std::end(kSeries),
                                 [&](const Series& series) { return series.name == name; });
  return row == std::end(kSeries) ? nullptr : row;
}

std::span<const std::string_view> PhaseNames() { return kPhaseNames; }

}  // namespace cdb::measure
