// Comparisons of results files as text and JSON (`cdb compare`).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/figures/compare.h"
#include "runtime/printers/document.h"

namespace cdb::printers {

/// In this order: differences between the files, and how far their times can be trusted; the
/// changes; the facts; the times of groups; the points that changed. Throws StoreError.
Document CompareDocument(const figures::FileComparison& comparison,
                         const figures::CompareOptions& options);

/// All of a command, with a summary first if it has several benchmarks. Throws StoreError.
Document AllDocument(const figures::Comparisons& comparisons,
                     const figures::CompareOptions& options);

/// The same for a pull request: a headline and one table, and the rest folded away.
std::string PullRequestText(const figures::Comparisons& comparisons,
                            const figures::CompareOptions& options);

/// `FAIL (exit status 4): crowd: slower by more than 5 %: sap step`.
std::string Headline(const figures::Comparisons& comparisons,
                     const figures::CompareOptions& options);

/// For several files: the differences from one to the next, then a line for each group with its
/// ratio to the first file and the steps at which it changed.
Document HistoryDocument(const figures::Comparisons& comparisons,
                         const figures::CompareOptions& options);

/// Every number of the comparisons; NaN is null. `cdb doc compare` describes the members.
std::string CompareJson(const figures::Comparisons& comparisons,
                        const figures::CompareOptions& options);

/// The same for a page, with the sections that a terminal shows.
std::string ComparePageJson(const figures::Comparisons& comparisons,
                            const figures::CompareOptions& options);

/// A summary that stands alone: times, states, facts, and what fails.
std::vector<std::string> ResultLines(const figures::FileComparison& comparison,
                                     const figures::CompareOptions& options);

/// What fails, and what was found but is allowed.
std::vector<std::string> GateLines(const figures::FileComparison& comparison,
                                   const figures::CompareOptions& options);

/// The sections of no single benchmark: those not compared, the history of several files, and a
/// summary of several benchmarks.
Document SharedSections(const figures::Comparisons& comparisons,
                        const figures::CompareOptions& options);

/// The lines about states and facts that changed.
std::vector<std::string> FactLines(const figures::FileComparison& comparison);

// Phrases shared by all texts about comparisons.
/// `1.052`: four significant digits, and all digits of a whole number; `-` for
/// NaN.
std::string FourDigits(double value);
/// `+5.2 %` of a ratio of 1.052.
std::string PercentText(double ratio, int digits = 1);
/// `+4.6 .. +5.8 %`.
std::string PercentRange(double low, double high, int digits = 1);
/// `25.12 us`, in the unit that suits `like_ns`.
std::string TimeText(double ns, double like_ns);
/// `12.34 M`, of instructions.
std::string CountText(double count);
/// The limit of times: `5 %`.
std::string LimitText(const figures::CompareOptions& options);
/// `8 points`.
std::string Counted(std::size_t count, const char* noun);
/// The first of `places`, and the number of the others.
std::string PlacesText(const std::vector<std::string>& places);
/// `0.02046 -> 0.02154 (+5.28 %)`.
std::string ChangeText(const figures::FactChange& change);
/// `same within 1.2 %`, `SLOWER`.
std::string VerdictText(const figures::JudgedChange& change);

}  // namespace cdb::printers
