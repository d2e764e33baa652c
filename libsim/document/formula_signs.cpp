#include "libsim/document/formula_signs.hpp"

#include <algorithm>
#include <string_view>

namespace subsoil::sim {
namespace {

bool is_sign(const std::string& word) { return word == "+" || word == "-"; }
bool is_operator(const std::string& word) {
  return word.size() == 1 && std::string_view("+-*/^").find(word[0]) != std::string_view::npos;
}

class SignBrackets {
 public:
  explicit SignBrackets(const std::vector<std::string>& words) : words_(words) {}

  /// Words `begin` ... `end`; a sign in front of them is that of a whole term and needs no brackets.
  std::string text(std::size_t begin, std::size_t end) const {
    std::string out;
    for (std::size_t i = begin; i < end;) {
      out += i > begin ? " " : "";  // "2 3" stays two words
      if (i == begin || !is_sign(words_[i]) || !is_operator(words_[i - 1])) {
        out += words_[i++];
        continue;
      }
      const std::size_t behind = std::min(end, operand_end(i, words_[i - 1] == "^"));
      out += "(" + text(i, behind) + ")";
      i = behind;
    }
    return out;
  }

 private:
  /// Behind signs and the number, name, call or bracket that follows; behind its powers too, which bind closer than a
  /// sign, unless it is an exponent itself.
  std::size_t operand_end(std::size_t i, bool exponent) const {
    while (i < words_.size() && is_sign(words_[i])) ++i;
    if (i < words_.size() && words_[i] != "(") ++i;
    if (i < words_.size() && words_[i] == "(") i = bracket_end(i);
    while (!exponent && i < words_.size() && words_[i] == "^") i = operand_end(i + 1, true);
    return i;
  }
  std::size_t bracket_end(std::size_t i) const {
    int depth = 0;
    for (; i < words_.size(); ++i) {
      depth += words_[i] == "(" ? 1 : words_[i] == ")" ? -1 : 0;
      if (depth == 0) return i + 1;
    }
    return i;
  }

  const std::vector<std::string>& words_;
};

}  // namespace

std::string with_signs_in_brackets(const std::vector<std::string>& words) {
  return SignBrackets(words).text(0, words.size());
}

}  // namespace subsoil::sim
