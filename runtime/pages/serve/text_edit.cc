#include "runtime/pages/serve/text_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>
#include <variant>

#include "dsl/diagnostics.h"
#include "dsl/parser.h"

namespace cdb::serve {
namespace {

/// A benchmark, with the syntax tree that owns it.
class ParsedBenchmark {
 public:
  ParsedBenchmark(const std::string& text, const std::string& name) {
    dsl::Diagnostics diagnostics;
    file_ = dsl::Parse(std::make_shared<const text::Source>("scenario", text), diagnostics);
    if (diagnostics.has_errors()) throw EditError(dsl::Render(diagnostics));
    for (const auto& item : file_.items)
      if (const auto* found = std::get_if<dsl::Benchmark>(&item);
          found != nullptr && found->name.text == name)
        benchmark_ = found;
    if (benchmark_ == nullptr)
      throw EditError(fmt::format("the text no longer has a benchmark '{}'", name));
    Visit(benchmark_->block, "", "");
  }

  struct Group {
    std::string name;
    const dsl::Block* block;
  };
  struct Written {
    std::string group, path;
    const dsl::Setting* setting;
  };

  const std::vector<Group>& groups() const { return groups_; }
  const dsl::Block& block() const { return benchmark_->block; }
  std::string_view text() const { return file_.source->text(); }

  /// The last setting of a parameter; null if there is none.
  const dsl::Setting* Find(const Place& place) const {
    const dsl::Setting* found = nullptr;
    for (const auto& [group, path, setting] : written_)
      if ((group == place.group && path == place.name) ||
          (group.empty() && !place.group.empty() && path == place.group + "." + place.name))
        found = setting;
    return found;
  }

 private:
  void Visit(const dsl::Block& block, const std::string& group, const std::string& prefix) {
    for (const dsl::Statement& statement : block.statements) {
      if (const auto* setting = std::get_if<dsl::Setting>(&statement.what)) {
        written_.push_back({group, prefix + setting->path.text, setting});
      } else if (const auto* inner = std::get_if<dsl::Group>(&statement.what)) {
        if (inner->kind.text == "objects") {
          groups_.push_back({inner->label ? inner->label->text : "objects", &inner->block});
          Visit(inner->block, groups_.back().name, "");
        } else {
          Visit(inner->block, group, prefix + inner->kind.text + ".");
        }
      }
    }
  }

  dsl::File file_;
  const dsl::Benchmark* benchmark_ = nullptr;
  std::vector<Group> groups_;
  std::vector<Written> written_;
};

/// The range of bytes of a setting's values.
std::pair<std::size_t, std::size_t> ValueRange(const dsl::Setting& setting) {
  return {setting.values.front()->span.begin, setting.values.back()->span.end};
}

/// Inserts a statement before the closing brace of the block.
std::string Inserted(std::string_view text, const dsl::Block& block, const std::string& statement) {
  const std::size_t brace = block.span.end - 1;
  std::string before(text.substr(0, brace)), after(text.substr(brace));
  const std::string_view inside = text.substr(block.span.begin, brace - block.span.begin);
  if (inside.find('\n') == std::string_view::npos) {
    while (before.ends_with(' ')) before.pop_back();
    const char* separator = block.statements.empty() ? " " : "; ";
    return before + separator + statement + " " + after;
  }
  const std::size_t line = before.rfind('\n') + 1;
  const std::string indent = before.substr(line);
  const bool is_alone = indent.find_first_not_of(" \t") == std::string::npos;
  if (!is_alone) return before + "\n  " + statement + "\n" + after;
  return before.substr(0, line) + indent + "  " + statement + "\n" + indent + after;
}

}  // namespace

bool Parses(const std::string& text) {
  dsl::Diagnostics diagnostics;
  dsl::Parse(std::make_shared<const text::Source>("scenario", text), diagnostics);
  return !diagnostics.has_errors();
}

std::vector<std::string> GroupsIn(const std::string& text, const std::string& benchmark) {
  std::vector<std::string> names;
  const ParsedBenchmark parsed(text, benchmark);
  for (const ParsedBenchmark::Group& group : parsed.groups()) names.push_back(group.name);
  return names;
}

std::optional<std::string> WrittenValue(const std::string& text, const std::string& benchmark,
                                        const Place& place) {
  const ParsedBenchmark parsed(text, benchmark);
  const dsl::Setting* setting = parsed.Find(place);
  if (setting == nullptr) return std::nullopt;
  const auto [begin, end] = ValueRange(*setting);
  return std::string(parsed.text().substr(begin, end - begin));
}

std::string WithValue(const std::string& text, const std::string& benchmark, const Place& place,
                      const std::string& value) {
  if (value.find_first_not_of(" \t") == std::string::npos ||
      value.find_first_of("\r\n") != std::string::npos)
    throw EditError(fmt::format("{} needs a value, on one line", place.name));
  const ParsedBenchmark parsed(text, benchmark);
  if (const dsl::Setting* setting = parsed.Find(place)) {
    const auto [begin, end] = ValueRange(*setting);
    return std::string(parsed.text().substr(0, begin)) + value +
           std::string(parsed.text().substr(end));
  }
  const std::string statement = place.name + " " + value;
  if (place.group.empty()) return Inserted(parsed.text(), parsed.block(), statement);
  const auto group = std::ranges::find(parsed.groups(), place.group, &ParsedBenchmark::Group::name);
  if (group == parsed.groups().end())
    throw EditError(
        fmt::format("benchmark '{}' does not define the group '{}': write {}.{} {} in it",
                    benchmark, place.group, place.group, place.name, value));
  return Inserted(parsed.text(), *group->block, statement);
}

}  // namespace cdb::serve
