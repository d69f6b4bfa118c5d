#include "runtime/editor/documents.h"

#include <algorithm>
#include <utility>

namespace cdb::editor {

const text::Source& Analysis::source() const {
  static const text::Source nothing("", "");
  const scenario::ScenarioFile* main = compilation.scenario->main();
  return main != nullptr ? *main->tree.source : nothing;
}

void Documents::Open(const Json& item) {
  const std::string uri = TextIn(item, "uri");
  open_[uri] = {uri, PathOf(uri), TextIn(item, "text"), NumberIn(item, "version"), false, nullptr};
  ForgetAnalyses();
}

void Documents::Change(const std::string& uri, std::int64_t version, const Json& changes) {
  Document* document = Find(uri);
  if (document == nullptr || !changes.is_array()) return;
  for (const Json& change : changes) {
    const Json& range = Member(change, "range");
    if (!range.is_object()) {
      document->text = TextIn(change, "text");
      continue;
    }
    const text::Source source("", document->text);
    const std::uint32_t mark = source.FileOffset(0);  // keep a byte order mark
    const std::uint32_t first = OffsetOf(source, PositionIn(range, "start"));
    const std::uint32_t last = OffsetOf(source, PositionIn(range, "end"));
    const std::uint32_t begin = std::min(first, last), end = std::max(first, last);
    document->text.replace(mark + begin, end - begin, TextIn(change, "text"));
  }
  document->version = version;
  ForgetAnalyses();
}

Document* Documents::Find(const std::string& uri) {
  const auto found = open_.find(uri);
  return found == open_.end() ? nullptr : &found->second;
}

void Documents::ForgetAnalyses() {
  for (auto& [uri, document] : open_) {
    document.analysis = nullptr;
    document.is_published = false;
  }
}

std::shared_ptr<const Analysis> Documents::Analyse(Document& document) {
  if (document.analysis == nullptr) {
    compiler::Compilation compilation = CompileWith(document.path, {});
    Symbols symbols(*compilation.scenario);
    document.analysis =
        std::make_shared<const Analysis>(Analysis{std::move(compilation), std::move(symbols)});
  }
  return document.analysis;
}

compiler::Compilation Documents::CompileWith(
    const std::string& path, const std::map<std::string, std::string>& edited) const {
  const auto read = [&](const std::string& wanted, std::string& why) -> std::optional<std::string> {
    if (const auto found = edited.find(wanted); found != edited.end()) return found->second;
    for (const auto& [uri, document] : open_)
      if (document.path == wanted) return document.text;
    return compiler::ReadFromDisk(wanted, why);
  };
  return compile_(path, read);
}

}  // namespace cdb::editor
