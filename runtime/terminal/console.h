// What commands say. Text may come from files of strangers: Print and Say show it without control
// characters and without marks that turn its direction (dsl::Printable). A reader that has gone is
// no error: the work goes on. Threads: one.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace cdb::terminal {

/// What was asked for, as text: to standard output.
void Print(std::string_view text);
/// The same byte for byte: for formats that have rules of their own (JSON, CSV, YAML, pages of
/// man, scenarios).
void PrintExact(std::string_view text);
/// Everything else: to standard error.
void Say(std::string_view text);
/// The same byte for byte: for diagnostics, which dsl::Render has made printable and may colour.
void SayExact(std::string_view text);

/// Hands over what was printed so far.
void Flush();
/// To be called last: hands over what was printed, and says why standard output is not complete,
/// if it is not (a full disk, a closed descriptor); `Input/output error` where the cause is not
/// known. Nothing where all was written or the reader has gone.
std::optional<std::string> FinishOutput();

/// Columns of the terminal that standard output is: COLUMNS if that is set, else its own; 0 where
/// it is a file or a pipe.
std::size_t TerminalWidth();

/// As a shell takes it for one word: in quotes where it must be.
std::string ShellWord(std::string_view text);

}  // namespace cdb::terminal
