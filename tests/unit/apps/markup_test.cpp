#include "libsim/base/markup.hpp"

#include <gtest/gtest.h>

#include "tests/tools/xml.hpp"

namespace subsoil::sim {
namespace {

TEST(Markup, IsTextAgainForAReaderOfXml) {
  const std::string text = "a<b> & \"c\" 'd' \xc3\xa4";
  EXPECT_EQ(escaped_markup(text), "a&lt;b&gt; &amp; &quot;c&quot; 'd' \xc3\xa4");
  const test::Xml read("<?xml version=\"1.0\"?>\n<a x=\"" + escaped_markup(text) + "\"/>\n");
  EXPECT_EQ(read.all("a").front()->attributes.at("x"), text);
}

/// Attributes lose line breaks that are no references (XML 1.0, section 3.3.3); other control characters are no
/// characters of XML at all (section 2.2).
TEST(Markup, ControlCharacters) {
  EXPECT_EQ(escaped_markup("a\tb\nc\rd"), "a&#9;b&#10;c&#13;d");
  EXPECT_EQ(escaped_markup(std::string("a\0b\x01"
                                       "c\x1f",
                                       6)),
            "a b c ");
}

}  // namespace
}  // namespace subsoil::sim
