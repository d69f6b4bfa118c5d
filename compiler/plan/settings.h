// The settings of the world and of groups of objects.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/schema/parameter_ref.h"
#include "compiler/schema/value.h"

namespace cdb::plan {

/// Notes a read in the ReadRecorder of this thread, if there is one.
void NoteRead(const schema::Parameter& parameter);
/// Notes a read of every parameter of groups, or of the world.
void NoteReads(bool grouped);

/// Records, during its lifetime, the parameters that its thread reads from any settings, so that a
/// function of a scene can be evaluated once for all scenes that agree in these. Only the innermost
/// recorder of a thread records. A function that reads other members of a scene (seeds) must note
/// these itself.
class ReadRecorder {
 public:
  ReadRecorder();
  ~ReadRecorder();
  ReadRecorder(const ReadRecorder&) = delete;
  ReadRecorder& operator=(const ReadRecorder&) = delete;

  bool HasRead(const schema::Parameter& parameter) const;
  /// Increases with each parameter read for the first time.
  std::size_t count() const { return count_; }

 private:
  friend void NoteRead(const schema::Parameter& parameter);

  void Note(std::size_t row);

  std::vector<bool> read_;  ///< by row of the schema
  std::size_t count_ = 0;
  ReadRecorder* outer_;
};

/// Values by the name of the parameter without its group: `timestep`, `world.side`; in a group
/// `quantity`, `size`. Holds only those that differ from ValueIfAbsent, as plans and the ids of
/// runs do; every other parameter has that value. For parameters known only at run time; code that
/// names a parameter uses SettingsOf. Copies share equal values, as the scenes of a sweep differ in
/// few. Threads: one for an object and its copies.
class Settings {
  struct Entry {
    const schema::Parameter* parameter;
    std::shared_ptr<const schema::Value> value;
  };
  using Table = std::vector<Entry>;

 public:
  /// A name and a value: `for (const auto& [name, value] : settings)`.
  class Iterator {
   public:
    using value_type = std::pair<std::string_view, const schema::Value&>;
    using difference_type = std::ptrdiff_t;
    value_type operator*() const { return {at_->parameter->name, *at_->value}; }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    Iterator operator++(int) { return std::exchange(*this, Iterator(at_ + 1)); }
    bool operator==(const Iterator&) const = default;

   private:
    friend class Settings;
    explicit Iterator(const Entry* at) : at_(at) {}
    const Entry* at_;
  };

  /// Those held, in the order of their names. Counts as a read of every parameter, of the world and
  /// of groups.
  Iterator begin() const {
    NoteReads(false);
    NoteReads(true);
    return First();
  }
  Iterator end() const { return Iterator(table().data() + table().size()); }
  std::size_t size() const { return table().size(); }

  /// True if it is held: it differs from ValueIfAbsent, or has none.
  bool Has(const schema::Parameter& parameter) const {
    NoteRead(parameter);
    return Find(parameter) != nullptr;
  }
  /// A parameter without a ValueIfAbsent must be held (CDB_CHECK).
  const schema::Value& ValueOf(const schema::Parameter& parameter) const;
  void SetValue(const schema::Parameter& parameter, schema::Value value);
  /// Restores the ValueIfAbsent.
  void EraseValue(const schema::Parameter& parameter);

  bool operator==(const Settings& other) const;

 protected:
  Iterator First() const { return Iterator(table().data()); }

 private:
  const Table& table() const;
  /// Null if absent.
  const schema::Value* Find(const schema::Parameter& parameter) const;
  /// The table, copied first if it is shared.
  Table& OwnTable();

  std::shared_ptr<Table> table_;  ///< by name; null: empty; modified through OwnTable
};

/// The value that settings without the parameter have: its first default. Null if that is an
/// expression of other parameters.
const schema::Value* ValueIfAbsent(const schema::Parameter& parameter);

/// The settings of the world, or of a group. A parameter of the other kind, an unknown one or one
/// of another type is a compile error. If the parameter has several types, a value of another type
/// is an internal error (CDB_CHECK).
template <bool kGrouped>
class SettingsOf : public Settings {
 public:
  template <schema::ValueKind kKind = schema::ValueKind::kAny>
  using Parameter = schema::ParameterRef<kGrouped, kKind>;

  /// In the order of their names. Counts as a read of each.
  Iterator begin() const {
    NoteReads(kGrouped);
    return First();
  }
  const schema::Value& Get(Parameter<> parameter) const { return ValueOf(*parameter); }
  /// Also accepts counts.
  double Real(Parameter<schema::ValueKind::kReal> parameter) const;
  std::uint64_t Count(Parameter<schema::ValueKind::kCount> parameter) const;
  bool On(Parameter<schema::ValueKind::kSwitch> parameter) const;
  /// The word, or `otherwise` if the value is not a word (`mass fixed` against `mass 1`).
  std::string_view WordOr(Parameter<schema::ValueKind::kWord> parameter,
                          std::string_view otherwise = {}) const;
  Eigen::Vector3d Vector(Parameter<schema::ValueKind::kVector> parameter) const;
  const schema::WordList& Words(Parameter<schema::ValueKind::kWords> parameter) const;
  bool Lists(Parameter<schema::ValueKind::kWords> parameter, std::string_view word) const;

  void Set(Parameter<> parameter, schema::Value value) { SetValue(*parameter, std::move(value)); }
  void Erase(Parameter<> parameter) { EraseValue(*parameter); }

  bool operator==(const SettingsOf&) const = default;
};

using WorldSettings = SettingsOf<false>;
using GroupSettings = SettingsOf<true>;

extern template class SettingsOf<false>;
extern template class SettingsOf<true>;

}  // namespace cdb::plan
