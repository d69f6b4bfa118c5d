// What `cdb compare` can find between results, and which of it fails a build: --fail-if, --allow
// and --fail-above.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::figures {

enum class Finding {
  kSlower,
  kMemory,
  kStability,  ///< verdicts
  kAccuracy,   ///< errors, missed pairs and contacts
  kPhysics,    ///< another last state, or repeats with different ones
  kMissing,    ///< a benchmark or a point
  kScenes,     ///< other scenes; not compared unless allowed
  kUnsure,     ///< times whose noise is too large, or that were not compared
};
inline constexpr std::size_t kFindingCount = 8;

struct FindingInfo {
  Finding finding;
  std::string_view word;  ///< of --fail-if
  std::string_view text;  ///< of the result: `slower`
  bool fails;             ///< by default
  bool has_limit;         ///< fails only above a limit of --fail-above
};
std::span<const FindingInfo, kFindingCount> Findings();
const FindingInfo& InfoOf(Finding finding);

/// Which findings fail, and above which limits.
class Gate {
 public:
  explicit Gate(double limit = 0.05);

  bool Fails(Finding finding) const { return fails_[Index(finding)]; }
  double LimitOf(Finding finding) const { return limits_[Index(finding)]; }
  void SetFails(Finding finding, bool fails) { fails_[Index(finding)] = fails; }
  void SetLimit(Finding finding, double limit) { limits_[Index(finding)] = limit; }
  /// `slower by more than 5 %`, `other physics`.
  std::string TextOf(Finding finding) const;

 private:
  static std::size_t Index(Finding finding) { return static_cast<std::size_t>(finding); }
  std::array<bool, kFindingCount> fails_;
  std::array<double, kFindingCount> limits_;
};

/// What was found, of one kind.
struct Found {
  Finding finding;
  std::vector<std::string> what;  ///< `sap step`, `heap memory`, `quantity 10`
};

}  // namespace cdb::figures
