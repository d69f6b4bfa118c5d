#include "runtime/editor/documents.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "compiler/plan/kept_files.h"
#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "dsl/text/utf8.h"

namespace cdb::editor {

const text::Source& Analysis::source() const {
  static const text::Source nothing("", "");
  const scenario::ScenarioFile* main = compilation.scenario->main();
  return main != nullptr ? *main->tree.source : nothing;
}

Documents::Documents(CompileFile compile) : compile_(std::move(compile)) {
  // Decomposed into hulls, a mesh takes much less memory than its file.
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;
  plan::KeepFiles(kMostBytes);
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

namespace {

constexpr std::string_view kFileScheme = "file://";

struct CharacterSize {
  std::uint32_t bytes;
  int units;
};

CharacterSize SizeAt(std::string_view text, std::size_t at) {
  const text::CodePoint point = text::DecodeUtf8(text, at);
  if (point.bytes == 0) return {1, 1};
  return {static_cast<std::uint32_t>(point.bytes), point.value > 0xFFFF ? 2 : 1};
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

Position PositionOf(const text::Source& source, std::uint32_t offset) {
  offset = std::min(offset, static_cast<std::uint32_t>(source.text().size()));
  const int line = source.PositionAt(offset).line;
  Position position{line - 1, 0};
  for (std::uint32_t at = source.LineStart(line); at < offset;) {
    const CharacterSize size = SizeAt(source.text(), at);
    if (at + size.bytes > offset) break;
    at += size.bytes;
    position.character += size.units;
  }
  return position;
}

std::uint32_t OffsetOf(const text::Source& source, const Position& position) {
  if (position.line < 0) return 0;
  if (position.line >= source.LineCount()) return static_cast<std::uint32_t>(source.text().size());
  const int line = static_cast<int>(position.line) + 1;
  const std::uint32_t begin = source.LineStart(line);
  const auto end = begin + static_cast<std::uint32_t>(source.Line(line).size());
  std::uint32_t at = begin;
  for (std::int64_t units = 0; at < end;) {
    const CharacterSize size = SizeAt(source.text(), at);
    if (units + size.units > position.character) break;
    units += size.units;
    at += size.bytes;
  }
  return std::min(at, end);
}

std::string PathOf(const std::string& uri) {
  if (!uri.starts_with(kFileScheme)) return uri;
  std::string path;
  for (std::size_t i = uri.find('/', kFileScheme.size()); i < uri.size(); ++i) {
    const int high = i + 2 < uri.size() ? HexDigit(uri[i + 1]) : -1;
    const int low = i + 2 < uri.size() ? HexDigit(uri[i + 2]) : -1;
    if (uri[i] == '%' && high >= 0 && low >= 0) {
      path += static_cast<char>(high * 16 + low);
      i += 2;
    } else {
      path += uri[i];
    }
  }
  return path;
}

std::string UriOf(const std::string& path) {
  if (!path.starts_with('/')) {
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::absolute(path, error);
    return error || path.find(':') != path.npos ? path : UriOf(whole.lexically_normal().string());
  }
  std::string uri(kFileScheme);
  for (const char c : path) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') ||
                          std::string_view("/-._~").find(c) != std::string_view::npos;
    uri += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri;
}

using scenario::Joined;
using scenario::ScenarioFile;

/// Walks the trees twice: first for definitions, then for references to them.
class SymbolCollector {
 public:
  SymbolCollector(const scenario::Scenario& scenario, Symbols& symbols)
      : scenario_(scenario), symbols_(symbols) {}

  void Run() {
    std::vector<const ScenarioFile*> files;
    if (scenario_.main() != nullptr) files.push_back(scenario_.main());
    for (std::size_t i = 0; i < files.size(); ++i)
      for (const ScenarioFile* used : files[i]->uses)
        if (std::ranges::find(files, used) == files.end()) files.push_back(used);
    for (const ScenarioFile* file : files) DefineFile(*file);
    for (const ScenarioFile* file : files) ReferFile(*file);
    for (std::size_t i = 0; i < symbols_.definitions_.size(); ++i)
      symbols_.definitions_[i].family = FamilyOf(i);
  }

 private:
  /// The location of a statement or an expression.
  struct Place {
    const ScenarioFile* file = nullptr;
    const dsl::Benchmark* benchmark = nullptr;
    std::string group, block;
    const schema::Parameter* parameter = nullptr;
  };

  std::size_t Define(Definition definition) {
    const std::size_t index = symbols_.definitions_.size();
    symbols_.occurrences_.push_back({definition.name, index});
    symbols_.definitions_.push_back(std::move(definition));
    families_.push_back(index);
    return index;
  }
  void Refer(const text::Span& span, std::size_t definition) {
    if (span.source != nullptr) symbols_.occurrences_.push_back({span, definition});
  }
  std::size_t FamilyOf(std::size_t index) const {
    while (families_[index] != index) index = families_[index];
    return index;
  }

  void DefineFile(const ScenarioFile& file) {
    for (const auto& item : file.tree.items) {
      if (const auto* let = std::get_if<dsl::Let>(&item)) {
        if (let->name.span.source == nullptr) continue;  // it has no name
        file_lets_[let] = Define({SymbolKind::kLet, let->name.span, WholeOf(*let), "", nullptr, 0});
      } else if (const auto* benchmark = std::get_if<dsl::Benchmark>(&item)) {
        if (benchmark->name.span.source == nullptr) continue;
        benchmarks_[benchmark] =
            Define({SymbolKind::kBenchmark, benchmark->name.span,
                    HeadOf(benchmark->span, benchmark->block), "", nullptr, 0});
        homes_[benchmark] = &file;
        DefineBlock(benchmark->block, {&file, benchmark, "", "", nullptr});
      }
    }
  }

  static text::Span WholeOf(const dsl::Let& let) {
    return let.value->span.source == let.name.span.source ? Join(let.name.span, let.value->span)
                                                          : let.name.span;
  }
  static text::Span HeadOf(const text::Span& whole, const dsl::Block& block) {
    return {whole.source, whole.begin, std::max(whole.begin, block.span.begin)};
  }

  static Place Inside(const Place& place, const dsl::Group& group) {
    Place inner = place;
    const std::string_view block = schema::NamedBlockOf(group.kind.text);
    if (place.group.empty() && place.block.empty() &&
        (group.kind.text == "objects" || block == group.kind.text)) {
      inner.group = group.label ? group.label->text : group.kind.text;
      inner.block = block;
    } else {
      inner.block = Joined(place.block, group.kind.text);
    }
    return inner;
  }

  void DefineBlock(const dsl::Block& block, const Place& place) {
    for (const dsl::Statement& statement : block.statements) {
      if (const auto* let = std::get_if<dsl::Let>(&statement.what)) {
        if (let->name.span.source == nullptr) continue;
        const std::size_t index = Define({SymbolKind::kLet, let->name.span, WholeOf(*let),
                                          Joined(place.group, place.block), place.benchmark, 0});
        lets_[place.benchmark].push_back(index);
      } else if (const auto* group = std::get_if<dsl::Group>(&statement.what)) {
        if (group->label && group->label->span.source != nullptr)
          groups_[place.benchmark].push_back(
              Define({SymbolKind::kGroup, group->label->span, HeadOf(statement.span, group->block),
                      "", place.benchmark, 0}));
        DefineBlock(group->block, Inside(place, *group));
      } else if (const auto* cases = std::get_if<dsl::Cases>(&statement.what)) {
        for (const dsl::Case& one : cases->cases) DefineBlock(one.block, place);
      }
    }
  }

  /// The benchmark and its bases.
  std::vector<const dsl::Benchmark*> ChainOf(const dsl::Benchmark* benchmark) const {
    std::vector<const dsl::Benchmark*> chain;
    while (benchmark != nullptr && std::ranges::find(chain, benchmark) == chain.end()) {
      chain.push_back(benchmark);
      if (!benchmark->from) break;
      const auto base = scenario_.FindBenchmark(*homes_.at(benchmark), benchmark->from->text);
      benchmark = base ? base->benchmark : nullptr;
    }
    return chain;
  }

  std::string_view NameOf(std::size_t index) const {
    const text::Span& span = symbols_.definitions_[index].name;
    return span.source->text().substr(span.begin, span.end - span.begin);
  }

  /// Joins the definitions of `table` in the benchmark and its bases that satisfy `fits` into one
  /// family. Returns the first.
  std::optional<std::size_t> FindIn(
      const std::map<const dsl::Benchmark*, std::vector<std::size_t>>& table,
      const dsl::Benchmark* benchmark, const std::function<bool(std::size_t)>& fits) {
    std::optional<std::size_t> first;
    for (const dsl::Benchmark* one : ChainOf(benchmark)) {
      const auto found = table.find(one);
      if (found == table.end()) continue;
      for (const std::size_t index : found->second) {
        if (!fits(index)) continue;
        if (!first) first = index;
        families_[FamilyOf(index)] = FamilyOf(*first);
      }
    }
    return first;
  }

  std::optional<std::size_t> FindLet(const std::string& name, const Place& place) {
    for (std::string block = Joined(place.group, place.block); place.benchmark != nullptr;
         block = scenario::Outside(block)) {
      const auto fits = [&](std::size_t index) {
        return NameOf(index) == name && symbols_.definitions_[index].block == block;
      };
      if (const auto found = FindIn(lets_, place.benchmark, fits)) return found;
      if (block.empty()) break;
    }
    const auto let = scenario_.FindLet(*place.file, name);
    if (!let || !file_lets_.contains(let->let)) return std::nullopt;
    return file_lets_.at(let->let);
  }

  /// Records a reference to a group: `pebbles` of `pebbles.size`.
  void ReferGroup(const std::string& path, const text::Span& span, const Place& place) {
    const std::string head = path.substr(0, path.find('.'));
    if (head.size() == path.size() || span.source == nullptr) return;
    const auto found =
        FindIn(groups_, place.benchmark, [&](std::size_t index) { return NameOf(index) == head; });
    if (found)
      Refer({span.source, span.begin, span.begin + static_cast<std::uint32_t>(head.size())},
            *found);
  }

  void Refer(const dsl::Expr& expr, const Place& place) {
    if (expr.kind == dsl::ExprKind::kPath) {
      const bool is_word = place.parameter != nullptr && (place.parameter->HasWord(expr.text) ||
                                                          place.parameter->TakesCall(expr.text));
      if (is_word || expr.span.end - expr.span.begin != expr.text.size()) return;
      if (const auto let = FindLet(expr.text, place)) {
        Refer(expr.span, *let);
      } else {
        ReferGroup(expr.text, expr.span, place);
      }
    }
    for (const auto& item : expr.items) Refer(*item, place);
    const schema::ParametrisedWord* word =
        expr.kind == dsl::ExprKind::kCall ? schema::FindParametrisedWord(expr.text) : nullptr;
    for (std::size_t i = 0; i < expr.arguments.size(); ++i) {
      Place inner = place;
      if (word != nullptr && word->takes_parts && !expr.arguments[i].name)
        inner.parameter = &schema::PartParameter();
      else if (word != nullptr && i < word->arguments.size())
        inner.parameter = &word->arguments[i];
      Refer(*expr.arguments[i].value, inner);
      if (expr.arguments[i].weight) Refer(*expr.arguments[i].weight, inner);
    }
  }

  void Refer(const dsl::Condition& condition, const Place& place) {
    if (condition.left) Refer(*condition.left, place);
    if (condition.right) Refer(*condition.right, place);
    for (const auto& item : condition.items) Refer(*item, place);
  }

  void Refer(const dsl::Setting& setting, Place place) {
    ReferGroup(setting.path.text, setting.path.span, place);
    const std::string& path = setting.path.text;
    const bool is_grouped = !place.group.empty();
    place.parameter = schema::FindParameter(Joined(place.block, path), is_grouped);
    const std::size_t dot = path.find('.');
    if (place.parameter == nullptr && !is_grouped && dot != path.npos) {
      place.parameter = schema::FindParameter(path.substr(dot + 1), true);
      for (const std::string_view block : schema::kNamedBlocks)
        if (place.parameter == nullptr)
          place.parameter = schema::FindParameter(Joined(block, path.substr(dot + 1)), true);
    }
    for (const auto& value : setting.values) Refer(*value, place);
  }

  void Refer(const dsl::Block& block, const Place& place) {
    for (const dsl::Statement& statement : block.statements) {
      if (const auto* let = std::get_if<dsl::Let>(&statement.what)) {
        FindLet(let->name.text, place);  // joins it to the family of the let that it overrides
        Refer(*let->value, place);
      } else if (const auto* setting = std::get_if<dsl::Setting>(&statement.what)) {
        Refer(*setting, place);
      } else if (const auto* group = std::get_if<dsl::Group>(&statement.what)) {
        Refer(group->block, Inside(place, *group));
      } else if (const auto* cases = std::get_if<dsl::Cases>(&statement.what)) {
        for (const dsl::Case& one : cases->cases) Refer(one.block, place);
      } else if (const auto* skip = std::get_if<dsl::Skip>(&statement.what)) {
        if (skip->when) Refer(*skip->when, place);
      } else if (const auto* require = std::get_if<dsl::Require>(&statement.what)) {
        if (require->what) Refer(*require->what, place);
      }
    }
  }

  void ReferFile(const ScenarioFile& file) {
    for (const auto& item : file.tree.items) {
      if (const auto* let = std::get_if<dsl::Let>(&item)) {
        Refer(*let->value, {&file, nullptr, "", "", nullptr});
      } else if (const auto* benchmark = std::get_if<dsl::Benchmark>(&item)) {
        if (!homes_.contains(benchmark)) continue;
        if (benchmark->from)
          if (const auto base = scenario_.FindBenchmark(file, benchmark->from->text);
              base && benchmarks_.contains(base->benchmark))
            Refer(benchmark->from->span, benchmarks_.at(base->benchmark));
        Refer(benchmark->block, {&file, benchmark, "", "", nullptr});
      }
    }
  }

  const scenario::Scenario& scenario_;
  Symbols& symbols_;
  std::map<const dsl::Let*, std::size_t> file_lets_;
  std::map<const dsl::Benchmark*, std::size_t> benchmarks_;
  std::map<const dsl::Benchmark*, const ScenarioFile*> homes_;
  std::map<const dsl::Benchmark*, std::vector<std::size_t>> lets_, groups_;
  std::vector<std::size_t> families_;  ///< for each definition, another one of its family, or
                                       ///< itself
};

Symbols::Symbols(const scenario::Scenario& scenario) { SymbolCollector(scenario, *this).Run(); }

const Occurrence* Symbols::At(const text::Source& source, std::uint32_t offset) const {
  for (const Occurrence& one : occurrences_)
    if (one.span.source == &source && one.span.begin <= offset && offset <= one.span.end)
      return &one;
  return nullptr;
}

std::vector<text::Span> Symbols::FamilyOf(std::size_t definition) const {
  std::vector<text::Span> spans;
  for (const Occurrence& one : occurrences_) {
    if (definitions_[one.definition].family != definitions_[definition].family) continue;
    const bool is_known = std::ranges::any_of(spans, [&](const text::Span& span) {
      return span.source == one.span.source && span.begin == one.span.begin;
    });
    if (!is_known) spans.push_back(one.span);
  }
  return spans;
}

const Json& Member(const Json& object, const char* name) {
  static const Json nothing;
  if (!object.is_object()) return nothing;
  const auto found = object.find(name);
  return found == object.end() ? nothing : *found;
}

std::string TextIn(const Json& object, const char* name) {
  const Json& member = Member(object, name);
  return member.is_string() ? member.get<std::string>() : std::string();
}

std::int64_t NumberIn(const Json& object, const char* name) {
  const Json& member = Member(object, name);
  return member.is_number_integer() ? member.get<std::int64_t>() : 0;
}

Position PositionIn(const Json& object, const char* name) {
  const Json& member = Member(object, name);
  return {NumberIn(member, "line"), NumberIn(member, "character")};
}

Json ToJson(const Position& position) {
  return {{"line", position.line}, {"character", position.character}};
}

Json RangeJson(const text::Span& span) {
  if (span.source == nullptr) return {{"start", ToJson({})}, {"end", ToJson({})}};
  return {{"start", ToJson(PositionOf(*span.source, span.begin))},
          {"end", ToJson(PositionOf(*span.source, span.end))}};
}

}  // namespace cdb::editor
