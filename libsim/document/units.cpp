#include "libsim/document/units.hpp"

#include <fmt/format.h>
#include <udunits2.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <utility>

#include "libsim/document/characters.hpp"
#include "libsim/document/formula.hpp"
#include "libsim/document/unit_database.hpp"

namespace subsoil::sim {
namespace {

// ---- names: UDUNITS-2 ----------------------------------------------------------------------------------------------

struct FreeUnit {
  void operator()(ut_unit* unit) const { ut_free(unit); }
};
using UnitHandle = std::unique_ptr<ut_unit, FreeUnit>;

/// A value below one is nearly always a decimal fraction: dividing by 1000 is exact where multiplying by 0.001 is not.
void set_size(Unit& unit, double scale) {
  const double inverse = std::round(1 / scale);
  if (scale < 1 && std::abs(scale * inverse - 1) < 1e-15) {
    unit.over = inverse;
  } else {
    unit.times = scale;
  }
}

struct Taken {
  Unit unit;
  const char* fault = nullptr;
};

ut_status take_basic(const ut_unit* unit, void* out) {
  static_cast<Taken*>(out)->unit.powers[ut_get_symbol(unit, UT_ASCII)] += 1;
  return UT_SUCCESS;
}
ut_status take_product(const ut_unit*, int count, const ut_unit* const* basic, const int* powers, void* out) {
  for (int i = 0; i < count; ++i) {
    if (powers[i] != 0) static_cast<Taken*>(out)->unit.powers[ut_get_symbol(basic[i], UT_ASCII)] += powers[i];
  }
  return UT_SUCCESS;
}
ut_status take_galilean(const ut_unit*, double scale, const ut_unit* under, double offset, void* out);
ut_status take_timestamp(const ut_unit*, const ut_unit*, double, void* out) {
  static_cast<Taken*>(out)->fault = "is a date, not a unit";
  return UT_SUCCESS;
}
ut_status take_logarithmic(const ut_unit*, double, const ut_unit*, void* out) {
  static_cast<Taken*>(out)->fault = "is logarithmic; give the value itself";
  return UT_SUCCESS;
}
ut_status take(const ut_unit* unit, void* out) {
  static const ut_visitor visitor{take_basic, take_product, take_galilean, take_timestamp, take_logarithmic};
  return ut_accept_visitor(unit, &visitor, out);
}
ut_status take_galilean(const ut_unit*, double scale, const ut_unit* under, double offset, void* out) {
  auto& taken = *static_cast<Taken*>(out);
  if (offset != 0) taken.fault = "has an offset; give a difference in K";
  take(under, out);
  Unit size;
  set_size(size, scale);
  taken.unit.times *= size.times;
  taken.unit.over *= size.over;
  return UT_SUCCESS;
}

/// Of the database; empty: UDUNITS finds it.
std::string& database_file() {
  static std::string file;
  return file;
}

class Database {
 public:
  Database() {
    ut_set_error_message_handler(ut_ignore);
    system_ = ut_read_xml(database_file().empty() ? nullptr : database_file().c_str());
    if (system_ == nullptr) {
      throw std::runtime_error("UDUNITS-2 finds no unit database; install udunits-2-data (Debian: libudunits2-data)");
    }
    add("deg", "arc_degree");
    add("rev", "cycle");
    add("rpm", "cycle/minute");
  }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database() { ut_free_system(system_); }

  Unit find(const std::string& name) const {
    const UnitHandle handle{ut_parse(system_, name.c_str(), UT_UTF8)};
    if (!handle) {
      for (std::size_t i = 0; i < name.size(); ++i)
        if (const char plain = typeset_operator_at(std::string_view(name).substr(i)))
          throw UnitError(
              fmt::format("unknown unit `{}`", name),
              fmt::format("for the sign {} write {}", character_at(std::string_view(name).substr(i)), plain));
      throw UnitError(fmt::format("unknown unit `{}`", name));
    }
    Taken taken;
    take(handle.get(), &taken);
    if (taken.fault != nullptr) throw UnitError(fmt::format("the unit `{}` {}", name, taken.fault));
    return taken.unit;
  }

 private:
  void add(const char* name, const char* meaning) {
    const UnitHandle there{ut_parse(system_, name, UT_UTF8)};
    if (there) return;
    const UnitHandle unit{ut_parse(system_, meaning, UT_ASCII)};
    if (unit) ut_map_name_to_unit(name, UT_UTF8, unit.get());
  }
  ut_system* system_ = nullptr;
};

/// Read when it is first asked: 8 ms, a third of the start of a machine alone.
const Database& database() {
  static const Database instance;
  return instance;
}

/// What the database says of the names that scenarios use most, so that few programs read it; a test compares all.
struct CommonUnit {
  const char* name;
  double times, over;
  int m, kg, s, rad = 0, K = 0;
};
constexpr CommonUnit kCommonUnits[] = {
    {"m", 1, 1, 1, 0, 0},
    {"mm", 1, 1e3, 1, 0, 0},
    {"cm", 1, 100, 1, 0, 0},
    {"um", 1, 1e6, 1, 0, 0},
    {"µm", 1, 1e6, 1, 0, 0},
    {"km", 1e3, 1, 1, 0, 0},
    {"ha", 1e4, 1, 2, 0, 0},
    {"l", 1, 1e3, 3, 0, 0},
    {"kg", 1, 1, 0, 1, 0},
    {"g", 1, 1e3, 0, 1, 0},
    {"mg", 1, 1e6, 0, 1, 0},
    {"t", 1e3, 1, 0, 1, 0},
    {"s", 1, 1, 0, 0, 1},
    {"ms", 1, 1e3, 0, 0, 1},
    {"us", 1, 1e6, 0, 0, 1},
    {"µs", 1, 1e6, 0, 0, 1},
    {"min", 60, 1, 0, 0, 1},
    {"h", 3600, 1, 0, 0, 1},
    {"N", 1, 1, 1, 1, -2},
    {"mN", 1, 1e3, 1, 1, -2},
    {"kN", 1e3, 1, 1, 1, -2},
    {"MN", 1e6, 1, 1, 1, -2},
    {"Pa", 1, 1, -1, 1, -2},
    {"kPa", 1e3, 1, -1, 1, -2},
    {"MPa", 1e6, 1, -1, 1, -2},
    {"GPa", 1e9, 1, -1, 1, -2},
    {"J", 1, 1, 2, 1, -2},
    {"mJ", 1, 1e3, 2, 1, -2},
    {"kJ", 1e3, 1, 2, 1, -2},
    {"W", 1, 1, 2, 1, -3},
    {"kW", 1e3, 1, 2, 1, -3},
    {"Hz", 1, 1, 0, 0, -1},
    {"rad", 1, 1, 0, 0, 0, 1},
    {"deg", 0.017453292519943295, 1, 0, 0, 0, 1},
    {"°", 0.017453292519943295, 1, 0, 0, 0, 1},
    {"rev", 6.2831853071795862, 1, 0, 0, 0, 1},
    {"rpm", 0.10471975511965977, 1, 0, 0, -1, 1},
    {"%", 1, 100, 0, 0, 0},
    {"percent", 1, 100, 0, 0, 0},
    {"K", 1, 1, 0, 0, 0, 0, 1},
};

class Names {
 public:
  Names() {
    for (const CommonUnit& c : kCommonUnits) {
      Unit& unit = known_[c.name];
      unit.times = c.times, unit.over = c.over;
      for (const auto& [base, power] : {std::pair{"m", c.m}, {"kg", c.kg}, {"s", c.s}, {"rad", c.rad}, {"K", c.K}})
        if (power != 0) unit.powers[base] = power;
    }
  }
  const Unit& find(const std::string& name) {
    const auto known = known_.find(name);
    return known != known_.end() ? known->second : known_[name] = database().find(name);
  }

 private:
  std::map<std::string, Unit> known_;
};

Names& names() {
  static Names instance;
  return instance;
}

}  // namespace

std::vector<std::filesystem::path> unit_database() {
  ut_set_error_message_handler(ut_ignore);
  ut_status status = UT_SUCCESS;
  const std::filesystem::path main =
      ut_get_path_xml(database_file().empty() ? nullptr : database_file().c_str(), &status);
  std::vector<std::filesystem::path> out{main};
  for (const auto& file : std::filesystem::directory_iterator(main.parent_path()))
    if (file.path().extension() == ".xml" && file.path() != main) out.push_back(file.path());
  return out;
}

void use_unit_database(const std::string& file) { database_file() = file; }

std::vector<std::string> units_without_database() {
  std::vector<std::string> out;
  for (const CommonUnit& c : kCommonUnits) out.push_back(c.name);
  return out;
}

Unit unit_by_database(const std::string& name) { return database().find(name); }

namespace {

// ---- unit expressions ----------------------------------------------------------------------------------------------

Unit power(const Unit& unit, double exponent) {
  Unit result;
  result.times = std::pow(exponent < 0 ? unit.over : unit.times, std::abs(exponent));
  result.over = std::pow(exponent < 0 ? unit.times : unit.over, std::abs(exponent));
  for (const auto& [name, p] : unit.powers) {
    if (p * exponent != 0) result.powers[name] = p * exponent;
  }
  return result;
}

void multiply(Unit& unit, const Unit& by) {
  unit.times *= by.times;
  unit.over *= by.over;
  for (const auto& [name, p] : by.powers) {
    double& sum = unit.powers[name];
    sum += p;
    if (std::abs(sum) < 1e-9) unit.powers.erase(name);
  }
}

/// Recursive descent over one unit expression.
class Expression {
 public:
  Expression(std::string_view text, std::optional<double> n) : whole_(text), rest_(text), n_(n) {}

  Unit parse() {
    Unit unit;
    if (!at('/')) unit = factor();
    for (skip(); !rest_.empty() && !at(')'); skip()) {
      const bool divides = accept("/");
      if (!divides && !accept("*") && !accept("·")) accept(".");
      multiply(unit, divides ? power(factor(), -1) : factor());
    }
    if (depth_ == 0 && !rest_.empty()) fail("has a `)` too many");
    return unit;
  }

 private:
  [[noreturn]] void fail(const std::string& fault) const {
    throw UnitError(fmt::format("the unit `{}` {}",
                                whole_.size() > 60 ? std::string(whole_.substr(0, 57)) + "..." : std::string(whole_),
                                fault));
  }
  bool at(char c) const { return !rest_.empty() && rest_.front() == c; }
  void skip() {
    while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
  }
  bool accept(std::string_view token) {
    skip();
    if (rest_.substr(0, token.size()) != token) return false;
    rest_.remove_prefix(token.size());
    return true;
  }

  Unit factor() {
    skip();
    if (rest_.empty()) fail("ends where a name should follow");
    Unit unit;
    if (at('(')) {
      rest_.remove_prefix(1);
      if (++depth_ > 50) fail("nests more than 50 brackets; leave out those that change nothing");
      unit = parse();
      --depth_;
      if (!accept(")")) fail("lacks a `)`");
    } else if (is_digit(rest_.front())) {
      const double number = digits();
      if (number != 1)
        fail("holds a number; numbers come first, then one unit, and arithmetic stands in brackets: (1/4) m");
    } else {
      unit = names().find(name());
    }
    const std::optional<double> p = exponent();
    if (p == 0.0 && !n_)
      fail(whole_.find('\'') == std::string_view::npos
               ? "has the power 0, by which a unit vanishes; leave that unit out"
               : "has the power 0 behind ', the sign of arc minutes; numbers have no thousands separators: 1000 kg");
    return p ? power(unit, *p) : unit;
  }

  std::string name() {
    std::size_t size = 0;
    for (; size < rest_.size(); ++size) {
      const std::string_view from = rest_.substr(size);
      const auto c = static_cast<unsigned char>(from.front());
      const bool letter = std::isalpha(c) || c == '_' || c == '%' || c == '\'' || c >= 0x80;
      if (!letter || from.starts_with("·") || superscript_at(from).plain != 0) break;
    }
    if (size == 0) fail(fmt::format("cannot be read at `{}`", rest_));
    const std::string result{rest_.substr(0, size)};
    rest_.remove_prefix(size);
    return result;
  }

  std::optional<double> exponent() {
    if (superscript_at(rest_).plain != 0) {
      const double value = take_superscripts(rest_);
      if (std::isnan(value)) fail("has a power that is no number");
      return value;
    }
    if (accept_here("^") || accept_here("**")) {
      skip();
      if (at('(')) return bracket();
      return signed_term();
    }
    const bool sign = (at('-') || at('+')) && rest_.size() > 1 && is_digit(rest_[1]);
    if (!sign && (rest_.empty() || !is_digit(rest_.front()))) return {};
    const double value = signed_term();
    if (value != std::round(value)) fail("has a decimal power without `^`; write m^1.5, or m^2 s for a product");
    return value;
  }
  bool accept_here(std::string_view token) {
    if (!rest_.starts_with(token)) return false;
    rest_.remove_prefix(token.size());
    return true;
  }

  /// A power in brackets, a formula of numbers and n: (n+1), (3/2).
  double bracket() {
    std::size_t end = 0;
    for (int depth = 0; end < rest_.size(); ++end) {
      depth += rest_[end] == '(' ? 1 : rest_[end] == ')' ? -1 : 0;
      if (depth == 0) break;
    }
    if (end == rest_.size()) fail("lacks a `)` after a power");
    const std::string_view power = rest_.substr(1, end - 1);
    rest_.remove_prefix(end + 1);
    static const std::string n = "n";
    double value = 0;
    try {
      value = Formula(power, std::span(&n, n_ ? 1 : 0))(n_ ? &*n_ : nullptr);
    } catch (const UnknownName& name) {
      fail(power.find('n') == std::string_view::npos ? fmt::format("has a power in which {}", name.what())
                                                     : "has the power n, but nothing here has a parameter n");
    } catch (const UnitError& fault) {
      fail(fmt::format("has a power that {}", fault.what()));
    }
    if (!std::isfinite(value)) fail("has a power that is too large");
    return value;
  }
  double signed_term() {
    skip();
    const double sign = accept("-") ? -1 : 1;
    if (sign > 0) accept("+");
    skip();
    if (accept_here("n")) {
      if (!n_) fail("has the power n, but nothing here has a parameter n");
      return sign * *n_;
    }
    if (rest_.empty() || !is_digit(rest_.front())) fail("has a power that is no number");
    return sign * digits();
  }
  double digits() {
    std::size_t size = 0;
    while (size < rest_.size() && is_digit(rest_[size])) ++size;
    if (size + 1 < rest_.size() && rest_[size] == '.' && is_digit(rest_[size + 1])) {
      for (++size; size < rest_.size() && is_digit(rest_[size]);) ++size;
    }
    const double value = std::strtod(std::string{rest_.substr(0, size)}.c_str(), nullptr);
    if (!std::isfinite(value)) fail("has a power that is too large");
    rest_.remove_prefix(size);
    return value;
  }

  std::string_view whole_, rest_;
  std::optional<double> n_;
  int depth_ = 0;
};

// ---- dimensions ----------------------------------------------------------------------------------------------------

double power_of(const Unit& unit, const char* name) {
  const auto found = unit.powers.find(name);
  return found == unit.powers.end() ? 0 : found->second;
}

bool same_dimension(const Unit& a, const Unit& b) {
  for (const auto& [name, p] : a.powers) {
    if (name != "rad" && std::abs(p - power_of(b, name.c_str())) > 1e-9) return false;
  }
  for (const auto& [name, p] : b.powers) {
    if (name != "rad" && std::abs(p - power_of(a, name.c_str())) > 1e-9) return false;
  }
  return true;
}

/// A word for the commonest dimensions; the base units say the rest.
std::string dimension_word(const Unit& unit) {
  static const std::map<std::string, const char*> words{{"m", "a length"},
                                                        {"kg", "a mass"},
                                                        {"s", "a time"},
                                                        {"rad", "an angle"},
                                                        {"m s^-1", "a speed"},
                                                        {"rad s^-1", "an angular speed"},
                                                        {"m s^-2", "an acceleration"},
                                                        {"kg m s^-2", "a force"},
                                                        {"kg m^2 s^-2", "a moment or energy"},
                                                        {"kg s^-2", "a stiffness"},
                                                        {"kg s^-1", "a damping"},
                                                        {"kg m^-3", "a density"},
                                                        {"kg m^-1 s^-2", "a pressure"},
                                                        {"kg m^2", "a moment of inertia"},
                                                        {"m^2", "an area"},
                                                        {"m^3", "a volume"},
                                                        {"1", "a plain number"},
                                                        {"s^-1", "a rate"}};
  const std::string dimension = dimension_text(unit);
  const auto word = words.find(dimension);
  return word == words.end() ? dimension : fmt::format("{} ({})", word->second, dimension);
}

}  // namespace

std::string example(const Unit& wanted, std::string_view expected) {
  if (expected == "rad") return "an angle, such as deg or rad";
  return fmt::format("{}, such as {}", dimension_word(wanted), expected);
}

void check_dimension(const Unit& given, std::string_view given_text, const Unit& wanted, std::string_view expected) {
  const double given_angle = power_of(given, "rad");
  const double wanted_angle = power_of(wanted, "rad");
  const bool angle_fits = given_angle == wanted_angle || (wanted_angle < 0 && given_angle == 0);
  if (same_dimension(given, wanted) && angle_fits) return;
  if (wanted.powers.empty()) {
    throw UnitError(fmt::format("`{}` is {}, but this value is a plain number; leave the unit away", given_text,
                                dimension_word(given)));
  }
  throw UnitError(
      fmt::format("`{}` is {}, but needed is {}", given_text, dimension_word(given), example(wanted, expected)));
}

Unit parse_unit(std::string_view text, std::optional<double> n) {
  const std::string_view expression = trimmed(text);
  if (expression.empty()) throw UnitError("the unit is empty");
  return Expression(expression, n).parse();
}

std::string dimension_text(const Unit& unit) {
  static constexpr std::array<const char*, 4> first{"rad", "kg", "m", "s"};
  std::string text;
  const auto add = [&](const std::string& name, double p) {
    text += (text.empty() ? "" : " ") + name + (p == 1 ? "" : fmt::format("^{:g}", p));
  };
  for (const char* name : first) {
    if (power_of(unit, name) != 0) add(name, power_of(unit, name));
  }
  for (const auto& [name, p] : unit.powers) {
    if (name != "rad" && name != "kg" && name != "m" && name != "s") add(name, p);
  }
  return text.empty() ? "1" : text;
}

std::string format_quantity(double si, const std::string& unit, std::optional<double> n) {
  if (unit == "1") return fmt::format("{}", si);
  const Unit parsed = parse_unit(unit, n);
  double value = parsed.from_si(si);
  // Conversion there and back may be off by the last bit: try the neighbours before giving the value in base units.
  for (const double candidate : {value, std::nextafter(value, -HUGE_VAL), std::nextafter(value, HUGE_VAL)}) {
    if (parsed.to_si(candidate) == si) return fmt::format("{} {}", candidate, unit);
  }
  return fmt::format("{} {}", si, dimension_text(parsed));
}

std::string format_quantities(const double* si, std::size_t count, const std::string& unit) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += fmt::format("{}{}", i ? " " : "", si[i]);
  return unit == "1" ? text : text + " " + unit;  // callers declare vectors in base units: exact as they are
}

}  // namespace subsoil::sim
