// The conclusions of a sweep, in sentences: the best configuration for each purpose, its margin,
// the certainty, and any faults. They are chosen by what the file sweeps.
//
// A difference is clear if the 95 % interval of the ratio (times.h) excludes 1, and a tie if
// it does not. With too few repeats for an interval, it is unknown.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cdb::figures {

/// kFault: something is wrong for certain, such as an unsound simulation or a missed pair.
enum class Certainty { kClear, kTie, kUnknown, kFault };
/// `clear`, `tie`, `unknown`, `fault`.
std::string_view CertaintyName(Certainty certainty);

/// The change of a time from the first to the last value of an axis, as the answer states it.
struct Effect {
  std::string axis, from, to;
  double ratio = 0;
  std::optional<std::pair<double, double>> interval;
};

struct Conclusion {
  std::string question, answer;  ///< whole sentences
  std::string_view kind;         ///< `fastest`, `growth`: for readers that select among them
  Certainty certainty;
  std::optional<Effect> effect = {};  ///< of `scaling` along numbers
};

class Model;

/// A sentence for answers on times of a single repeat.
inline std::string OneRepeatNote() {
  return " One repeat: there is no interval; `repeats 5` gives one.";
}

/// The first conclusion answers the main question of the sweep. Empty if nothing was measured.
/// Throws StoreError.
std::vector<Conclusion> Conclusions(const Model& model);

// The parts of Conclusions, each for one kind of sweep. For the axis of detectors: missed pairs,
// times of step and detect, growth.
void ConcludeDetectors(const Model& model, std::vector<Conclusion>& all);
/// For the axis of detectors: worst cycle and memory.
void ConcludeDetectorLimits(const Model& model, std::vector<Conclusion>& all);
/// The change of the time of a step along the other axes, and its growth with the number of
/// objects.
void ConcludeAxes(const Model& model, std::vector<Conclusion>& all);
/// The effects of each parameter along axes of sampled points.
void ConcludeEffects(const Model& model, std::vector<Conclusion>& all);
/// The configurations within the `budget` of the scenario.
void ConcludeBudget(const Model& model, std::vector<Conclusion>& all);
/// For each error: the most accurate configuration within real time, and the fastest of the front.
void ConcludeErrors(const Model& model, std::vector<Conclusion>& all);
/// The limits of sound simulation.
void ConcludeVerdicts(const Model& model, std::vector<Conclusion>& all);
/// The time of a step and its largest phase, for a file without axes.
void ConcludeStep(const Model& model, std::vector<Conclusion>& all);

}  // namespace cdb::figures
