#include "libsim/scenario/shapes/ply_length.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace subsoil::sim {
namespace {

/// Bytes of a number in a binary file; 0: no type of PLY.
std::size_t bytes_of(const std::string& type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "int32" || type == "uint32" || type == "float" || type == "float32")
    return 4;
  return type == "double" || type == "float64" ? 8 : 0;
}

struct Property {
  std::size_t count = 0;  ///< bytes of the number of items; 0: no list
  std::size_t item = 0;   ///< bytes
  std::string type{}, name{};
};

struct Element {
  std::string name{};
  std::uintmax_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool readable = false, text = false, big_endian = false;
  std::vector<Element> elements;
};

/// Whether a line holds one more word, a name, and no other.
bool names_one(std::istream& words, std::string& name) {
  std::string more;
  return words >> name && !(words >> more);
}

/// The older word for a type.
std::string plain(const std::string& type) {
  static const std::map<std::string, std::string> words{{"int8", "char"},     {"uint8", "uchar"},   {"int16", "short"},
                                                        {"uint16", "ushort"}, {"int32", "int"},     {"uint32", "uint"},
                                                        {"float32", "float"}, {"float64", "double"}};
  const auto found = words.find(type);
  return found == words.end() ? type : found->second;
}

/// The one type of all properties of these names, "" without any; "mixed" where they differ.
std::string type_of(const Element& element, std::initializer_list<std::string_view> names) {
  std::string type;
  for (const Property& p : element.properties) {
    if (std::find(names.begin(), names.end(), p.name) == names.end()) continue;
    if (p.count > 0 || (!type.empty() && type != p.type)) return "mixed";
    type = p.type;
  }
  return type;
}

bool has(const Element& element, std::string_view name) {
  return std::any_of(element.properties.begin(), element.properties.end(),
                     [&](const Property& p) { return p.name == name; });
}

// CGAL looks at the type of some properties and takes others, of like names, for the same; of two that have one name it
// looks at one and takes the other.
std::string fault_of(const Element& element) {
  for (std::size_t k = 0; k < element.properties.size(); ++k)
    for (std::size_t i = 0; i < k; ++i)
      if (element.properties[i].name == element.properties[k].name)
        return "it has two properties called " + element.properties[k].name;
  if (type_of(element, {"red", "green", "blue", "r", "g", "b"}) == "mixed")
    return "its colours are not numbers of one type";
  if (element.name != "vertex" && element.name != "vertices") return {};
  const std::string type = type_of(element, {"x", "y", "z"});
  const bool real = type == "float" || type == "double";
  return real && has(element, "x") && has(element, "y") && has(element, "z")
             ? std::string()
             : "its vertices need x, y and z, all three float or all three double";
}

bool is_whole_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos && text.size() < 20;
}

// CGAL takes the second line for the format whatever its first word is, and words beyond those that it knows for
// others: the header must say what PLY says, no more.
Header read_header(std::istream& in) {
  Header header;
  std::string line;
  for (int number = 1; std::getline(in, line) && line.size() < 1000; ++number) {
    std::istringstream words(line);
    std::string word, type;
    words >> word;
    if ((number == 2) != (word == "format")) return header;
    if (word == "end_header") {
      header.readable = number > 2;
      return header;
    }
    if (word == "format") {
      if (!(words >> type) || !names_one(words, word)) return header;
      header.text = type == "ascii", header.big_endian = type == "binary_big_endian";
    } else if (word == "element") {
      std::string count, more;
      if (!(words >> type >> count) || words >> more || !is_whole_number(count)) return header;
      header.elements.push_back({.name = type, .count = std::strtoull(count.c_str(), nullptr, 10), .properties = {}});
    } else if (word == "property") {
      if (header.elements.empty() || !(words >> type)) return header;
      Property property;
      if (type == "list") {
        std::string item;
        if (!(words >> type >> item)) return header;
        property.count = bytes_of(type), property.item = bytes_of(item);
        if (property.count == 0) return header;
      } else {
        property.item = bytes_of(type);
      }
      property.type = plain(type);
      if (property.item == 0 || !names_one(words, property.name)) return header;
      header.elements.back().properties.push_back(property);
    } else if (!word.empty() && word != "ply" && word != "comment" && word != "obj_info") {
      return header;
    }
  }
  return header;
}

/// Walks over the body; every step is checked against what is left.
class Body {
 public:
  Body(std::string bytes, const Header& header) : bytes_(std::move(bytes)), header_(header) {}

  bool holds(const Element& element) {
    if (element.count > bytes_.size()) return false;  // every element takes a byte
    for (std::uintmax_t k = 0; k < element.count; ++k)
      for (const Property& p : element.properties) {
        std::uintmax_t items = 1;
        if (p.count > 0 && !take_count(p.count, items)) return false;
        if (!skip(items, p.item)) return false;
      }
    return true;
  }

 private:
  bool take_word(std::string& word) {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    while (at_ < bytes_.size() && blank(bytes_[at_])) ++at_;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !blank(bytes_[at_])) ++at_;
    word = bytes_.substr(begin, std::min<std::size_t>(at_ - begin, 30));
    return at_ > begin;
  }
  bool take_count(std::size_t size, std::uintmax_t& count) {
    if (header_.text) {
      std::string word;
      if (!take_word(word)) return false;
      count = std::strtoull(word.c_str(), nullptr, 10);
      return word.front() != '-';
    }
    if (bytes_.size() - at_ < size) return false;
    unsigned char raw[8] = {};
    std::memcpy(raw, bytes_.data() + at_, size);
    count = 0;
    for (std::size_t b = 0; b < size; ++b) count = count << 8 | raw[header_.big_endian ? b : size - 1 - b];
    at_ += size;
    return true;
  }
  bool skip(std::uintmax_t items, std::size_t size) {
    const std::uintmax_t left = bytes_.size() - at_;
    if (items > left / (header_.text ? 1 : size)) return false;
    if (!header_.text) return at_ += static_cast<std::size_t>(items) * size, true;
    std::string word;
    for (std::uintmax_t k = 0; k < items; ++k)
      if (!take_word(word)) return false;
    return true;
  }

  std::string bytes_;
  const Header& header_;
  std::size_t at_ = 0;
};

}  // namespace

void refuse_short_ply(const std::string& file, const std::string& content) {
  std::istringstream in(content);
  const Header header = read_header(in);
  if (!header.readable)
    throw std::runtime_error(
        file +
        ": no PLY file that can be read: its header must list elements, each with its properties after it, "
        "and end with `end_header`; export it again");
  for (const Element& element : header.elements) {
    if (const std::string fault = fault_of(element); !fault.empty())
      throw std::runtime_error(file + ": no PLY file that can be read: " + fault + "; export it again");
    if (element.count > 0 && (element.name == "tristrips" || element.name == "tristrip" || element.name == "strips"))
      throw std::runtime_error(
          fmt::format("{}: holds its triangles as strips (element `{}`), which are not read; export it with faces",
                      file, element.name));
  }
  Body body({std::istreambuf_iterator<char>(in), {}}, header);
  for (const Element& element : header.elements)
    if (!body.holds(element))
      throw std::runtime_error(file +
                               ": is cut off: its header and lists ask for more than the file holds; export it again");
}

}  // namespace subsoil::sim
