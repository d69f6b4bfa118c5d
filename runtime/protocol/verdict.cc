#include "runtime/protocol/verdict.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "compiler/analysis/expectation.h"
#include "compiler/analysis/soft.h"
#include "dsl/text/check.h"

namespace cdb::protocol {
namespace {

using analysis::Expectation;
using enum Verdict;

// Thresholds found by measurement. Lengths are in sides of the object, energies in the run's energy
// scale.
constexpr double kFrozenPart = 0.01, kCollapsedPart = 0.01;  ///< fractions of the objects
constexpr double kLeastTurn = 0.9;
constexpr double kExplosion = 1, kDrift = 0.01;
constexpr double kLost = 0.1, kGained = 0.1, kSpinDrift = 0.03;
constexpr double kLateDepth = 0.05, kPeakDepth = 0.25;
constexpr double kFrictionError = 0.05;  ///< and of rolling
constexpr double kImpactError = 0.125;
constexpr double kBend = 0.05, kStretch = 0.02;
constexpr double kMotorError = 0.1;
constexpr double kSoftStretch = 0.1;  ///< of a link of a soft body, over its rest length
constexpr double kLateSpeed = 0.02;   ///< fraction of the speed scale
/// The fraction of a run, at its end, that counts as late.
constexpr double kLate = 0.25;

/// A criterion: the series that it judges, and the first bad cycle, or -1.
struct Found {
  std::string_view series;
  std::int64_t cycle = -1;
};

/// Applies every criterion to one run.
class Case {
 public:
  Case(const plan::Scene& scene, const Recording& recording, std::uint64_t n_cycles)
      : scene_(scene),
        recording_(recording),
        scales_(recording.header().scales),
        n_(n_cycles),
        late_(n_cycles -
              static_cast<std::size_t>(std::ceil(kLate * static_cast<double>(n_cycles)))),
        expectation_(analysis::ExpectationOf(scene)),
        energy_scales_(EnergyScales()) {}

  /// The criterion that is met first. A later one of the list counts only if it is met earlier.
  Found First(Verdict verdict) const {
    Found first;
    for (const Found& found : CriteriaOf(verdict))
      if (found.cycle >= 0 && (first.cycle < 0 || found.cycle < first.cycle)) first = found;
    return first;
  }

  /// The largest of the counts of this verdict's criteria in a cycle; -1 if it applies to no single
  /// object.
  std::int64_t BadObjects(Verdict verdict) const {
    std::int64_t most = 0;
    for (const schema::IntSeries series : CountsOf(verdict))
      for (const std::int32_t count : Ints(series)) most = std::max<std::int64_t>(most, count);
    return most > 0 ? most : -1;
  }

 private:
  std::vector<Found> CriteriaOf(Verdict verdict) const {
    switch (verdict) {
      case kNonFinite:
        return {Count("non_finite")};
      case kRemoved:
        return {Count("removed")};
      case kFrozen:
        return {Share("frozen", kFrozenPart)};
      case kExploded:
        return {{"energy", FirstRise(kExplosion)}};
      case kTunnelled:
        return {{"escaped", LastStretch("escaped")}, Count("passed")};
      case kClamped:
        return {Where("turn_ratio", [](double x) { return x < kLeastTurn; }), Count("frozen")};
      case kCollapsed:
        return IfResting({{"inverted", LastStretch("inverted")}, Count("unheld")},
                         {Share("displaced", kCollapsedPart)});
      case kPenetrating:
        return IfResting({Late("penetration_ratio", kLateDepth),
                          Late("joint_gap", kLateDepth * scales_.least_side),
                          Late("joint_bend", kBend),
                          Late("joint_stretch", kStretch),
                          Count("pressed"),
                          {"inside", LastStretch("inside")},
                          {"self_crossings", LastStretch("self_crossings")},
                          {"inverted_tetrahedra", LastStretch("inverted_tetrahedra")}},
                         {Above("penetration_ratio", kPeakDepth)});
      case kDrifting: {
        std::vector<Found> all =
            IfResting({{"energy", FirstRise(kDrift)},
                       Above("lost_energy", kLost),
                       Count("deflected"),
                       Above("gained_energy", kGained),
                       Above("friction_error", kFrictionError),
                       Count("twisted"),
                       Late("motor_error", kMotorError),
                       Above("impact_error", kImpactError),
                       Where("spin_ratio", [](double x) { return std::abs(x - 1) > kSpinDrift; })},
                      {Late("max_speed", kLateSpeed * scales_.speed_scale), Count("displaced")});
        if (!MustRest()) all.push_back(Above("rolling_error", kFrictionError));
        // A spring may stretch as far as its stiffness lets it.
        if (scene_.world.WordOr("soft_world") != "springs")
          all.push_back(Above("stretch", kSoftStretch));
        if (expectation_ == Expectation::kEnergy) {
          all.push_back({"energy", FirstChange(n_, kDrift)});
        } else if (analysis::FliesFreely(scene_) && !analysis::HasSoft(scene_)) {
          const auto touch = FirstCount("contacts");
          const std::size_t end = touch < 0 ? n_ : static_cast<std::size_t>(touch);
          all.push_back({"energy", FirstChange(end, kSpinDrift)});
        }
        return all;
      }
      default:
        CDB_CHECK(false);
    }
  }

  /// With those of a scene that must rest.
  std::vector<Found> IfResting(std::vector<Found> always, const std::vector<Found>& resting) const {
    if (MustRest()) always.insert(always.end(), resting.begin(), resting.end());
    return always;
  }
  Found Count(schema::IntSeries series) const { return {series.name(), FirstCount(series)}; }
  Found Share(schema::IntSeries series, double share) const {
    return {series.name(), FirstShare(series, share)};
  }
  Found Above(schema::RealSeries series, double limit) const {
    return Where(series, [limit](double x) { return x > limit; });
  }
  Found Late(schema::RealSeries series, double limit) const {
    return {series.name(), LateAbove(series, limit)};
  }
  /// "No value" is never bad.
  Found Where(schema::RealSeries series, auto is_bad) const {
    return {series.name(), FirstIn(Reals(series), is_bad)};
  }

  std::vector<schema::IntSeries> CountsOf(Verdict verdict) const {
    switch (verdict) {
      case kNonFinite:
        return {"non_finite"};
      case kRemoved:
        return {"removed"};
      case kFrozen:
      case kClamped:
        return {"frozen"};
      case kTunnelled:
        return {"escaped", "passed"};
      case kCollapsed:
        if (MustRest()) return {"displaced", "unheld", "inverted"};
        return {"unheld", "inverted"};
      case kPenetrating:
        return {"pressed"};
      case kDrifting:
        if (MustRest()) return {"displaced", "deflected", "twisted"};
        return {"deflected", "twisted"};
      default:
        return {};
    }
  }

  bool MustRest() const { return expectation_ == Expectation::kRest; }

  std::span<const double> Reals(schema::RealSeries series) const {
    const auto all = recording_.Reals(series);
    return all.first(std::min(all.size(), n_));
  }
  std::span<const std::int32_t> Ints(schema::IntSeries series) const {
    const auto all = recording_.Ints(series);
    return all.first(std::min(all.size(), n_));
  }

  template <typename Values, typename IsBad>
  static std::int64_t FirstIn(const Values& values, IsBad is_bad, std::size_t from = 0) {
    if (from >= values.size()) return -1;
    const auto found = std::ranges::find_if(values.subspan(from), is_bad);
    return found == values.end() ? -1 : found - values.begin();
  }

  std::int64_t FirstCount(schema::IntSeries series) const {
    return FirstIn(Ints(series), [](std::int32_t count) { return count > 0; });
  }

  /// The first cycle in which the count is at least this fraction of the objects that can move.
  std::int64_t FirstShare(schema::IntSeries series, double share) const {
    return FirstIn(Ints(series), [&](std::int32_t count) {
      return count > 0 && count >= share * scales_.moving_objects;
    });
  }

  /// Bad if the median of the late part is above the limit; returns the first late cycle above it.
  std::int64_t LateAbove(schema::RealSeries series, double limit) const {
    const auto values = Reals(series);
    if (values.empty()) return -1;
    std::vector<double> late;
    std::ranges::copy_if(values.subspan(late_), std::back_inserter(late),
                         [](double x) { return !std::isnan(x); });
    if (late.empty()) return -1;
    const auto middle = late.begin() + static_cast<std::ptrdiff_t>(late.size() / 2);
    std::ranges::nth_element(late, middle);
    if (!(*middle > limit)) return -1;
    return FirstIn(
        values, [limit](double x) { return x > limit; }, late_);
  }

  /// J, by cycle. The scale of energies is that of the start, or the largest kinetic energy so far
  /// if that is more, without what the energy has risen: a fall gives a scale, a gain does not.
  std::vector<double> EnergyScales() const {
    const auto energy = Reals("energy"), kinetic = Reals("kinetic_energy");
    std::vector<double> scales;
    double least = scales_.initial_energy, scale = scales_.energy_scale;
    for (std::size_t i = 0; i < energy.size(); ++i) {
      least = std::min(least, energy[i]);
      if (i < kinetic.size()) scale = std::max(scale, kinetic[i] - (energy[i] - least));
      scales.push_back(scale);
    }
    return scales;
  }

  /// The first cycle in which the energy is above its least value so far by more than the limit.
  std::int64_t FirstRise(double limit) const {
    if (expectation_ == Expectation::kDriven) return -1;
    const auto energy = Reals("energy");
    double least = scales_.initial_energy;
    for (std::size_t i = 0; i < energy.size(); ++i) {
      if (energy[i] - least > limit * energy_scales_[i]) return static_cast<std::int64_t>(i);
      least = std::min(least, energy[i]);
    }
    return -1;
  }

  /// The first cycle before `end` in which the energy is not that of the start, within kDrift of
  /// the scale for a gain, and `loss` for a loss.
  std::int64_t FirstChange(std::size_t end, double loss) const {
    const auto energy = Reals("energy");
    for (std::size_t i = 0; i < std::min(end, energy.size()); ++i) {
      const double change = energy[i] - scales_.initial_energy;
      if (change > kDrift * energy_scales_[i] || -change > loss * energy_scales_[i])
        return static_cast<std::int64_t>(i);
    }
    return -1;
  }

  /// Bad if the count is positive at the end; returns the start of that stretch.
  std::int64_t LastStretch(schema::IntSeries series) const {
    const auto counts = Ints(series);
    if (counts.empty() || counts.back() <= 0) return -1;
    const auto none =
        std::find_if(counts.rbegin(), counts.rend(), [](std::int32_t count) { return count <= 0; });
    return counts.rend() - none;
  }

  const plan::Scene& scene_;
  const Recording& recording_;
  const VerdictScales& scales_;
  const std::size_t n_, late_;  ///< number of cycles; first late one
  const Expectation expectation_;
  const std::vector<double> energy_scales_;
};

}  // namespace

std::span<const VerdictInfo> Verdicts() { return schema::kVerdicts; }

std::string_view VerdictName(Verdict verdict) {
  const VerdictInfo& info = schema::kVerdicts[static_cast<std::size_t>(verdict)];
  CDB_CHECK(info.verdict == verdict);
  return info.name;
}

std::string VerdictText(const Judgement& judgement) {
  const std::string name(VerdictName(judgement.verdict));
  const bool says_more = !judgement.criterion.empty() && judgement.criterion != name;
  return says_more ? name + " (" + judgement.criterion + ")" : name;
}

Judgement Judge(const plan::Scene& scene, const Recording& recording, std::uint64_t n_cycles,
                Verdict outcome) {
  if (outcome != kUnknown) return {outcome, static_cast<std::int64_t>(n_cycles)};
  if (!scene.world.Lists("record", "stability")) return {};
  const Case here(scene, recording, n_cycles);
  for (auto verdict = static_cast<std::int8_t>(kNonFinite);
       verdict > static_cast<std::int8_t>(kStable); --verdict) {
    const Found first = here.First(Verdict{verdict});
    if (first.cycle >= 0)
      return {Verdict{verdict}, first.cycle, here.BadObjects(Verdict{verdict}),
              std::string(first.series)};
  }
  return {kStable, -1};
}

}  // namespace cdb::protocol
