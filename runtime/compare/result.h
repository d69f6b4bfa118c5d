// The result of a comparison of two results files, a line for each finding (`cdb compare`).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/compare/compare.h"

namespace cdb::compare {

/// A summary that stands alone: times, states, facts, and whether something is worse.
std::vector<std::string> ResultLines(const Comparison& comparison, const CompareOptions& options);

/// The lines about states and facts that changed.
std::vector<std::string> FactLines(const Comparison& comparison);

// Phrases shared by all texts about comparisons.
/// `1.052`: four significant digits, and all digits of a whole number; `-` for
/// NaN.
std::string FourDigits(double value);
/// `+5.2 %` of a ratio of 1.052.
std::string PercentText(double ratio);
/// `+4.6 .. +5.8 %`.
std::string PercentRange(double low, double high);
/// `25.12 us`, in the unit that suits `like_ns`.
std::string TimeText(double ns, double like_ns);
/// `8 points`.
std::string Counted(std::size_t count, const char* noun);
/// The first of `places`, and the number of the others.
std::string PlacesText(const std::vector<std::string>& places);
/// `0.02046 -> 0.02154 (+5.28 %)`.
std::string ChangeText(const FactChange& change);
/// `same within 1.2 %`, `SLOWER`.
std::string VerdictText(const JudgedChange& change);

}  // namespace cdb::compare
