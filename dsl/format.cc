#include "dsl/format.h"

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_set>
#include <variant>
#include <vector>

#include "dsl/lexer.h"
#include "dsl/parser.h"
#include "dsl/text/check.h"

namespace cdb::dsl {
namespace {

constexpr std::size_t kGap = 2;  // between the longest name and the column of values

// The roles of tokens that their kinds do not tell, by offset.
struct Roles {
  std::unordered_set<std::uint32_t> signs;     // a `-` that negates
  std::unordered_set<std::uint32_t> labels;    // the `sd` of `sd: 3`
  std::unordered_set<std::uint32_t> calls;     // the name of a function
  std::unordered_set<std::uint32_t> settings;  // the path of a setting
  std::unordered_set<std::uint32_t> opens;     // the end of the name in a call without brackets
  std::unordered_set<std::uint32_t> closes;    // the end of the argument of such a call
  std::unordered_set<std::uint32_t> units;     // every byte of a unit after its first
};

class RoleFinder {
 public:
  explicit RoleFinder(std::string_view text) : text_(text) {}

  Roles Find(const File& file) {
    for (const auto& item : file.items) {
      if (const auto* let = std::get_if<Let>(&item)) Visit(*let->value);
      if (const auto* benchmark = std::get_if<Benchmark>(&item)) Visit(benchmark->block);
    }
    return std::move(roles_);
  }

 private:
  // The offset of an expression's first token after the brackets around it, where its span begins.
  // All brackets before a `-` or the name of a call enclose the whole expression.
  std::uint32_t FirstInside(const Expr& expr) const {
    std::size_t at = expr.span.begin;
    while (text_[at] == '(' || text_[at] == ' ' || text_[at] == '\t' || text_[at] == '\n' ||
           text_[at] == '\r' || text_[at] == '#') {
      at = text_[at] == '#' ? text_.find('\n', at) : at + 1;
    }
    return static_cast<std::uint32_t>(at);
  }
  void Visit(const Expr& expr) {
    if (expr.kind == ExprKind::kNegate) roles_.signs.insert(FirstInside(expr));
    if (expr.kind == ExprKind::kCall) roles_.calls.insert(FirstInside(expr));
    if (expr.zip) roles_.calls.insert(expr.zip->span.begin);
    if (expr.bare) {
      roles_.opens.insert(FirstInside(expr) + static_cast<std::uint32_t>(expr.text.size()));
      roles_.closes.insert(expr.arguments[0].value->span.end);
    }
    if (expr.kind == ExprKind::kQuantity)
      for (std::uint32_t at = expr.text_span.begin + 1; at < expr.text_span.end; ++at)
        roles_.units.insert(at);
    for (const ExprPtr& item : expr.items) Visit(*item);
    for (const Argument& argument : expr.arguments) {
      if (argument.name) roles_.labels.insert(argument.name->span.begin);
      Visit(*argument.value);
    }
    if (!expr.until) return;
    roles_.labels.insert(expr.until_span.begin);
    Visit(*expr.until);
  }
  void Visit(const Condition& condition) {
    if (condition.left) Visit(*condition.left);
    if (condition.right) Visit(*condition.right);
    for (const ExprPtr& value : condition.values) Visit(*value);
    for (const ConditionPtr& item : condition.items) Visit(*item);
  }
  void Visit(const Block& block) {
    for (const Statement& statement : block.statements)
      std::visit([this](const auto& what) { Visit(what); }, statement.what);
  }
  void Visit(const Let& let) { Visit(*let.value); }
  void Visit(const Cases& cases) {
    for (const Case& one : cases.cases) Visit(one.block);
  }
  void Visit(const Skip& skip) { Visit(*skip.when); }
  void Visit(const Require& require) { Visit(*require.what); }
  void Visit(const Group& group) { Visit(group.block); }
  void Visit(const Setting& setting) {
    roles_.settings.insert(setting.path.span.begin);
    for (const ExprPtr& value : setting.values) Visit(*value);
  }

  std::string_view text_;
  Roles roles_;
};

// One line of the result. A setting at the start of a line has its name apart from the rest.
struct Line {
  std::size_t indent = 0;  // columns
  std::string text;
  std::size_t name_length = 0;  // of a setting at the start of the line, otherwise 0
  bool blank_before = false;
  bool file_level = false;
};

class Formatter {
 public:
  explicit Formatter(const text::Source& source) : source_(source), text_(source.text()) {}

  std::string Run() {
    Diagnostics diagnostics;
    // The caller's source outlives this call, so the tree does not need to own it.
    const std::shared_ptr<const text::Source> source(std::shared_ptr<void>(), &source_);
    roles_ = RoleFinder(text_).Find(Parse(source, diagnostics));
    CDB_CHECK(!diagnostics.has_errors());
    Collect();
    FindLongBlocks();
    Write();
    return Lay();
  }

 private:
  struct Piece {
    TokenKind kind;
    bool comment = false;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    int lines_before = 0;     // line ends between the previous piece and this one
    bool long_block = false;  // for a brace: its block has more than one line
  };                          // a bracket that the formatter inserts is an empty piece

  std::string_view TextOf(const Piece& piece) const {
    if (piece.begin == piece.end) return piece.kind == TokenKind::kLeftParen ? "(" : ")";
    return text_.substr(piece.begin, piece.end - piece.begin);
  }

  // Collects tokens and comments in order, each with the number of line ends before it.
  void Collect() {
    Diagnostics ignored;
    const TokenList list = Lex(source_, ignored);
    std::size_t comment = 0;
    const auto add_comments_before = [&](std::uint32_t offset) {
      for (; comment < list.comments.size() && list.comments[comment].begin < offset; ++comment)
        pieces_.push_back({TokenKind::kUnknown, true, list.comments[comment].begin,
                           list.comments[comment].end, 0, false});
    };
    for (const Token& token : list.tokens) {
      add_comments_before(token.begin);
      if (token.kind == TokenKind::kNewline || token.kind == TokenKind::kEnd) continue;
      pieces_.push_back({token.kind, false, token.begin, token.end, 0, false});
      const auto add_bracket = [&](TokenKind kind) {
        pieces_.push_back({kind, false, token.end, token.end, 0, false});
      };
      if (roles_.opens.count(token.end) > 0) add_bracket(TokenKind::kLeftParen);
      if (roles_.closes.count(token.end) > 0) add_bracket(TokenKind::kRightParen);
    }
    add_comments_before(static_cast<std::uint32_t>(text_.size()) + 1);
    std::uint32_t last = 0;
    for (Piece& piece : pieces_) {
      const std::string_view gap = text_.substr(last, piece.begin - last);
      piece.lines_before = static_cast<int>(std::count(gap.begin(), gap.end(), '\n'));
      last = piece.end;
    }
  }

  void FindLongBlocks() {
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (pieces_[i].lines_before > 0)
        for (const std::size_t brace : open) pieces_[brace].long_block = true;
      if (pieces_[i].comment) continue;
      if (pieces_[i].kind == TokenKind::kLeftBrace) open.push_back(i);
      if (pieces_[i].kind != TokenKind::kRightBrace) continue;
      pieces_[i].long_block = pieces_[open.back()].long_block;
      open.pop_back();
    }
  }

  bool BreaksBefore(std::size_t i) const {
    const Piece& piece = pieces_[i];
    if (i == 0) return true;
    const Piece& before = pieces_[i - 1];
    if (piece.lines_before > 0) return true;
    if (piece.comment) return false;
    if (before.comment) return true;
    if (before.kind == TokenKind::kLeftBrace && before.long_block) return true;
    if (piece.kind == TokenKind::kRightBrace && piece.long_block) return true;
    return before.kind == TokenKind::kRightBrace && before.long_block &&
           piece.kind != TokenKind::kSemicolon;
  }

  bool SpaceBetween(std::size_t i) const {
    const Piece& before = pieces_[i - 1];
    const Piece& piece = pieces_[i];
    // `m/s^2` without spaces, `N s` with one.
    if (roles_.units.count(piece.begin) > 0)
      return before.kind == TokenKind::kPath && piece.kind == TokenKind::kPath;
    switch (piece.kind) {
      case TokenKind::kRightParen:
      case TokenKind::kComma:
      case TokenKind::kSemicolon:
        return false;
      case TokenKind::kColon:
        return roles_.labels.count(before.begin) == 0;
      case TokenKind::kLeftParen:
        if (roles_.calls.count(before.begin) > 0) return false;
        break;
      default:
        break;
    }
    if (before.kind == TokenKind::kLeftParen) return false;
    return before.kind != TokenKind::kMinus || roles_.signs.count(before.begin) == 0;
  }

  void Write() {
    std::size_t level = 0;     // of blocks
    std::size_t brackets = 0;  // open ones
    bool in_statement = false;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const Piece& piece = pieces_[i];
      const bool closes_block = !piece.comment && piece.kind == TokenKind::kRightBrace;
      const bool closes_list = !piece.comment && piece.kind == TokenKind::kRightParen;
      if (closes_block) --level;
      if (BreaksBefore(i)) {
        // A statement ends with its line, except after `,` and inside brackets.
        in_statement = i > 0 && (brackets > 0 || EndsWithComma(i));
        Line line;
        const std::size_t inside = brackets - (closes_list ? 1 : 0);
        const std::size_t steps =
            in_statement ? level + (closes_list ? inside : std::max<std::size_t>(inside, 1))
                         : level;
        line.indent = 2 * steps;
        const bool opens =
            i > 0 && pieces_[i - 1].kind == TokenKind::kLeftBrace && !pieces_[i - 1].comment;
        line.blank_before = piece.lines_before > 1 && i > 0 && !opens && !closes_block;
        line.file_level = level == 0;
        lines_.push_back(std::move(line));
        if (!in_statement && roles_.settings.count(piece.begin) > 0)
          lines_.back().name_length = piece.end - piece.begin;
      } else if (piece.comment) {
        lines_.back().text += "  ";
      } else if (SpaceBetween(i)) {
        lines_.back().text += ' ';
      }
      lines_.back().text += TextOf(piece);
      if (piece.comment) continue;
      if (piece.kind == TokenKind::kLeftBrace) ++level;
      if (piece.kind == TokenKind::kLeftParen) ++brackets;
      if (closes_list) --brackets;
    }
  }

  // Whether the last token before this piece is a comma; comments between do not count.
  bool EndsWithComma(std::size_t i) const {
    while (i > 0 && pieces_[i - 1].comment) --i;
    return i > 0 && pieces_[i - 1].kind == TokenKind::kComma;
  }

  // The settings of one benchmark have their values in one column, on all levels, up to a blank
  // line.
  std::string Lay() {
    std::string out;
    for (std::size_t first = 0; first < lines_.size();) {
      std::size_t last = first + 1;
      while (last < lines_.size() && !lines_[last].blank_before && !lines_[last].file_level) ++last;
      std::size_t column = 0;
      for (std::size_t i = first; i < last; ++i)
        if (lines_[i].name_length > 0)
          column = std::max(column, lines_[i].indent + lines_[i].name_length + kGap);
      for (std::size_t i = first; i < last; ++i) {
        const Line& line = lines_[i];
        if (line.blank_before) out += '\n';
        out.append(line.indent, ' ');
        if (line.name_length == 0) {
          out += line.text;
        } else {
          // One space already follows the name.
          out += line.text.substr(0, line.name_length);
          out.append(column - line.indent - line.name_length - 1, ' ');
          out += line.text.substr(line.name_length);
        }
        out += '\n';
      }
      first = last;
    }
    return out;
  }

  const text::Source& source_;
  std::string_view text_;
  Roles roles_;
  std::vector<Piece> pieces_;
  std::vector<Line> lines_;
};

}  // namespace

std::string Format(const text::Source& source) { return Formatter(source).Run(); }

}  // namespace cdb::dsl
