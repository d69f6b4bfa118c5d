// THE table of errors that can be measured for a run: the words of `accuracy.metrics`, and the
// arrays that each adds to /accuracy. Checker, `cdb doc accuracy`, results and `cdb show --error`
// read it.
#pragma once

#include <span>
#include <string_view>

namespace cdb::schema {

/// How the errors at the samples of a run become one number.
enum class Fold {
  kRms,
  kMean,
  kMax,
  kMeanOfSome,  ///< over the samples with a value: a sample may have nothing to measure
};

/// The errors, in the order of the table.
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
  std::string_view series;  ///< the array with its value at each sample
  std::string_view metric;  ///< the word of `accuracy.metrics` that requests it
  std::string_view unit;    ///< empty if it has none
  std::string_view doc;     ///< one line
  bool needs_truth;         ///< a closed form or a reference run; else only the run itself
  bool to_horizon;          ///< meaningful only as long as the reference is reliable
  Fold fold;
};
std::span<const ErrorInfo> Errors();

/// One word of `accuracy.metrics`, for the checker and the reference.
struct Metric {
  std::string_view name;
};
std::span<const Metric> Metrics();

}  // namespace cdb::schema
