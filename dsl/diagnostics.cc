#include "dsl/diagnostics.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

namespace cdb::dsl {
namespace {

constexpr std::size_t kLongestWord = 64;

char Lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// The number of typing errors tolerated in a word of this length.
std::size_t SlipsIn(std::size_t length) {
  if (length <= 1) return 0;
  if (length <= 4) return 1;
  return length <= 8 ? 2 : 3;
}

// Damerau-Levenshtein distance in its restricted form (no edit inside a transposed pair), ignoring
// case. Both words are at most kLongestWord long.
std::size_t Distance(std::string_view a, std::string_view b) {
  std::size_t rows[3][kLongestWord + 1] = {};
  std::size_t* before = rows[0];
  std::size_t* last = rows[1];
  std::size_t* row = rows[2];
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = Lower(a[i - 1]) == Lower(b[j - 1]);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0 : 1)});
      if (i > 1 && j > 1 && Lower(a[i - 1]) == Lower(b[j - 2]) &&
          Lower(a[i - 2]) == Lower(b[j - 1]))
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

/// A position between two characters counts as the character after it.
std::uint32_t EndOf(const text::Span& span) { return std::max(span.end, span.begin + 1); }

}  // namespace

bool Diagnostics::OverlapsAnError(const text::Span& span) const {
  const auto taken = taken_.find(span.source);
  if (taken == taken_.end()) return false;
  const auto next = taken->second.lower_bound(EndOf(span));
  return next != taken->second.begin() && std::prev(next)->second > span.begin;
}

void Diagnostics::Report(const DiagnosticKind& kind, const text::Span& span, std::string message,
                         std::string help, std::vector<Note> notes) {
  const auto source = reinterpret_cast<std::uintptr_t>(span.source);
  std::string key = std::to_string(source) + ':' + std::to_string(span.begin) + ':' +
                    std::to_string(span.end) + ':' + message;
  if (!seen_.insert(std::move(key)).second) return;
  if (kind.severity() == Severity::kError) {
    if (span.source != nullptr) {
      if (OverlapsAnError(span)) return;
      taken_[span.source].emplace(span.begin, EndOf(span));
    }
    ++error_count_;
  }
  all_.push_back({&kind, span, std::move(message), std::move(help), std::move(notes)});
}

std::string_view DidYouMean(std::string_view word,
                            const std::vector<std::string_view>& candidates) {
  std::string_view nearest;
  std::size_t least = SlipsIn(word.size()) + 1;
  if (word.size() > kLongestWord) return nearest;
  for (const std::string_view candidate : candidates) {
    if (candidate.size() > kLongestWord || candidate == word) continue;
    const std::size_t distance = Distance(word, candidate);
    // A word that shares nothing with the candidate is not a typing error, however short both are.
    if (distance >= least || distance >= std::max(word.size(), candidate.size())) continue;
    least = distance;
    nearest = candidate;
  }
  return nearest;
}

}  // namespace cdb::dsl
