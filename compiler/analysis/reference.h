// Samples and references of a scene: which runs serve as ground truth. They follow from the scenes
// alone, so that every process derives the same ones.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// When a run is sampled: at the start and then every `interval_s` of simulated time.
struct Sampling {
  double interval_s = 0;
  std::uint64_t cycles = 0;  ///< from one sample to the next, warm-up cycles too
  std::uint64_t count = 0;   ///< with the one at the start
  bool operator==(const Sampling&) const = default;
};

/// Why the errors that a scene asks for cannot be had; no parameter where they can.
struct AccuracyFault {
  const schema::Parameter* parameter = nullptr;  ///< to be changed: `accuracy.interval`, `cycles`
  std::string message;                           ///< what is wrong
  std::string help;                              ///< what would do
};
AccuracyFault FindAccuracyFault(const plan::Scene& scene);

/// What follows is for scenes without such a fault (CDB_CHECK).

/// Nullopt where the scene asks for no errors.
std::optional<Sampling> SamplingOf(const plan::Scene& scene);

/// So many steps of `timestep_s` are `span_s` to a part in 10^9; nullopt where none are.
std::optional<std::uint64_t> WholeSteps(double span_s, double timestep_s);

/// Some error that it asks for needs the truth, and it names no closed form.
bool NeedsReference(const plan::Scene& scene);

/// The scene that stands for the truth of `scene`: from the same start over the same time with the
/// reference's time step, precision, detector, iterations and contact settings; nothing is recorded
/// but samples. Equal for scenes that differ only in what is replaced, so that they share it.
plan::Scene ReferenceOf(const plan::Scene& scene);

/// The reference with every object's start moved by kNudge of its size: how far the two part shows
/// how long the reference is sure of itself.
plan::Scene PerturbedOf(plan::Scene reference);
inline constexpr double kPerturbation = 1e-9;

/// Fills `references` of the plan and names them in its runs.
void AddReferences(plan::Plan& plan);

}  // namespace cdb::analysis
