#include "dsl/diagnostics.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsl/text/concat.h"
#include "dsl/text/utf8.h"

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

namespace {

constexpr int kWidest = 100;      // maximum number of columns shown of a line
constexpr int kLeftOfFault = 40;  // maximum number of these before the fault, in a line that is cut

constexpr std::string_view kBold = "\033[1m";
constexpr std::string_view kRed = "\033[1;31m";
constexpr std::string_view kMagenta = "\033[1;35m";
constexpr std::string_view kCyan = "\033[1;36m";
constexpr std::string_view kPlain = "\033[0m";

// Characters that a terminal obeys instead of showing: controls and marks that reorder text.
bool Hidden(char32_t value) {
  return value < 0x20 || (value >= 0x7F && value < 0xA0) || (value >= 0x202A && value <= 0x202E) ||
         (value >= 0x2066 && value <= 0x2069) || value == 0x2028 || value == 0x2029;
}

// One character of a line: its bytes as shown, and its width.
struct Glyph {
  std::string_view text;
  int columns;
  std::size_t bytes;  // in the source
};

Glyph GlyphAt(std::string_view line, std::size_t at) {
  const text::CodePoint point = text::DecodeUtf8(line, at);
  if (point.bytes == 0) return {"\uFFFD", 1, 1};
  const auto bytes = static_cast<std::size_t>(point.bytes);
  if (point.value == '\t') return {"\t", 1, bytes};
  if (Hidden(point.value)) return {"\uFFFD", 1, bytes};
  return {line.substr(at, bytes), text::ColumnsOf(point.value), bytes};
}

std::size_t StepBack(std::string_view line, std::size_t at) {
  do --at;
  while (at > 0 && (static_cast<unsigned char>(line[at]) & 0xC0) == 0x80);
  return at;
}

// No message may move the cursor of a terminal, whatever the file contains.
std::string WithoutControls(std::string_view text) {
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    const Glyph glyph = GlyphAt(text, at);
    shown += glyph.text;
    at += glyph.bytes;
  }
  return shown;
}

class Renderer {
 public:
  explicit Renderer(const RenderOptions& options) : options_(options) {}

  void Add(const Diagnostic& diagnostic) {
    const bool error = diagnostic.kind->severity() == Severity::kError;
    AddPlace(diagnostic.span, error ? "error" : "warning", error ? kRed : kMagenta,
             diagnostic.message, diagnostic.kind, diagnostic.help);
    for (const Note& note : diagnostic.notes)
      AddPlace(note.span, "note", kCyan, note.text, nullptr, {});
  }
  std::string Take() { return std::move(out_); }

 private:
  void Colored(std::string_view color, std::string_view text) {
    if (options_.color) out_ += color;
    out_ += text;
    if (options_.color) out_ += kPlain;
  }

  void AddPlace(const text::Span& span, std::string_view word, std::string_view color,
                std::string_view message, const DiagnosticKind* kind, std::string_view help) {
    text::Position position;
    if (span.source != nullptr) {
      position = span.source->PositionAt(span.begin);
      Colored(kBold, WithoutControls(span.source->name()) + ':' + std::to_string(position.line) +
                         ':' + std::to_string(position.column) + ':');
      out_ += ' ';
    }
    Colored(color, std::string(word) + ':');
    out_ += ' ';
    Colored(kBold, WithoutControls(message));
    if (kind != nullptr) out_ += text::Concat({" [", kind->code, " ", kind->id, "]"});
    out_ += '\n';
    if (span.source != nullptr) {
      AddExcerpt(span, position.line, color, WithoutControls(help));
    } else if (!help.empty()) {
      out_ += text::Concat({"  ", WithoutControls(help), "\n"});
    }
  }

  void AddExcerpt(const text::Span& span, int line_number, std::string_view color,
                  const std::string& help) {
    const std::string_view line = span.source->Line(line_number);
    const std::uint32_t line_begin = span.source->LineStart(line_number);
    const std::size_t fault = std::min<std::size_t>(span.begin - line_begin, line.size());
    std::size_t fault_end =
        std::min<std::size_t>(std::max(span.end, span.begin) - line_begin, line.size());
    // Spaces at the end of the first of several lines are not part of the fault.
    while (fault_end > fault && span.end - line_begin > line.size() &&
           (line[fault_end - 1] == ' ' || line[fault_end - 1] == '\t'))
      --fault_end;

    // The part of the line that is shown: the whole line, or a window around the fault.
    std::size_t begin = fault;
    int before = 0;
    const bool short_line = line.size() <= static_cast<std::size_t>(kWidest);
    while (begin > 0 && (short_line || before < kLeftOfFault)) {
      begin = StepBack(line, begin);
      before += GlyphAt(line, begin).columns;
    }
    if (begin > 0 && FitsFromStart(line, fault_end)) begin = 0;

    const std::string number = std::to_string(line_number);
    const bool cut_left = begin > 0;
    std::string shown = cut_left ? "…" : "";
    std::string carets = cut_left ? " " : "";
    int columns = cut_left ? 1 : 0;
    std::size_t at = begin;
    for (; at < line.size() && columns < kWidest;) {
      const Glyph glyph = GlyphAt(line, at);
      shown += glyph.text;
      columns += glyph.columns;
      if (at < fault)
        carets +=
            glyph.text == "\t" ? "\t" : std::string(static_cast<std::size_t>(glyph.columns), ' ');
      else if (at < fault_end)
        carets += std::string(static_cast<std::size_t>(glyph.columns), '^');
      at += glyph.bytes;
    }
    if (at < line.size()) shown += "…";
    if (carets.find('^') == std::string::npos) carets += '^';

    out_ += text::Concat({"  ", number, shown.empty() ? " |" : " | ", shown, "\n"});
    out_ += text::Concat({"  ", std::string(number.size(), ' '), " | "});
    const std::size_t first = carets.find('^');
    out_ += carets.substr(0, first);
    Colored(color, carets.substr(first));
    if (!help.empty()) out_ += ' ' + help;
    out_ += '\n';
  }

  // Whether a line shown from its start still includes the fault.
  static bool FitsFromStart(std::string_view line, std::size_t fault_end) {
    int columns = 0;
    for (std::size_t at = 0; at < fault_end && columns <= kWidest;) {
      const Glyph glyph = GlyphAt(line, at);
      columns += glyph.columns;
      at += glyph.bytes;
    }
    return columns < kWidest;
  }

  RenderOptions options_;
  std::string out_;
};

}  // namespace

std::vector<const Diagnostic*> InOrder(const Diagnostics& diagnostics) {
  std::vector<const text::Source*> sources{nullptr};
  std::vector<std::pair<std::size_t, const Diagnostic*>> order;
  for (const Diagnostic& diagnostic : diagnostics.all()) {
    const auto found = std::find(sources.begin(), sources.end(), diagnostic.span.source);
    order.emplace_back(found - sources.begin(), &diagnostic);
    if (found == sources.end()) sources.push_back(diagnostic.span.source);
  }
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    if (a.first != b.first) return a.first < b.first;
    return a.second->span.begin < b.second->span.begin;
  });
  std::vector<const Diagnostic*> ordered;
  for (const auto& [file, diagnostic] : order) ordered.push_back(diagnostic);
  return ordered;
}

std::string Render(const Diagnostic& diagnostic, const RenderOptions& options) {
  Renderer renderer(options);
  renderer.Add(diagnostic);
  return renderer.Take();
}

std::string Render(const Diagnostics& diagnostics, const RenderOptions& options) {
  Renderer renderer(options);
  std::size_t errors = 0, warnings = 0;
  for (const Diagnostic* diagnostic : InOrder(diagnostics)) {
    std::size_t& count = diagnostic->kind->severity() == Severity::kError ? errors : warnings;
    if (count++ < options.most) renderer.Add(*diagnostic);
  }
  const auto rest = [&options](std::size_t count, std::string_view what) {
    if (count <= options.most) return std::string();
    const std::size_t more = count - options.most;
    return text::Concat(
        {"… and ", std::to_string(more), " more ", what, more == 1 ? "" : "s", "\n"});
  };
  return renderer.Take() + rest(errors, "error") + rest(warnings, "warning");
}

}  // namespace cdb::dsl
