#include "runtime/cli/options/diagnostics_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "dsl/diagnostics.h"
#include "runtime/manual/explanation.h"

namespace cdb::options {
namespace {

using Json = nlohmann::ordered_json;

/// The lines that a span touches, each with the columns that belong to it.
Json LinesOf(const text::Span& span) {
  constexpr int kMostLines = 6;  // for example of a block that is not closed
  const text::Source& source = *span.source;
  const text::Position begin = source.PositionAt(span.begin), end = source.PositionAt(span.end);
  Json lines = Json::array();
  for (int line = begin.line; line <= std::min(end.line, begin.line + kMostLines - 1); ++line) {
    const std::string_view text = source.Line(line);
    const auto length = static_cast<std::uint32_t>(text.size());
    const int after = source.PositionAt(source.LineStart(line) + length).column;
    lines.push_back({{"text", text},
                     {"highlight_start", line == begin.line ? begin.column : 1},
                     {"highlight_end", line == end.line ? end.column : after}});
  }
  return lines;
}

Json SpanJson(const text::Span& span, const std::string& label, bool is_primary) {
  const text::Source& source = *span.source;
  const text::Position begin = source.PositionAt(span.begin), end = source.PositionAt(span.end);
  return {{"file_name", source.name()},
          {"byte_start", source.FileOffset(span.begin)},
          {"byte_end", source.FileOffset(span.end)},
          {"line_start", begin.line},
          {"line_end", end.line},
          {"column_start", begin.column},
          {"column_end", end.column},
          {"is_primary", is_primary},
          {"text", LinesOf(span)},
          {"label", label.empty() ? Json(nullptr) : Json(label)},
          {"suggested_replacement", nullptr},
          {"suggestion_applicability", nullptr},
          {"expansion", nullptr}};
}

Json SpansJson(const text::Span& span, const std::string& label, bool is_primary) {
  Json spans = Json::array();
  if (span.source != nullptr) spans.push_back(SpanJson(span, label, is_primary));
  return spans;
}

Json ChildJson(std::string_view level, const std::string& message, Json spans) {
  return {{"message", message},        {"code", nullptr},           {"level", level},
          {"spans", std::move(spans)}, {"children", Json::array()}, {"rendered", nullptr}};
}

Json DiagnosticJson(const dsl::Diagnostic& diagnostic) {
  Json children = Json::array();
  for (const dsl::Note& note : diagnostic.notes)
    children.push_back(ChildJson("note", note.text, SpansJson(note.span, "", true)));
  if (!diagnostic.help.empty())
    children.push_back(ChildJson("help", diagnostic.help, Json::array()));
  Json explanation = nullptr;
  for (const manual::Explanation* row : manual::FindExplanations(diagnostic.kind->code))
    explanation = row->text;
  const bool is_error = diagnostic.kind->severity() == dsl::Severity::kError;
  return {{"$message_type", "diagnostic"},
          {"message", diagnostic.message},
          {"code", {{"code", diagnostic.kind->code}, {"explanation", explanation}}},
          {"level", is_error ? "error" : "warning"},
          {"spans", SpansJson(diagnostic.span, diagnostic.help, true)},
          {"children", std::move(children)},
          {"rendered", dsl::Render(diagnostic)}};
}

}  // namespace

std::string DiagnosticsJson(const dsl::Diagnostics& diagnostics) {
  std::string lines;
  for (const dsl::Diagnostic* diagnostic : dsl::InOrder(diagnostics))
    lines +=
        DiagnosticJson(*diagnostic).dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
  return lines;
}

}  // namespace cdb::options
