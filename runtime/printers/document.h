// One table, and documents of tables and sentences, printed for a terminal, in Markdown, LaTeX or
// CSV.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/figures/model.h"

namespace cdb::printers {

struct Table {
  struct Column {
    std::string head;
    bool is_number;          ///< aligned to the right
    std::string group = {};  ///< the head above adjacent columns that share it; may be empty
  };
  std::vector<Column> columns = {};
  std::vector<std::vector<std::string>> rows = {};
  std::size_t keys = 1;  ///< the number of leading columns that identify a row

  void AddColumn(std::string_view head, bool is_number, std::string_view group = {}) {
    columns.push_back({std::string(head), is_number, std::string(group)});
  }
};

/// The parts of a section are printed in this order.
struct Section {
  std::string title = {};               ///< may be empty
  std::vector<std::string> lines = {};  ///< sentences; two leading spaces continue the one above
  Table table = {};                     ///< not printed if it has no rows
  std::string plot = {};                ///< of characters
  std::vector<std::string> notes = {};  ///< as `lines`
};
using Document = std::vector<Section>;

/// `kWrapped` breaks lines and notes of more than 100 columns.
enum class Format { kTerminal, kWrapped, kMarkdown, kLatex };
/// Markdown is GitHub's dialect, which has tables. LaTeX needs the package booktabs.
std::string TextOf(const Document& document, Format format);
/// Characters of one sentence as the format writes them.
std::string EscapedText(std::string_view text, Format format);
/// The width of a line of text.
inline constexpr std::size_t kLineWidth = 100;

/// A field of CSV, quoted as RFC 4180 requires.
std::string CsvField(std::string_view text);
/// A header line, then a line for each row.
std::string CsvOf(const Table& table);

/// Text; the number of runs that failed or are void, with references; and in how many points a
/// requirement is not met.
struct Printed {
  std::string text;
  std::size_t bad_count = 0;
  std::size_t not_met_count = 0;
};

// Sentences about the runs of a results file, for summaries.

/// `all 9 runs`, `3 of 9 runs`, `the only run`.
std::string RunsText(std::size_t count, std::size_t of);
/// The number of noisy `cells`, and the cause for the one that was longest off the processor. Empty
/// if none was noisy, or the file does not say. Throws StoreError.
std::string NoiseNote(const results::ResultFile& file, const std::vector<figures::Cell>& cells);

/// If `cells` were run on several kinds of processors (model names), a sentence for each kind, and
/// whether the detectors of one point were run on different kinds; none if there is only one kind.
/// Cells without a run do not count. Throws StoreError.
std::vector<std::string> ProcessorNotes(const results::ResultFile& file,
                                        const std::vector<figures::Cell>& cells);

/// The overhead of calling a detector, and its fraction of the fastest detector's time. Empty if no
/// run states it.
std::string HarnessNote(const figures::Model& model);

/// Up to five sentences for the section of a paper on its method: machine, software and what it
/// omitted, procedure, statistic. Throws StoreError.
std::vector<std::string> MethodSentences(const figures::Model& model);

/// The simulated time of the runs: `1.67 s`, `1.00 to 2.00 s`. Empty where it is unknown: for
/// traces, and if the plan cannot be read. Throws StoreError.
std::string SimulatedTime(const figures::Model& model);

/// The reasons why timings must not be quoted: a debug build, parallel runs.
std::string BuildNote(const results::ResultFile& file);
std::string JobsNote(const results::ResultFile& file);

}  // namespace cdb::printers
