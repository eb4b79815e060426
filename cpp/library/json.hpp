// A reader of JSON, and strings as JSON: as much of both as the headers of tree files need.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fl::detail {

/// A value of JSON. Throws std::runtime_error where another one is expected.
class Json {
 public:
  enum class Kind { null, boolean, number, string, array, object };
  struct Member;

  /// The value of a text; throws std::runtime_error if it is not one.
  static Json parse(std::string_view text);

  Kind kind = Kind::null;
  double number = 0;   ///< of a number; 1 for true
  std::string string;  ///< of a string; of a number, its text
  std::vector<Json> items;
  std::vector<Member> members;  ///< in the order of the text

  /// The member of an object with this name, or nullptr.
  const Json* find(std::string_view name) const;
  /// The same; throws if there is none.
  const Json& at(std::string_view name) const;
  const std::string& as_string() const;
  /// A finite number.
  double as_number() const;
  /// A whole number from 0 to 2^53.
  std::size_t as_size() const;
  const std::vector<Json>& as_array() const;
};

/// A member of an object.
struct Json::Member {
  std::string name;
  Json value;
};

/// A string in quotes.
std::string json_string(std::string_view text);

/// A number with as many digits as keep its bits.
std::string json_number(double number);

}  // namespace fl::detail
