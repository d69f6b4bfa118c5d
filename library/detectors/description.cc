#include "library/detectors/description.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <span>

namespace cdb::detectors {
namespace {

std::string_view PhasesOf(const DetectorEntry& entry) {
  if (!HasAny(entry.phases, kNarrow)) return "broad";
  return HasAny(entry.phases, kBroad) ? "broad narrow" : "narrow";
}

/// The text up to `end`, which is taken off with it; nullopt where there is no `end`.
std::optional<std::string_view> TakeUntil(std::string_view& text, char end) {
  const std::size_t at = text.find(end);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view taken = text.substr(0, at);
  text.remove_prefix(at + 1);
  return taken;
}

}  // namespace

std::string DescriptionOf(const Plugin& plugin) {
  std::string text;
  for (const DetectorEntry& entry : std::span(plugin.entries, plugin.count)) {
    std::string doc = entry.doc;
    std::ranges::replace_if(
        doc, [](unsigned char c) { return c < ' '; }, ' ');
    text += fmt::format("{}\t{}\t{}\t{}\n", entry.name, PhasesOf(entry), entry.max_bodies, doc);
  }
  return text;
}

std::optional<std::vector<schema::PluginDetector>> ReadDescription(std::string_view text) {
  std::vector<schema::PluginDetector> detectors;
  while (!text.empty()) {
    const auto name = TakeUntil(text, '\t'), phases = TakeUntil(text, '\t'),
               most = TakeUntil(text, '\t'), doc = TakeUntil(text, '\n');
    if (!name || !phases || !most || !doc) return std::nullopt;
    schema::PluginDetector detector;
    detector.name = *name;
    detector.phases = *phases;
    const auto [end, error] =
        std::from_chars(most->data(), most->data() + most->size(), detector.max_bodies);
    if (error != std::errc{} || end != most->data() + most->size() ||
        std::ranges::find(schema::kPluginPhases, *phases) == std::end(schema::kPluginPhases))
      return std::nullopt;
    detectors.push_back(std::move(detector));
  }
  return detectors;
}

}  // namespace cdb::detectors
