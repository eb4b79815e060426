// A recursive descent over the text.
#include "json.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace fl::detail {
namespace {

[[noreturn]] void fail(const char* what) { throw std::runtime_error(std::string("its header is not JSON: ") + what); }

/// Reads one text from the front.
class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  Json whole() {
    Json value = next(0);
    skip_spaces();
    if (!text_.empty()) fail("something follows its value");
    return value;
  }

 private:
  static constexpr int kMaxDepth = 64;

  void skip_spaces() {
    while (!text_.empty() && std::string_view(" \t\r\n").find(text_[0]) != std::string_view::npos)
      text_.remove_prefix(1);
  }

  /// Take a character if it comes next.
  bool take(char wanted) {
    skip_spaces();
    if (text_.empty() || text_[0] != wanted) return false;
    text_.remove_prefix(1);
    return true;
  }
  void expect(char wanted) {
    if (!take(wanted)) fail("a bracket, comma, colon or quote is missing");
  }
  bool take_word(std::string_view word) {
    if (!text_.starts_with(word)) return false;
    text_.remove_prefix(word.size());
    return true;
  }

  Json next(int depth) {
    if (depth > kMaxDepth) fail("it is nested too deep");
    skip_spaces();
    if (text_.empty()) fail("it ends early");
    Json value;
    if (text_[0] == '{') {
      value.kind = Json::Kind::object;
      take('{');
      if (take('}')) return value;
      do {
        skip_spaces();
        std::string name = string();
        expect(':');
        value.members.push_back({std::move(name), next(depth + 1)});
      } while (take(','));
      expect('}');
    } else if (text_[0] == '[') {
      value.kind = Json::Kind::array;
      take('[');
      if (take(']')) return value;
      do value.items.push_back(next(depth + 1));
      while (take(','));
      expect(']');
    } else if (text_[0] == '"') {
      value.kind = Json::Kind::string;
      value.string = string();
    } else if (take_word("true") || take_word("false")) {
      value.kind = Json::Kind::boolean;
      value.number = text_.data()[-1] == 'e' && text_.data()[-2] == 'u';
    } else if (!take_word("null")) {
      number(value);
    }
    return value;
  }

  void number(Json& value) {
    value.kind = Json::Kind::number;
    const bool is_negative = text_.starts_with('-');
    if (const auto rest = text_.substr(is_negative); rest.starts_with("NaN") || rest.starts_with("Infinity")) {
      value.string = text_.substr(0, is_negative + (rest[0] == 'N' ? 3 : 8));
      value.number = std::copysign(rest[0] == 'N' ? NAN : INFINITY, is_negative ? -1.0 : 1.0);
    } else {
      value.string = text_.substr(0, text_.find_first_not_of("+-.0123456789Ee"));
      value.number = number_of(value.string);
    }
    text_.remove_prefix(value.string.size());
  }

  static double number_of(const std::string& text) {
    constexpr std::size_t most_digits = 15;  // of whole numbers that are surely doubles
    const char *const begin = text.data(), *const end = begin + text.size();
    std::uint64_t whole = 0;
    if (text.size() <= most_digits && text.size() > 0 && std::from_chars(begin, end, whole).ptr == end)
      return double(whole);
    // The library of Apple's compiler has no std::from_chars for floats.
    std::istringstream stream(text);
    stream.imbue(std::locale::classic());
    stream.exceptions(std::ios::badbit);  // a number that finds no memory is not one that is missing
    double number = 0;
    if (text.starts_with('+') || !(stream >> number) || stream.peek() != EOF) fail("a value is missing");
    return number;
  }

  std::string string() {
    expect('"');
    std::string to;
    for (;;) {
      if (text_.empty()) fail("a string has no end");
      const char c = text_[0];
      text_.remove_prefix(1);
      if (c == '"') return to;
      if (c != '\\') {
        to += c;
        continue;
      }
      if (text_.empty()) fail("a string has no end");
      const char escaped = text_[0];
      text_.remove_prefix(1);
      if (escaped == 'u') {
        append_utf8(code_point(), to);
        continue;
      }
      constexpr std::string_view from = "\"\\/bfnrt", meaning = "\"\\/\b\f\n\r\t";
      const std::size_t at = from.find(escaped);
      if (at == std::string_view::npos) fail("a string has an unknown escape");
      to += meaning[at];
    }
  }

  unsigned four_digits() {
    unsigned unit = 0;
    const char* const begin = text_.data();
    if (text_.size() < 4 || std::from_chars(begin, begin + 4, unit, 16).ptr != begin + 4)
      fail("an escape has not four digits");
    text_.remove_prefix(4);
    return unit;
  }

  /// The rest of an escape \u, of one or two units.
  unsigned code_point() {
    const unsigned unit = four_digits();
    if (unit < 0xd800 || unit > 0xdbff || !take_word("\\u")) return unit;
    return 0x10000 + ((unit - 0xd800) << 10) + (four_digits() - 0xdc00);
  }

  static void append_utf8(unsigned code, std::string& to) {
    if (code < 0x80) {
      to += char(code);
    } else if (code < 0x800) {
      to += char(0xc0 | code >> 6);
      to += char(0x80 | (code & 0x3f));
    } else {
      if (code < 0x10000) {
        to += char(0xe0 | code >> 12);
      } else {
        to += char(0xf0 | code >> 18);
        to += char(0x80 | (code >> 12 & 0x3f));
      }
      to += char(0x80 | (code >> 6 & 0x3f));
      to += char(0x80 | (code & 0x3f));
    }
  }

  std::string_view text_;
};

}  // namespace

Json Json::parse(std::string_view text) { return Parser(text).whole(); }

const Json* Json::find(std::string_view name) const {
  for (const auto& [key, value] : members)
    if (key == name) return &value;
  return nullptr;
}

const Json& Json::at(std::string_view name) const {
  if (const Json* found = find(name)) return *found;
  throw std::runtime_error("its header has no \"" + std::string(name) + "\"");
}

const std::string& Json::as_string() const {
  if (kind != Kind::string) throw std::runtime_error("its header has no string where one is expected");
  return string;
}

double Json::as_number() const {
  if (kind != Kind::number || !std::isfinite(number))
    throw std::runtime_error("its header has no finite number where one is expected");
  return number;
}

std::size_t Json::as_size() const {
  if (!(as_number() >= 0 && number <= 0x1p53 && number == std::floor(number)))
    throw std::runtime_error("its header has a number that is not a size");
  return std::size_t(number);
}

const std::vector<Json>& Json::as_array() const {
  if (kind != Kind::array) throw std::runtime_error("its header has no list where one is expected");
  return items;
}

std::string json_string(std::string_view text) {
  std::string to = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') to += '\\';
    if (static_cast<unsigned char>(c) >= 0x20) {
      to += c;
      continue;
    }
    constexpr const char* digits = "0123456789abcdef";
    to += "\\u00";
    to += digits[c >> 4];
    to += digits[c & 15];
  }
  return to + "\"";
}

std::string json_number(double number) {
  std::ostringstream stream;  // std::to_chars of a double needs macOS 13.3
  stream.imbue(std::locale::classic());
  stream.precision(std::numeric_limits<double>::max_digits10);
  stream << number;
  return stream.str();
}

}  // namespace fl::detail
