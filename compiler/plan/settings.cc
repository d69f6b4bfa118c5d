#include "compiler/plan/settings.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "compiler/schema/schema.h"
#include "dsl/text/check.h"

namespace cdb::plan {
namespace {

template <typename T>
const T& As(const schema::Value& value) {
  const T* typed = std::get_if<T>(&value);
  CDB_CHECK(typed != nullptr);
  return *typed;
}

thread_local ReadRecorder* recorder = nullptr;

/// The parts of a text between separators: `0, -9.8, 0`.
std::vector<std::string_view> Parts(std::string_view text, std::string_view separator) {
  std::vector<std::string_view> parts;
  for (std::size_t end; (end = text.find(separator)) != text.npos;
       text.remove_prefix(end + separator.size()))
    parts.push_back(text.substr(0, end));
  parts.push_back(text);
  return parts;
}

/// The number, or quotient of two, in a default: `0.5`, `1 / 60`. Nullopt for an expression of
/// names.
std::optional<double> RealIn(std::string_view text) {
  std::optional<double> value;
  for (const std::string_view part : Parts(text, " / ")) {
    double number = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (error != std::errc{} || end != part.data() + part.size()) return std::nullopt;
    value = value ? *value / number : number;
  }
  return value;
}

std::uint64_t CountIn(std::string_view text) {
  const bool is_hex = text.starts_with("0x");
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  CDB_CHECK(std::from_chars(text.data() + (is_hex ? 2 : 0), end, value, is_hex ? 16 : 10).ptr ==
            end);
  return value;
}

Eigen::Vector3d TripleIn(std::string_view text, std::string_view separator) {
  const auto parts = Parts(text, separator);
  CDB_CHECK(parts.size() == 3);
  return {*RealIn(parts[0]), *RealIn(parts[1]), *RealIn(parts[2])};
}

/// Nullopt for an expression of names.
std::optional<schema::Value> FirstDefault(const schema::Parameter& parameter) {
  using enum schema::ParameterType;
  const std::string_view text = parameter.first_default;
  if (parameter.type != kWords && parameter.HasWord(text)) return schema::Word{std::string(text)};
  switch (parameter.type) {
    case kCount:
      return CountIn(text);
    case kReal:
      return RealIn(text);
    case kSwitch:
      return text == "on";
    case kVector:
      if (text == "0") return Eigen::Vector3d(Eigen::Vector3d::Zero());
      return TripleIn(text.substr(1, text.size() - 2), ", ");
    case kRatio:
      return schema::Ratio{TripleIn(text, " : ")};
    case kWords: {
      schema::WordList words;
      for (const std::string_view word : Parts(text, ", ")) words.emplace_back(word);
      std::ranges::sort(words);
      return words;
    }
    case kWord:
    case kText:
      break;
  }
  CDB_CHECK(false);
}

std::size_t RowOf(const schema::Parameter& parameter) {
  return static_cast<std::size_t>(&parameter - schema::Schema().data());
}

/// The entry of the parameter, or its insertion point.
template <typename Table>
auto LowerBound(Table& table, const schema::Parameter& parameter) {
  return std::ranges::lower_bound(table, parameter.name, {},
                                  [](const auto& entry) { return entry.parameter->name; });
}

}  // namespace

ReadRecorder::ReadRecorder() : read_(schema::Schema().size()), outer_(recorder) { recorder = this; }

ReadRecorder::~ReadRecorder() { recorder = outer_; }

bool ReadRecorder::HasRead(const schema::Parameter& parameter) const {
  return read_[RowOf(parameter)];
}

void ReadRecorder::Note(std::size_t row) {
  if (read_[row]) return;
  read_[row] = true;
  ++count_;
}

void NoteRead(const schema::Parameter& parameter) {
  if (recorder != nullptr) recorder->Note(RowOf(parameter));
}

void NoteReads(bool grouped) {
  if (recorder == nullptr) return;
  for (const schema::Parameter& parameter : schema::Schema())
    if (parameter.grouped == grouped) NoteRead(parameter);
}

const schema::Value* ValueIfAbsent(const schema::Parameter& parameter) {
  static const auto all = [] {
    std::vector<std::optional<schema::Value>> values;
    for (const schema::Parameter& row : schema::Schema()) values.push_back(FirstDefault(row));
    return values;
  }();
  const auto& value = all[RowOf(parameter)];
  return value ? &*value : nullptr;
}

const Settings::Table& Settings::table() const {
  static const Table empty;
  return table_ == nullptr ? empty : *table_;
}

const schema::Value* Settings::Find(const schema::Parameter& parameter) const {
  const auto found = LowerBound(table(), parameter);
  return found != table().end() && found->parameter->name == parameter.name ? found->value.get()
                                                                            : nullptr;
}

const schema::Value& Settings::ValueOf(const schema::Parameter& parameter) const {
  NoteRead(parameter);
  const schema::Value* found = Find(parameter);
  if (found == nullptr) found = ValueIfAbsent(parameter);
  CDB_CHECK(found != nullptr);
  return *found;
}

Settings::Table& Settings::OwnTable() {
  if (table_.use_count() != 1) table_ = std::make_shared<Table>(table());
  return *table_;
}

void Settings::SetValue(const schema::Parameter& parameter, schema::Value value) {
  const schema::Value* absent = ValueIfAbsent(parameter);
  if (absent != nullptr && schema::IsIdentical(*absent, value)) return EraseValue(parameter);
  Table& table = OwnTable();
  auto at = LowerBound(table, parameter);
  if (at == table.end() || at->parameter->name != parameter.name)
    at = table.insert(at, {&parameter, nullptr});
  at->value = std::make_shared<const schema::Value>(std::move(value));
}

void Settings::EraseValue(const schema::Parameter& parameter) {
  if (Find(parameter) == nullptr) return;
  Table& table = OwnTable();
  table.erase(LowerBound(table, parameter));
}

bool Settings::operator==(const Settings& other) const {
  return table_ == other.table_ ||
         std::ranges::equal(table(), other.table(), [](const Entry& a, const Entry& b) {
           return a.parameter->name == b.parameter->name &&
                  (a.value == b.value || *a.value == *b.value);
         });
}

template <bool kGrouped>
double SettingsOf<kGrouped>::Real(Parameter<schema::ValueKind::kReal> parameter) const {
  return As<schema::Number>(Get(parameter)).AsReal();
}

template <bool kGrouped>
std::uint64_t SettingsOf<kGrouped>::Count(Parameter<schema::ValueKind::kCount> parameter) const {
  return As<schema::Number>(Get(parameter)).AsCount();
}

template <bool kGrouped>
bool SettingsOf<kGrouped>::On(Parameter<schema::ValueKind::kSwitch> parameter) const {
  return As<bool>(Get(parameter));
}

template <bool kGrouped>
std::string_view SettingsOf<kGrouped>::WordOr(Parameter<schema::ValueKind::kWord> parameter,
                                              std::string_view otherwise) const {
  const auto* word = std::get_if<schema::Word>(&Get(parameter));
  return word != nullptr ? std::string_view(word->text) : otherwise;
}

template <bool kGrouped>
Eigen::Vector3d SettingsOf<kGrouped>::Vector(
    Parameter<schema::ValueKind::kVector> parameter) const {
  return As<Eigen::Vector3d>(Get(parameter));
}

template <bool kGrouped>
const schema::WordList& SettingsOf<kGrouped>::Words(
    Parameter<schema::ValueKind::kWords> parameter) const {
  return As<schema::WordList>(Get(parameter));
}

template <bool kGrouped>
bool SettingsOf<kGrouped>::Lists(Parameter<schema::ValueKind::kWords> parameter,
                                 std::string_view word) const {
  const schema::WordList& words = Words(parameter);
  return std::ranges::find(words, word) != words.end();
}

template class SettingsOf<false>;
template class SettingsOf<true>;

}  // namespace cdb::plan
