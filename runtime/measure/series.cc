#include "runtime/measure/series.h"

#include <algorithm>

#include "compiler/analysis/capacity.h"
#include "compiler/analysis/trace.h"
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
    {"kinetic_energy", "energy stability", kFloat64, kScalar, "J",
     "kinetic energy of translation and rotation"},
    {"energy", "energy stability", kFloat64, kScalar, "J",
     "kinetic and potential energy, including springs, with the integrator's own term, dt F.v / 2"},
    {"max_penetration", "stability", kFloat64, kScalar, "m",
     "depth of the deepest contact; 0 if none overlaps"},
    {"penetration_ratio", "stability", kFloat64, kScalar, "",
     "depth of the deepest contact over the least side of the smaller object"},
    {"max_speed", "stability", kFloat64, kScalar, "m/s",
     "highest speed of any object's centre of mass"},
    {"escaped", "stability", kInt32, kScalar, "", "objects with their centre beyond a wall"},
    {"asleep", "stability", kInt32, kScalar, "", "objects that Bullet has put to sleep"},
    {"removed", "stability", kInt32, kScalar, "",
     "objects that Bullet has switched off, or whose box it cannot hold"},
    {"non_finite", "stability", kInt32, kScalar, "", "objects with a state that is not finite"},
    {"displacement", "stability", kFloat64, kScalar, "",
     "largest displacement of an object since the first cycle, over its least side"},
    {"displaced", "stability", kInt32, kScalar, "",
     "objects displaced since the first cycle by more than a quarter of their least side"},
    {"motion_ratio", "stability", kFloat64, kScalar, "",
     "distance moved over the expected distance, |v| dt, since the object was last pushed, of the "
     "object where this is farthest from 1"},
    {"fall_ratio", "stability", kFloat64, kScalar, "",
     "least gain of speed over that due to gravity, dv / (g dt), since the last contact"},
    {"frozen", "stability", kInt32, kScalar, "",
     "objects whose displacement or fall is off by more than a tenth, because of rounding"},
    {"lost_way", "stability", kFloat64, kScalar, "",
     "largest distance that rounding added to or took from the motion of an object since it was "
     "last pushed, over its least side"},
    {"turn_ratio", "stability", kFloat64, kScalar, "",
     "least angle turned over the expected angle, of the objects that rotate"},
    {"spin_ratio", "stability", kFloat64, kScalar, "",
     "rotational energy over that before the first cycle, of the object without any contact since "
     "then for which this is farthest from 1"},
    {"passed", "stability", kInt32, kScalar, "",
     "objects whose centre of mass has passed through another object, detected in this cycle"},
    {"pressed", "stability", kInt32, kScalar, "",
     "pairs of bodies that a load presses into each other, by more than a quarter of the smaller "
     "one's least side"},
    {"inverted", "stability", kInt32, kScalar, "",
     "pairs of objects in which the object that lay on top is now below the other"},
    {"unheld", "stability", kInt32, kScalar, "",
     "objects asleep in the air or on a slope that does not hold them"},
    {"lost_energy", "stability", kFloat64, kScalar, "",
     "energy lost, except to friction, inelastic bounces and sleep, over the largest kinetic "
     "energy "
     "so far and that of a small fall"},
    {"heap", "memory", kFloat64, kScalar, "bytes", "heap in use after the cycle", true},
    {"joint_gap", "stability", kFloat64, kScalar, "m",
     "largest gap of a joint: distance of its two pivots"},
    {"poses", "poses", kFloat64, kPose, "",
     "centre of mass and orientation quaternion after the cycle"},
    {"boxes", "boxes", kFloat64, kBox, "m",
     "boxes passed to the broad phase in the cycle; the box of a plane is infinite, an omitted "
     "wall "
     "has none"},
    {"box_filters", "boxes", kFloat64, kFilter, "",
     "bits of the group of the body and of the groups that it may collide with, and 1 if it is "
     "fixed; float64, as masks have 32 bits"},
    {"exact_pairs", "pairs", kInt32, kScalar, "",
     "pairs that may collide and whose boxes overlap, by brute force in double precision", true},
    {"missed_pairs", "pairs", kInt32, kScalar, "", "exact pairs that the detector did not list",
     true},
    {"phantom_pairs", "pairs", kInt32, kScalar, "",
     "pairs that the detector listed although their boxes do not overlap", true},
    {"duplicate_pairs", "pairs", kInt32, kScalar, "", "pairs that the detector listed again", true},
    {"exact_contacts", "pairs", kInt32, kScalar, "",
     "exact overlaps deeper than a ten thousandth of the size of the smaller object"},
    {"missed_contacts", "pairs", kInt32, kScalar, "", "exact overlaps that have no contact"},
    {"unsure_contacts", "pairs", kInt32, kScalar, "",
     "pairs whose depth is not known to a billionth of the size, and which were not compared"},
    {"depth_error", "pairs", kFloat64, kScalar, "",
     "mean error of the depth of exact overlaps, in sizes of the smaller object"},
    {"normal_error", "pairs", kFloat64, kScalar, "rad",
     "mean error of the normals of exact overlaps"},
};

constexpr std::string_view kPhases[kPhaseCount] = {"broad", "narrow",    "detect",
                                                   "solve", "integrate", "step"};
constexpr std::string_view kPoseComponents[kPoseSize] = {"x", "y", "z", "qx", "qy", "qz", "qw"};
constexpr std::string_view kBounds[kBoxSize] = {"lower_x", "lower_y", "lower_z",
                                                "upper_x", "upper_y", "upper_z"};
constexpr std::string_view kFilterComponents[kFilterSize] = {"group", "mask", "fixed"};

/// In the order of Dimension.
constexpr DimensionInfo kDimensions[] = {
    {"phase", "part of a cycle that is timed", kPhases},
    {"cycle", "recorded cycle"},
    {"body", "object, in the order of its group and within it"},
    {"pose", "centre of mass and orientation quaternion", kPoseComponents, "m m m 1 1 1 1"},
    {"box_body", "object as of `body`, then the walls -x +x -y +y -z +z"},
    {"bound", "side of a box", kBounds},
    {"filter", "collision filter of a body", kFilterComponents},
    {"sample", "simulated time of a sample, warm-up included"},
};

std::uint64_t ExtentOf(Dimension dimension, const RunExtents& run) {
  switch (dimension) {
    case Dimension::kCycle:
      return run.cycles;
    case Dimension::kBody:
      return run.objects;
    case Dimension::kBoxBody:
      return run.bodies;
    default:
      return InfoOf(dimension).labels.size();
  }
}

}  // namespace

const DimensionInfo& InfoOf(Dimension dimension) {
  return kDimensions[static_cast<std::size_t>(dimension)];
}

std::span<const Dimension> DimensionsOf(SeriesShape shape) {
  using enum Dimension;
  static constexpr Dimension kOfScalar[] = {kCycle}, kOfPhase[] = {Dimension::kPhase, kCycle},
                             kOfPose[] = {kCycle, kBody, Dimension::kPose},
                             kOfBox[] = {kCycle, kBoxBody, kBound},
                             kOfFilter[] = {kBoxBody, Dimension::kFilter},
                             kOfSample[] = {Dimension::kSample};
  switch (shape) {
    case SeriesShape::kScalar:
      return kOfScalar;
    case SeriesShape::kPhase:
      return kOfPhase;
    case SeriesShape::kPose:
      return kOfPose;
    case SeriesShape::kBox:
      return kOfBox;
    case SeriesShape::kFilter:
      return kOfFilter;
    case SeriesShape::kSample:
      return kOfSample;
  }
  return {};
}

RunExtents ExtentsOf(const plan::Scene& scene) {
  return {scene.world.Count("cycles"), scene.ObjectCount(), analysis::BodyCount(scene)};
}

std::optional<std::size_t> Series::CycleDimension() const {
  const auto dimensions = DimensionsOf(shape);
  const auto found = std::ranges::find(dimensions, Dimension::kCycle);
  if (found == dimensions.end()) return std::nullopt;
  return static_cast<std::size_t>(found - dimensions.begin());
}

std::vector<std::uint64_t> Series::Extents(const RunExtents& run) const {
  std::vector<std::uint64_t> extents;
  for (const Dimension dimension : DimensionsOf(shape)) extents.push_back(ExtentOf(dimension, run));
  return extents;
}

std::size_t Series::ValueCount(const RunExtents& run) const {
  std::size_t count = 1;
  for (const std::uint64_t extent : Extents(run)) count *= extent;
  return count;
}

bool Series::IsRecordedBy(const plan::Scene& scene) const {
  if (!on_traces && analysis::TraceOf(scene)) return false;
  const auto* asked = std::get_if<schema::WordList>(&scene.world.Get("record"));
  return asked != nullptr &&
         std::any_of(asked->begin(), asked->end(),
                     [&](const std::string& word) { return schema::ListsWord(records, word); });
}

bool Series::IsRecordedBy(const plan::Plan& plan) const {
  return std::ranges::any_of(plan.Bounds(),
                             [&](const plan::Run& run) { return IsRecordedBy(run.scene); });
}

std::span<const Series> AllSeries() { return kSeries; }

const Series* FindSeries(std::string_view name) {
  const auto* row = std::find_if(std::begin(kSeries), std::end(kSeries),
                                 [&](const Series& series) { return series.name == name; });
  return row == std::end(kSeries) ? nullptr : row;
}

std::span<const std::string_view> PhaseNames() { return kPhases; }

}  // namespace cdb::measure
