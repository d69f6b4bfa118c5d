// Printing to standard output and standard error. Text may come from untrusted files: Print and Say
// remove control characters and marks that change the direction of text (text::Printable). A reader
// that closes its end is not an error: the work continues. Threads: one.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace cdb::terminal {

/// Prints the requested output as text, to standard output.
void Print(std::string_view text);
/// Prints JSON (text::PrintableJson).
void PrintJson(std::string_view json);
/// Prints unchanged bytes: for formats with rules of their own (YAML, manual pages, scenarios).
void PrintExact(std::string_view text);
/// Prints everything else to standard error.
void Say(std::string_view text);
/// Prints unchanged bytes to standard error: for diagnostics, which dsl::Render has made printable
/// and may colour.
void SayExact(std::string_view text);

/// Flushes the output printed so far.
void Flush();
/// Call last: flushes the output. If standard output is not complete (a full disk, a closed
/// descriptor), returns the reason, or `Input/output error` if it is unknown. Nullopt if everything
/// was written or the reader has closed its end.
std::optional<std::string> FinishOutput();

/// The width of the terminal at standard output in columns: COLUMNS if that is set, else the
/// terminal's own; 0 for a file or a pipe.
std::size_t TerminalWidth();

/// Quotes the text as one word for a shell, if necessary.
std::string ShellWord(std::string_view text);

// Wraps running text to the width of a terminal.

/// Columns for running text: those of the terminal, at most 100; 100 if there is no terminal.
std::size_t TextWidth();

/// The words of `text` in lines of at most `width` columns, each after `indent` spaces and with a
/// newline. Widths count UTF-8 code points. A wider word has its own line.
std::string Wrapped(std::string_view text, std::size_t indent, std::size_t width = TextWidth());

/// Refits tables and paragraphs of any width into lines of at most `width` columns; 0 leaves them
/// unchanged. The second column of a row continues below itself, and a paragraph on its next line.
/// A line that cannot be broken stays long.
std::string Fitted(std::string_view text, std::size_t width);

}  // namespace cdb::terminal
