#include "libsim/io/csv.hpp"

#include <charconv>
#include <cmath>
#include <cstdlib>

#include "libsim/base/byte_order_mark.hpp"
#include "libsim/io/csv_separator.hpp"

namespace subsoil::sim::csv {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n";
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

}  // namespace

std::vector<std::string> split(std::string_view line) {
  line = without_byte_order_mark(line);
  std::vector<std::string> fields(1);
  bool in_quotes = false, was_quoted = false;
  const auto finish = [&] {
    if (!was_quoted) fields.back() = trimmed(fields.back());
    was_quoted = false;
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (in_quotes && i + 1 < line.size() && line[i + 1] == '"') {
        fields.back() += '"';
        ++i;
      } else {
        in_quotes = !in_quotes;
        if (in_quotes) fields.back().clear();
        was_quoted = true;
      }
    } else if (c == ',' && !in_quotes) {
      finish();
      fields.emplace_back();
    } else if (in_quotes || !was_quoted) {
      fields.back() += c;
    }
  }
  finish();
  return fields;
}

std::string other_separator(std::string_view line) {
  if (line.find(',') != std::string_view::npos) return {};
  const bool semicolon = line.find(';') != std::string_view::npos, tab = line.find('\t') != std::string_view::npos;
  if (!semicolon && !tab) return {};
  return std::string("has its fields separated by ") + (semicolon ? "`;`" : "tabs") +
         ": must be `,`, with decimal points in the numbers; save it as CSV in English notation";
}

std::string quoted(std::string_view field) {
  if (field.find_first_of(",\"\n") == std::string_view::npos) return std::string(field);
  std::string text = "\"";
  for (const char c : field) {
    if (c == '"') text += '"';
    text += c == '\n' ? ' ' : c;
  }
  return text + '"';
}

Label split_label(std::string_view label) {
  label = trimmed(label);
  const auto open = label.rfind('[');
  if (open == std::string_view::npos || !label.ends_with(']')) return {std::string(label), {}};
  return {std::string(trimmed(label.substr(0, open))),
          std::string(trimmed(label.substr(open + 1, label.size() - open - 2)))};
}

bool to_number(std::string_view text, double& value) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || end != text.data() + text.size()) return false;
  if (error == std::errc::result_out_of_range && std::abs(std::strtod(std::string(text).c_str(), nullptr)) < 1)
    return value = 0, true;
  return error == std::errc{};
}

void append_number(std::string& row, double value, int digits) {
  char buffer[40];
  const auto [end, error] =
      digits == exact_digits ? std::to_chars(buffer, buffer + sizeof buffer, value)
                             : std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, digits);
  row.append(buffer, end);
}

}  // namespace subsoil::sim::csv
