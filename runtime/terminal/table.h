// Text tables with aligned columns.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::terminal {

/// A table for a terminal: a head, a rule, rows. Numbers are aligned to the right, words to the
/// left.
class Table {
 public:
  /// `keys`: the number of leading columns that identify a row.
  explicit Table(std::size_t keys = 1) : keys_(keys) {}

  /// `right`: aligned to the right. Adjacent columns that share a `group` have it in a line above.
  void AddColumn(std::string head, bool right, std::string group = {});
  void AddRow(std::vector<std::string> cells);
  /// Beyond the width of the terminal, or 100 columns without one, break cells at spaces instead of
  /// splitting the table into parts.
  void KeepWhole() { is_whole_ = true; }
  bool empty() const { return rows_.empty(); }
  /// Each line ends with a newline; no line ends with a space. Widths count UTF-8 code points.
  /// A table that is wider than the terminal (console.h) is split into several parts, each with the
  /// keys of its rows.
  std::string Text() const;

 private:
  Table NoWiderThan(std::size_t screen) const;
  std::vector<std::size_t> Widths() const;
  std::string TextOf(const std::vector<std::size_t>& widths) const;
  std::string GroupLine(const std::vector<std::size_t>& widths,
                        const std::vector<std::size_t>& columns) const;
  std::string PartText(const std::vector<std::size_t>& widths,
                       const std::vector<std::size_t>& columns) const;

  struct Column {
    std::string head;
    bool right;
    std::string group;
  };
  const std::size_t keys_;
  bool is_whole_ = false;
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// The unit in which a number of nanoseconds is easiest to read.
struct TimeUnit {
  const char* name;
  double ns;
  static TimeUnit For(double ns) {
    if (ns >= 1e9) return {"s", 1e9};
    if (ns >= 1e6) return {"ms", 1e6};
    if (ns >= 1e3) return {"us", 1e3};
    return {"ns", 1};
  }
};

/// Three significant digits, or four from 1000 on: `0.0123`, `1.23`, `1235`, `12350`; with an
/// exponent below 1e-4 and from 1e7 on. `-` if it is not finite.
std::string ShortNumber(double value);

/// `3 values of detector x 5 of quantity x 9 repeats`: the grid of runs; empty for one run.
std::string GridText(const std::vector<plan::Axis>& axes, std::uint64_t repeats);

/// The text of a value on an axis (compiler/plan/plan.h).
std::string CoordinateText(const plan::Axis& axis, std::size_t index);

}  // namespace cdb::terminal
