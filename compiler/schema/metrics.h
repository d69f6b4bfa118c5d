// THE table of errors that a run can be held to: the words of `accuracy.metrics`, and the arrays of
// /accuracy that each makes. Checker, `cdb doc accuracy`, results and `cdb show --error` read it.
#pragma once

#include <span>
#include <string_view>

namespace cdb::schema {

/// How the errors at a run's samples become one number.
enum class Fold {
  kRms,
  kMean,
  kMax,
  kMeanOfSome,  ///< over the samples that have a value: a sample may have nothing to look at
};

/// The errors that there are, in the order of the table.
enum class ErrorKind {
  kPosition,
  kVelocity,
  kRotation,
  kEnergy,
  kMomentum,
  kAngularMomentum,
  kPenetration,
  kPenetrationMax,
  kHeight,
  kHeightW1,
  kContacts,
  kPairsMissed,
  kPairsPhantom,
  kDepthError,
  kNormalError,
  kContactsMissed,
};

/// One number of a run at each sample.
struct ErrorInfo {
  ErrorKind kind;
  std::string_view name;    ///< of its array, `/accuracy/NAME`, and for `cdb show --error`
  std::string_view series;  ///< of the array with its value at each sample
  std::string_view metric;  ///< the word of `accuracy.metrics` that asks for it
  std::string_view unit;    ///< empty where it has none
  std::string_view doc;     ///< one line
  bool needs_truth;         ///< a closed form or a reference run; else it is the run's own
  bool to_horizon;          ///< says something only as long as the reference is sure of itself
  Fold fold;
};
std::span<const ErrorInfo> Errors();

/// One word of `accuracy.metrics`, for the checker and the reference.
struct Metric {
  std::string_view name;
};
std::span<const Metric> Metrics();

}  // namespace cdb::schema
