// A recursive-descent parser; its depth is capped, and nothing is ever evaluated.
#include "expr/parse.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "caps.h"
#include "error.h"
#include "expr/build.h"

namespace irt {
namespace {

enum class Kind { Number, Name, Sign, End };

struct Token {
  Kind kind;
  std::string text;
  std::size_t column;
  bool spaced = false;  // white space stands before it
};

bool digit(char c) { return c >= '0' && c <= '9'; }
bool letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

[[noreturn]] void fail(std::size_t column, const std::string& what) {
  throw ExpressionError(fmt::format("{} at column {}", what, column));
}

[[noreturn]] void fail(std::size_t column, const std::string& what, const std::string& hint) {
  throw ExpressionError(fmt::format("{} at column {}; {}", what, column, hint));
}

std::vector<Token> tokenize(const std::string& text) {
  // Signs from textbooks and what they mean.
  static constexpr std::pair<const char*, const char*> kSigns[] = {
      {"\xe2\x88\x92", "-"}, {"\xc2\xb7", "*"}, {"\xe2\x8b\x85", "*"}, {"\xc3\x97", "*"}, {"\xc2\xb2", "^2"}, {"\xc2\xb3", "^3"},
      {"\xe2\x88\x9a", "sqrt"}, {"\xe2\x89\xa4", "<="}, {"\xe2\x89\xa5", ">="}, {"\xe2\x89\xa0", "!="}};
  std::vector<Token> tokens;
  std::size_t column = 1;
  bool spaced = false;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    const std::size_t at = column;
    const auto push = [&](Kind kind, std::string s, std::size_t bytes, std::size_t width) {
      tokens.push_back({kind, std::move(s), at, spaced});
      spaced = false;
      i += bytes;
      column += width;
    };
    if (c == ' ' || c == '\t' || c == '\n' || c == '\r') {
      spaced = true;
      ++i, ++column;
    } else if (digit(c) || (c == '.' && i + 1 < text.size() && digit(text[i + 1]))) {
      std::size_t j = i;
      while (j < text.size() && digit(text[j])) ++j;
      if (j < text.size() && text[j] == '.') {
        ++j;
        while (j < text.size() && digit(text[j])) ++j;
      }
      // An exponent only where digits follow: 2e is 2 times the symbol e.
      if (j < text.size() && (text[j] == 'e' || text[j] == 'E')) {
        std::size_t k = j + 1;
        if (k < text.size() && (text[k] == '+' || text[k] == '-')) ++k;
        if (k < text.size() && digit(text[k])) {
          while (k < text.size() && digit(text[k])) ++k;
          j = k;
        }
      }
      push(Kind::Number, text.substr(i, j - i), j - i, j - i);
    } else if (letter(c)) {
      std::size_t j = i;
      while (j < text.size() && (letter(text[j]) || digit(text[j]))) ++j;
      push(Kind::Name, text.substr(i, j - i), j - i, j - i);
    } else if (text.compare(i, 2, "\xcf\x80") == 0) {
      push(Kind::Name, "pi", 2, 1);
    } else if (static_cast<unsigned char>(c) >= 0x80) {
      const auto* sign = std::find_if(std::begin(kSigns), std::end(kSigns), [&](const auto& s) { return text.compare(i, std::string(s.first).size(), s.first) == 0; });
      std::size_t bytes = 1;
      while (i + bytes < text.size() && (static_cast<unsigned char>(text[i + bytes]) & 0xc0) == 0x80) ++bytes;
      if (sign == std::end(kSigns)) fail(at, fmt::format("unknown character '{}'", text.substr(i, bytes)), "names and signs are ASCII, but for − · ² ³ π √");
      push(Kind::Sign, sign->second, bytes, 1);
    } else {
      static constexpr const char* kDouble[] = {"**", "<=", ">=", "==", "!="};
      const auto* two = std::find_if(std::begin(kDouble), std::end(kDouble), [&](const char* s) { return text.compare(i, 2, s) == 0; });
      if (two != std::end(kDouble)) {
        push(Kind::Sign, *two == std::string("**") ? "^" : *two, 2, 2);
      } else if (std::string("+-*/^()=<>,").find(c) != std::string::npos) {
        push(Kind::Sign, std::string(1, c), 1, 1);
      } else {
        const std::string shown = static_cast<unsigned char>(c) < 0x20 ? fmt::format("\\x{:02x}", c) : std::string(1, c);
        fail(at, fmt::format("unknown character '{}'", shown), "a formula has names, numbers, + - * / ^ ( ) , = and comparisons");
      }
    }
  }
  tokens.push_back({Kind::End, "", column, spaced});
  return tokens;
}

// Edits between two words: the least number of changed, added, dropped or swapped letters.
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

// Other names by which functions are known.
constexpr std::pair<const char*, const char*> kAliases[] = {
    {"abs", "Abs"}, {"min", "Min"}, {"max", "Max"}, {"mod", "Mod"}, {"ceil", "ceiling"}, {"ln", "log"},
    {"arcsin", "asin"}, {"arccos", "acos"}, {"arctan", "atan"}, {"sgn", "sign"}};

class Parser {
 public:
  explicit Parser(const std::string& text) : tokens_(tokenize(text)) {}

  Expr formula() {
    if (peek().kind == Kind::End) throw ExpressionError("the formula is empty; write something like x^2 + y^2 + z^2 - 1");
    Expr e = condition();
    if (sign("=")) {
      const std::size_t at = next().column;
      const Expr right = condition();
      if (e.is_condition() || right.is_condition()) fail(at, "an equation of conditions");
      if (sign("=")) fail(peek().column, "a second '='", "a formula has at most one");
      e = sub(e, right);
    }
    if (peek().kind != Kind::End) unexpected();
    return e;
  }

 private:
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  std::size_t depth_ = 0;

  const Token& peek() const { return tokens_[at_]; }
  const Token& next() { return tokens_[at_++]; }
  bool sign(const char* s) const { return peek().kind == Kind::Sign && peek().text == s; }

  [[noreturn]] void unexpected() const {
    if (peek().kind == Kind::End) fail(peek().column, "the formula ends too early", "a number, a name or '(' is missing");
    if (sign(")")) fail(peek().column, "unexpected ')'", "it closes nothing, or something is missing before it");
    fail(peek().column, fmt::format("unexpected '{}'", peek().text), "expected an operator, a number, a name or a parenthesis");
  }

  void expect(const char* s) {
    if (sign(s)) {
      ++at_;
      return;
    }
    fail(peek().column, peek().kind == Kind::End ? fmt::format("the formula ends where '{}' is missing", s)
                                                 : fmt::format("expected '{}', found '{}'", s, peek().text));
  }

  // One level of what opens at a column: parentheses, a call, a root or an exponent. All recursion leads through one.
  struct Deeper {
    Deeper(Parser& p, std::size_t column) : parser(p) {
      if (++parser.depth_ > limits::kParseDepth)
        throw LimitError(fmt::format("level {} of parentheses, calls and exponents in one another at column {}; the limit is {}", parser.depth_, column, limits::kParseDepth));
    }
    ~Deeper() { --parser.depth_; }
    Parser& parser;
  };

  Expr value(Expr e, std::size_t column) {
    if (e.is_condition()) fail(column, "a condition where a value is expected", "use Piecewise((value, condition), ...)");
    return e;
  }

  static bool comparison(const Token& t) {
    return t.kind == Kind::Sign && (t.text == "<" || t.text == "<=" || t.text == ">" || t.text == ">=" || t.text == "==" || t.text == "!=");
  }

  Expr condition() {
    const std::size_t column = peek().column;
    Expr left = sum();
    if (!comparison(peek())) return left;
    const std::string op = next().text;
    left = value(left, column);
    const std::size_t right_column = peek().column;
    const Expr right = value(sum(), right_column);
    if (comparison(peek())) fail(peek().column, "a chained comparison", "write And(a < b, b < c)");
    const Expr pair[] = {left, right}, swapped[] = {right, left};
    if (op == "<") return call(Op::Less, pair);
    if (op == "<=") return call(Op::LessEqual, pair);
    if (op == ">") return call(Op::Less, swapped);
    if (op == ">=") return call(Op::LessEqual, swapped);
    return call(op == "==" ? Op::Equal : Op::Unequal, pair);
  }

  Expr sum() {
    std::size_t column = peek().column;
    Expr first = product();
    if (!sign("+") && !sign("-")) return first;
    std::vector<Expr> terms{value(first, column)};
    while (sign("+") || sign("-")) {
      const bool minus = next().text == "-";
      column = peek().column;
      const Expr term = value(product(), column);
      terms.push_back(minus ? neg(term) : term);
    }
    return add(terms);
  }

  // What can follow a factor without a sign between them.
  bool juxtaposed() const { return peek().kind == Kind::Name || peek().kind == Kind::Number || sign("(") || sign("sqrt"); }

  Expr product() {
    std::size_t column = peek().column;
    Expr left = unary();
    while (sign("*") || sign("/") || juxtaposed()) {
      left = value(left, column);
      const bool divides = sign("/");
      if (sign("*") || divides) {
        ++at_;
      } else if (peek().kind == Kind::Number) {
        fail(peek().column, fmt::format("unexpected number '{}'", peek().text), "write * between factors when the second is a number");
      }
      column = peek().column;
      const Expr right = value(unary(), column);
      if (divides && right == Expr(0L)) fail(column, "division by zero");
      left = divides ? div(left, right) : mul(left, right);
    }
    return left;
  }

  Expr unary() {
    bool minus = false;
    while (sign("+") || sign("-")) minus ^= next().text == "-";
    const std::size_t column = peek().column;
    Expr e = power();
    return minus ? neg(value(e, column)) : e;
  }

  Expr power() {
    const std::size_t column = peek().column;
    Expr base = atom();
    if (sign("^2") || sign("^3")) {
      base = pow(value(base, column), Expr(next().text == "^2" ? 2L : 3L));
      if (sign("^2") || sign("^3")) fail(peek().column, "a superscript after a superscript", "write larger powers as x^23 or x**23");
    }
    if (!sign("^")) return base;
    const Deeper deeper(*this, next().column);
    const std::size_t exponent_column = peek().column;
    const Expr exponent = value(unary(), exponent_column);
    try {
      return pow(value(base, column), exponent);
    } catch (const ExpressionError& error) {
      fail(column, error.what());
    }
  }

  Expr atom() {
    const Token token = next();
    if (token.kind == Kind::Number) return decimal(token);
    if (token.kind == Kind::Name) return sign("(") && (!peek().spaced || is_function(meant(token.text))) ? function(token) : name(token);
    if (token.kind == Kind::Sign && token.text == "sqrt") {
      const Deeper deeper(*this, token.column);
      const std::size_t column = peek().column;
      return sqrt(value(atom(), column));
    }
    if (token.kind == Kind::Sign && token.text == "(") {
      const Deeper deeper(*this, token.column);
      Expr e = condition();
      expect(")");
      return e;
    }
    --at_;
    unexpected();
  }

  Expr decimal(const Token& token) {
    const std::string& s = token.text;
    const std::size_t e = s.find_first_of("eE");
    const std::string mantissa = s.substr(0, e);
    long exponent = 0;
    if (e != std::string::npos) {
      const std::string digits = s.substr(e + 1);
      if (digits.size() > 6) throw LimitError(fmt::format("the number '{:.40}' at column {} has an exponent of {} digits; the limit of numbers is {} bits", s, token.column, digits.size(), limits::kNumberBits));
      exponent = std::stol(digits);
    }
    const std::size_t dot = mantissa.find('.');
    std::string digits = mantissa;
    if (dot != std::string::npos) {
      digits.erase(dot, 1);
      exponent -= static_cast<long>(mantissa.size() - dot - 1);
    }
    const std::size_t figures = std::max(digits.size(), static_cast<std::size_t>(std::abs(exponent)));
    if (static_cast<double>(figures) * 3.33 > limits::kNumberBits)
      throw LimitError(fmt::format("the number '{:.40}' at column {} has {} figures; the limit of numbers is {} bits", s, token.column, figures, limits::kNumberBits));
    mpz_class scale;
    mpz_ui_pow_ui(scale.get_mpz_t(), 10, static_cast<unsigned long>(std::abs(exponent)));
    const mpz_class whole(digits.empty() ? "0" : digits, 10);
    return number(exponent < 0 ? mpq_class(whole, scale) : mpq_class(whole * scale));
  }

  Expr name(const Token& token) {
    if (token.text == "True" || token.text == "False") return call(token.text == "True" ? Op::True : Op::False, {});
    if (token.text.size() > limits::kIdentifierLength)
      fail(token.column, fmt::format("the name '{}...' is too long", token.text.substr(0, 20)), fmt::format("names have at most {} characters", limits::kIdentifierLength));
    if (is_function(token.text)) fail(token.column, fmt::format("the function '{}' has no argument", token.text), fmt::format("write {}(x)", token.text));
    return symbol(token.text);
  }

  static bool is_function(const std::string& s) {
    if (s == "sqrt" || s == "Piecewise" || s == "Rational") return true;
    const auto all = functions();
    return std::any_of(all.begin(), all.end(), [&](const FunctionName& f) { return s == f.name; });
  }

  static std::string meant(const std::string& name) {
    for (const auto& [alias, real] : kAliases)
      if (name == alias) return real;
    return name;
  }

  Expr function(const Token& token) {
    const Deeper deeper(*this, token.column);
    const std::string known = meant(token.text);
    if (!is_function(known)) unknown_function(token);
    expect("(");
    std::vector<Expr> args;
    std::vector<std::size_t> columns;
    if (!sign(")")) {
      do {
        columns.push_back(peek().column);
        if (known == "Piecewise") {
          pair(args);
        } else {
          args.push_back(condition());
        }
      } while (sign(",") && (++at_, true));
    }
    expect(")");
    try {
      return build(known, args);
    } catch (const ExpressionError& error) {
      fail(token.column, error.what());
    }
  }

  // (value, condition)
  void pair(std::vector<Expr>& args) {
    if (!sign("(")) fail(peek().column, "Piecewise takes pairs (value, condition)");
    const Deeper deeper(*this, next().column);
    args.push_back(condition());
    expect(",");
    args.push_back(condition());
    expect(")");
  }

  static Expr build(const std::string& known, const std::vector<Expr>& args) {
    const auto exactly = [&](std::size_t n) {
      if (args.size() != n) throw ExpressionError(fmt::format("{} takes {} argument{}, not {}", known, n, n == 1 ? "" : "s", args.size()));
      for (const Expr& a : args)
        if (a.is_condition()) throw ExpressionError(fmt::format("{} takes numbers, not conditions", known));
    };
    if (known == "sqrt") return exactly(1), sqrt(args[0]);
    if (known == "Rational") {
      exactly(2);
      if (args[0].op() != Op::Number || args[1].op() != Op::Number || args[1] == Expr(0L))
        throw ExpressionError("Rational takes two integers, the second not zero");
      return div(args[0], args[1]);
    }
    if (known == "Piecewise") return call(Op::Piecewise, args);
    for (const FunctionName& f : functions())
      if (known == f.name) return call(f.op, args);
    throw ExpressionError(fmt::format("unknown function '{}'", known));
  }

  [[noreturn]] void unknown_function(const Token& token) const {
    const std::string& s = token.text;
    if (s == "E" || s == "pi" || s.size() == 1)
      fail(token.column, fmt::format("'{}(' is a call, and '{}' is not a function", s, s), fmt::format("to multiply, write {}*(...)", s));
    std::string best;
    std::size_t least = std::max<std::size_t>(2, s.size() / 3) + 1;
    const auto consider = [&](const std::string& candidate) {
      if (const std::size_t d = edits(s, candidate); d < least) least = d, best = candidate;
    };
    for (const FunctionName& f : functions()) consider(f.name);
    for (const char* f : {"sqrt", "Piecewise", "Rational"}) consider(f);
    if (!best.empty()) fail(token.column, fmt::format("unknown function '{}'", s), fmt::format("did you mean '{}'?", best));
    fail(token.column, fmt::format("unknown function '{}'", s), fmt::format("to multiply, write {}*(...); functions are sin, cos, exp, sqrt, Min and others", s));
  }
};

}  // namespace

Expr parse(const std::string& text) {
  if (text.size() > limits::kFormulaLength)
    throw LimitError(fmt::format("the formula has {} characters; the limit is {}", text.size(), limits::kFormulaLength));
  return Parser(text).formula();
}

}  // namespace irt
