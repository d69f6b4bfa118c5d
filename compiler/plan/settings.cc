#include "compiler/plan/settings.h"

#include <algorithm>
#include <vector>

#include "compiler/schema/schema.h"
#include "dsl/check.h"

namespace cdb::plan {
namespace {

template <typename T>
const T& As(const schema::Value& value) {
  const T* typed = std::get_if<T>(&value);
  CDB_CHECK(typed != nullptr);
  return *typed;
}

thread_local ReadRecorder* recorder = nullptr;

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

const schema::Value& Settings::ValueOf(const schema::Parameter& parameter) const {
  NoteRead(parameter);
  const auto found = values_.find(parameter.name);
  CDB_CHECK(found != values_.end());
  return found->second;
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
