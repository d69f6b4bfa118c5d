// Diagnostics: errors and warnings in the user's terms, each with its location in the text.
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

/// A kind of diagnostic. Kinds are constants, and each layer lists its own once
/// (`dsl/diagnostic_kinds.h`, `compiler/scenario/diagnostic_kinds.h`). A test checks that every
/// kind has a golden file.
struct DiagnosticKind {
  std::string_view code;  ///< stable, `E0201`, or `W0201` for a warning: `cdb explain E0201`
  std::string_view id;    ///< in words, shown after the code: `[E0201 unknown-name]`
  /// An expression with this fault is wrong wherever it is used.
  bool is_of_expression = false;
  constexpr Severity severity() const {
    return code.starts_with('W') ? Severity::kWarning : Severity::kError;
  }
};

/// A second location that explains the first ("it was set here before").
struct Note {
  text::Span span;
  std::string text;
};

struct Diagnostic {
  const DiagnosticKind* kind = nullptr;
  text::Span span;      ///< the faulty part itself, not the parser's position
  std::string message;  ///< one sentence without a full stop
  std::string help;     ///< what to write instead; may be empty
  std::vector<Note> notes;
};

/// Collects the diagnostics of one compilation. The same message at the same location is kept once.
/// Errors never overlap: an error that touches a character of an earlier one usually follows from
/// it, and is dropped.
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

  std::unordered_set<std::string> seen_;  // location and message of each
  std::map<const text::Source*, std::map<std::uint32_t, std::uint32_t>>
      taken_;  // errors: begin, end
  int error_count_ = 0;
};

/// The candidate nearest to `word` by edit distance (a transposition counts as one edit), or empty
/// if none is near enough to be a typing error.
std::string_view DidYouMean(std::string_view word, const std::vector<std::string_view>& candidates);

}  // namespace cdb::dsl
