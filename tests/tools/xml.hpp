#pragma once
#include <algorithm>
#include <list>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace subsoil::sim::test {

/// Just enough of XML to judge our own XDMF by: elements, attributes, text and the five entities; anything else, and
/// anything not well formed, throws std::runtime_error.
class Xml {
 public:
  struct Element {
    std::string tag, text;
    std::map<std::string, std::string> attributes;
    std::list<Element> children;
    const Element* child(const std::string& name) const {
      const auto found = std::find_if(children.begin(), children.end(), [&](const auto& c) { return c.tag == name; });
      return found == children.end() ? nullptr : &*found;
    }
  };

  explicit Xml(std::string text) : text_(std::move(text)) {
    if (text_.compare(0, 5, "<?xml") == 0) at_ = text_.find("?>") + 2;
    skip_blanks();
    root_ = element();
    skip_blanks();
    if (at_ != text_.size()) fail("something follows the root");
  }
  /// All elements of a tag in document order.
  std::vector<const Element*> all(const std::string& tag) const {
    std::vector<const Element*> found;
    collect(root_, tag, found);
    return found;
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw std::runtime_error("XML at character " + std::to_string(at_) + ": " + why);
  }
  static void collect(const Element& e, const std::string& tag, std::vector<const Element*>& found) {
    if (e.tag == tag) found.push_back(&e);
    for (const auto& c : e.children) collect(c, tag, found);
  }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void expect(const std::string& what) {
    if (text_.compare(at_, what.size(), what) != 0) fail("expected " + what);
    at_ += what.size();
  }
  void skip_blanks() {
    while (std::isspace(static_cast<unsigned char>(peek()))) ++at_;
  }
  std::string name() {
    std::string word;
    while (std::isalnum(static_cast<unsigned char>(peek()))) word += text_[at_++];
    if (word.empty()) fail("expected a name");
    return word;
  }
  std::string until(char end) {
    static const std::map<std::string, char> entities{
        {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
    std::string word;
    while (peek() != end) {
      if (peek() == '\0' || peek() == '<') fail("text not ended");
      if (peek() == '&') {
        const auto entity = entities.find(text_.substr(at_, text_.find(';', at_) + 1 - at_));
        if (entity == entities.end()) fail("unknown entity");
        word += entity->second;
        at_ += entity->first.size();
      } else {
        word += text_[at_++];
      }
    }
    return word;
  }
  Element element() {
    Element e;
    expect("<");
    e.tag = name();
    for (skip_blanks(); peek() != '>' && peek() != '/'; skip_blanks()) {
      const std::string key = name();
      expect("=\"");
      if (!e.attributes.emplace(key, until('"')).second) fail("attribute twice");
      expect("\"");
    }
    if (peek() == '/') {
      expect("/>");
      return e;
    }
    expect(">");
    for (;;) {
      e.text += until('<');
      if (text_.compare(at_, 2, "</") == 0) break;
      e.children.push_back(element());
    }
    expect("</" + e.tag + ">");
    return e;
  }

  std::string text_;
  std::size_t at_ = 0;
  Element root_;
};

}  // namespace subsoil::sim::test
