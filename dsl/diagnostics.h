// What can be wrong with a text, said in the user's words and tied to the place.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "dsl/text/source.h"

namespace cdb::dsl {

enum class Severity { kError, kWarning };

/// A kind of diagnostic. Kinds are constants that each layer lists once (`dsl/diagnostic_kinds.h`,
/// `compiler/diagnostic_kinds.h`); a test holds that every one of them has a golden file.
struct DiagnosticKind {
  std::string_view code;  ///< stable, `E0201`, or `W0201` for a warning: `cdb explain E0201`
  std::string_view id;    ///< in words, shown behind it: `[E0201 unknown-name]`
  constexpr Severity severity() const {
    return code.starts_with('W') ? Severity::kWarning : Severity::kError;
  }
};

/// A second place that explains the first ("it was set here before").
struct Note {
  text::Span span;
  std::string text;
};

struct Diagnostic {
  const DiagnosticKind* kind = nullptr;
  text::Span span;      ///< the faulty part itself, not where the parser stood
  std::string message;  ///< one sentence without a full stop
  std::string help;     ///< what to write instead; may be empty
  std::vector<Note> notes;
};

/// Collects diagnostics of one compilation. The same message at the same place is kept once. Two
/// errors never overlap: one that touches a character of an earlier error follows from it as a
/// rule, and is dropped.
class Diagnostics {
 public:
  void Report(const DiagnosticKind& kind, const text::Span& span, std::string message,
              std::string help = {}, std::vector<Note> notes = {});

  bool has_errors() const { return error_count_ > 0; }
  int error_count() const { return error_count_; }
  int warning_count() const { return static_cast<int>(all_.size()) - error_count_; }
  /// In the order they were reported.
  const std::vector<Diagnostic>& all() const { return all_; }

 private:
  std::vector<Diagnostic> all_;
  bool OverlapsAnError(const text::Span& span) const;

  std::unordered_set<std::string> seen_;  // place and message of each
  std::map<const text::Source*, std::map<std::uint32_t, std::uint32_t>>
      taken_;  // errors: begin, end
  int error_count_ = 0;
};

/// The candidate nearest to `word` by edit distance (transposition counts one), or empty where none
/// is near enough to be a slip of the hand.
std::string_view DidYouMean(std::string_view word, const std::vector<std::string_view>& candidates);

}  // namespace cdb::dsl
