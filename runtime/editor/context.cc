#include "runtime/editor/context.h"

#include <algorithm>
#include <string_view>

#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/lexer.h"

namespace cdb::editor {
namespace {

using dsl::Token;
using dsl::TokenKind;
using scenario::Joined;

class ContextFinder {
 public:
  ContextFinder(const text::Source& source, std::uint32_t offset)
      : source_(source), offset_(offset), word_begin_(WordBegin()) {}

  Context Find() {
    dsl::Diagnostics unused;
    const dsl::TokenList list = dsl::Lex(source_, unused);
    context_.begin = context_.end = offset_;
    for (const text::Span& comment : list.comments)
      if (comment.begin < offset_ && offset_ <= comment.end) return context_;
    for (const Token& token : list.tokens) {
      if (token.kind == TokenKind::kEnd || token.begin >= offset_) break;
      if (token.kind != TokenKind::kText && token.begin >= word_begin_) {
        WriteFrom(word_begin_, std::max(offset_, token.end));
        break;
      }
      if (IsBeingWritten(token)) {
        WriteFrom(token.begin, token.end);
        break;
      }
      Take(token);
    }
    if (blocks_.empty()) {
      FindInFile();
    } else {
      FindInBlock();
    }
    return context_;
  }

 private:
  struct Block {
    std::string kind, label;
  };

  std::string_view TextOf(const Token& token) const {
    return source_.text().substr(token.begin, token.end - token.begin);
  }
  bool IsBeingWritten(const Token& token) const {
    return token.kind == TokenKind::kText && (offset_ < token.end || token.faulty);
  }

  void WriteFrom(std::uint32_t begin, std::uint32_t end) {
    context_.begin = begin;
    context_.end = end;
    context_.prefix = source_.text().substr(begin, offset_ - begin);
  }

  /// The start of the name before the position. The name may end with a dot: `world.`.
  std::uint32_t WordBegin() const {
    const auto is_of_name = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
             c == '_' || c == '.';
    };
    std::uint32_t begin = offset_;
    while (begin > 0 && is_of_name(source_.text()[begin - 1])) --begin;
    return begin;
  }

  void Take(const Token& token) {
    switch (token.kind) {
      case TokenKind::kLeftBrace: {
        Block block;
        if (!statement_.empty()) block.kind = TextOf(statement_[0]);
        if (statement_.size() > 1) block.label = TextOf(statement_[1]);
        blocks_.push_back(std::move(block));
        statement_.clear();
        break;
      }
      case TokenKind::kRightBrace:
        if (!blocks_.empty()) blocks_.pop_back();
        statement_.clear();
        break;
      case TokenKind::kNewline:
      case TokenKind::kSemicolon:
        statement_.clear();
        break;
      default:
        statement_.push_back(token);
    }
  }

  std::string_view Word(std::size_t index) const {
    return index < statement_.size() ? TextOf(statement_[index]) : std::string_view();
  }

  void FindInFile() {
    if (statement_.empty()) {
      context_.expected = Expected::kItem;
    } else if (Word(0) == "let") {
      if (std::ranges::any_of(statement_, IsAssign)) context_.expected = Expected::kValue;
    } else if (Word(0) == "use") {
      context_.expected = Expected::kFile;
    } else if (Word(0) == "benchmark" && TextOf(statement_.back()) == "from") {
      context_.expected = Expected::kBase;
    }
  }
  static bool IsAssign(const Token& token) { return token.kind == TokenKind::kAssign; }

  /// A case is not a block level of its own: its statements belong to the benchmark.
  void FindPlace() {
    for (std::size_t i = 1; i < blocks_.size(); ++i) {
      const Block& block = blocks_[i];
      if (block.kind == "cases") {
        ++i;  // skip the case itself
      } else if (block.kind == "objects" && context_.block.empty() && !context_.is_grouped) {
        context_.is_grouped = true;
        context_.group = block.label.empty() ? block.kind : block.label;
      } else {
        context_.block = Joined(context_.block, block.kind);
      }
    }
  }

  void FindInBlock() {
    FindPlace();
    if (blocks_.back().kind == "cases") return;  // the position is at the name of a case
    if (statement_.empty()) {
      context_.expected = Expected::kStatement;
    } else if (Word(0) == "let") {
      if (std::ranges::any_of(statement_, IsAssign)) context_.expected = Expected::kValue;
    } else if (Word(0) == "skip") {
      context_.expected = Expected::kCondition;
      FindCompared();
    } else if (Word(0) != "cases" && Word(0) != "objects") {
      context_.parameter = ParameterAt(context_, std::string(Word(0)));
      context_.expected = Expected::kValue;
    }
    FindOpenWord();
  }

  /// In `skip when detector == `, the words of `detector` are expected.
  void FindCompared() {
    for (std::size_t i = statement_.size(); i-- > 1;) {
      const TokenKind kind = statement_[i].kind;
      if (kind == TokenKind::kEqual || kind == TokenKind::kNotEqual) {
        context_.parameter = ParameterAt(context_, std::string(Word(i - 1)));
        return;
      }
      if (kind == TokenKind::kPath) return;
    }
  }

  /// Finds the word whose bracket is open: `ring(`.
  void FindOpenWord() {
    int closed = 0;
    for (std::size_t i = statement_.size(); i-- > 0;) {
      if (statement_[i].kind == TokenKind::kRightParen) ++closed;
      if (statement_[i].kind != TokenKind::kLeftParen) continue;
      if (closed-- > 0) continue;
      if (i > 0) context_.word = schema::FindParametrisedWord(Word(i - 1));
      return;
    }
  }

  const text::Source& source_;
  const std::uint32_t offset_, word_begin_;
  Context context_;
  std::vector<Block> blocks_;
  std::vector<Token> statement_;  ///< tokens of the statement up to the position
};

}  // namespace

Context ContextAt(const text::Source& source, std::uint32_t offset) {
  return ContextFinder(source, offset).Find();
}

const schema::Parameter* ParameterAt(const Context& context, const std::string& path) {
  if (const auto* found = schema::FindParameter(Joined(context.block, path), context.is_grouped))
    return found;
  if (context.is_grouped || !context.block.empty()) return nullptr;
  const std::size_t dot = path.find('.');
  return schema::FindParameter(dot == path.npos ? path : path.substr(dot + 1), true);
}

}  // namespace cdb::editor
