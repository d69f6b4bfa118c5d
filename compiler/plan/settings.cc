#include "compiler/plan/settings.h"

#include <algorithm>
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
  return read_[static_cast<std::size_t>(&parameter - schema::Schema().data())];
}

void ReadRecorder::Note(std::size_t row) {
  if (read_[row]) return;
  read_[row] = true;
  ++count_;
}

void NoteRead(const schema::Parameter& parameter) {
  if (recorder != nullptr)
    recorder->Note(static_cast<std::size_t>(&parameter - schema::Schema().data()));
}

void NoteReads(bool grouped) {
  if (recorder == nullptr) return;
  for (const schema::Parameter& parameter : schema::Schema())
    if (parameter.grouped == grouped) NoteRead(parameter);
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
  CDB_CHECK(found != nullptr);
  return *found;
}

Settings::Table& Settings::OwnTable() {
  if (table_.use_count() != 1) table_ = std::make_shared<Table>(table());
  return *table_;
}

void Settings::SetValue(const schema::Parameter& parameter, schema::Value value) {
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

schema::Value BriefDefault(const schema::Parameter& parameter) {
  CDB_CHECK(parameter.is_brief && parameter.HasWord(parameter.default_text));
  const std::string word(parameter.default_text);
  if (parameter.type == schema::ParameterType::kWords) return schema::WordList{word};
  return schema::Word{word};
}

bool IsLeftOutOfPlans(std::string_view name, const schema::Value& value) {
  struct Brief {
    std::string_view name;
    schema::Value value;
  };
  static const std::vector<Brief> all = [] {
    std::vector<Brief> briefs;
    for (const schema::Parameter& parameter : schema::kParameters)
      if (parameter.is_brief) briefs.push_back({parameter.name, BriefDefault(parameter)});
    return briefs;
  }();
  return std::ranges::any_of(
      all, [&](const Brief& brief) { return brief.name == name && brief.value == value; });
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
