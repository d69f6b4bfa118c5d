// THE table of errors that can be measured for a run: the words of `accuracy.metrics`, and the
// arrays that each adds to /accuracy. Checker, `cdb doc accuracy`, results and `cdb show --error`
// read it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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
  bool on_soft = false;  ///< can be measured of soft bodies, whose objects are their nodes
};
std::span<const ErrorInfo> Errors();

/// One word of `accuracy.metrics`, for the checker and the reference.
struct Metric {
  std::string_view name;
  bool on_soft;
};
std::span<const Metric> Metrics();

// THE table of the names in a results file that an axis may not have: an axis is a variable of the
// same file, and is never renamed. The checker and the store read it; a test compares it with the
// layout of the file.

/// Names of the same kind.
struct ResultNames {
  std::string_view kind;  ///< a noun for one of them: `a series of the results`
  std::vector<std::string_view> names;
  bool only_with_errors = false;  ///< in the file only if the benchmark asks for errors
};
const std::vector<ResultNames>& ReservedNames();

/// The kind of the existing name that equals `axis` in the results of a benchmark that requests
/// `errors`: `a series of the results`. Nullopt if the name is free.
std::optional<std::string> FindNameClash(std::string_view axis,
                                         std::span<const ErrorInfo* const> errors);

}  // namespace cdb::schema
