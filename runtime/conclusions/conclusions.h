// The answers that a sweep gives, in sentences: which configuration is best at what, by how much
// and with what certainty, and what was wrong with it. Chosen from what the file sweeps.
//
// A difference is clear if the 95 % interval of the ratio (cycle_times.h) excludes 1, and a tie if
// it does not. With fewer repeats than an interval takes, it is unknown.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/findings.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::conclusions {

enum class Certainty { kClear, kTie, kUnknown };
/// `clear`, `tie`, `unknown`.
std::string_view CertaintyName(Certainty certainty);

struct Conclusion {
  std::string question, answer;  ///< whole sentences
  std::string_view kind;         ///< `fastest`, `growth`: for a reader that chooses among them
  Certainty certainty;
};

struct ConclusionParts {
  const store::ResultFile& file;
  const std::vector<statistics::MeasuredPoint>& points;
  const std::vector<statistics::DetectorFindings>& findings;
  statistics::CycleTimes& times;
  bool only_sound;  ///< `points` are without void ones
};

/// The first answers what the sweep asks first. Empty where nothing was measured. Throws
/// StoreError.
std::vector<Conclusion> Conclusions(const ConclusionParts& parts);

// The parts of it, each for one kind of sweep.
/// Of the axis of detectors: missed pairs, time of a step and of detect, growth.
void ConcludeDetectors(const ConclusionParts& parts, std::vector<Conclusion>& all);
/// Of the axis of detectors: worst cycle and memory.
void ConcludeDetectorLimits(const ConclusionParts& parts, std::vector<Conclusion>& all);
/// How the time of a step changes along the other axes, and growth with the number of objects.
void ConcludeAxes(const ConclusionParts& parts, std::vector<Conclusion>& all);
/// Of each error: the most accurate configuration within real time, and the fastest of the front.
void ConcludeErrors(const ConclusionParts& parts, std::vector<Conclusion>& all);
/// Where the simulation stops being sound.
void ConcludeVerdicts(const ConclusionParts& parts, std::vector<Conclusion>& all);
/// What a step takes, and its largest phase: for a file without axes.
void ConcludeStep(const ConclusionParts& parts, std::vector<Conclusion>& all);

}  // namespace cdb::conclusions
