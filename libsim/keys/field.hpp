#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libsim/base/json_fwd.hpp"
#include "libsim/document/document.hpp"
#include "libsim/keys/range.hpp"

/// One key of a declaration, and the value behind it.
namespace subsoil::sim {

class Reader;
class Printer;
class KeyList;
class Schema;
struct Reading;

struct Field {
  std::string key;
  std::string meaning;
  bool needed = false;       ///< the file must give it
  std::string unit{};        ///< named where it is missing; empty: none
  std::string cure{};        ///< what to do about a value out of range: "for no damping use 1"
  std::string if_missing{};  ///< in place of the meaning
  bool exponent = false;     ///< other units of the same mapping may hold it as n: N/m^(n+1)
};

/// What a value that is read may ask of the place where it stands.
struct ReadScope {
  const Field& field;
  const Reading& reading;
  std::optional<double> n;  ///< the exponent of this mapping
};

/// The same for one that is printed.
struct PrintScope {
  std::optional<double> n;
  const std::vector<std::string>& bodies;  ///< [0] is ground
  bool symbols = false;                    ///< units may hold symbols (n, U), which have no size yet
};

/// A member of a struct as one value of the document.
class Value {
 public:
  virtual ~Value() = default;
  /// Throws std::invalid_argument, best a Refusal.
  virtual void read(const Node& node, const ReadScope& scope) = 0;
  /// Null: left out.
  virtual Node print(const PrintScope& scope) const = 0;
  /// What stands there: a unit, "word", "yes/no", "2 numbers m".
  virtual std::string what() const = 0;
  /// Interval, or words to choose from.
  virtual std::string range() const { return {}; }
  /// The file that is read, once its name has been; null: there is none.
  virtual const std::string* input_file() const { return nullptr; }
  /// A JSON Schema of what may stand there (json_forms.hpp).
  virtual Json schema() const = 0;
  /// The key stands in the file, whatever comes of its value.
  virtual void given() {}
  /// Takes a number that a rule of the mapping supplies in place of the file; false: cannot.
  virtual bool supply(double) { return false; }
  /// The number held; for exponents.
  virtual std::optional<double> number() const { return {}; }
};

/// A word of the vocabulary that uses several keys or declares something inside.
class Compound {
 public:
  virtual ~Compound() = default;
  virtual void read(Reader& reader, const Field& field) = 0;
  virtual void print(Printer& printer, const Field& field) const = 0;
  virtual void list(KeyList& keys, const Field& field) const = 0;
  virtual void outline(Schema& schema, const Field& field) const = 0;
};

}  // namespace subsoil::sim
