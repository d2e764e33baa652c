#include "libsim/document/formula.hpp"

#include <array>
#include <cmath>
#include <stdexcept>

namespace subsoil::sim {
namespace {

/// Values that wait on the stack: at each of the 100 levels of brackets at most the sums and products so far, a base
/// and a first argument, and the value that is worked out.
constexpr std::size_t deepest_stack = 408;

/// A constant, or why it has none.
double finite_constant(double value, Operation::Kind kind, Call call, double left, double right) {
  if (std::isfinite(value)) return value;
  const bool power = kind == Operation::Kind::power || (kind == Operation::Kind::call && call == Call::pow);
  if ((kind == Operation::Kind::divide && right == 0) || (power && left == 0)) throw UnitError("divides by 0");
  if (kind == Operation::Kind::call && call == Call::log && left == 0) throw UnitError("holds the logarithm of 0");
  if (std::isnan(value))
    throw UnitError("holds a number that is not real, such as a root or logarithm of a negative one");
  throw UnitError("holds a number too large for double precision");
}

double constant_of(const Operation& o, double left, double right) {
  switch (o.kind) {
    case Operation::Kind::add:
      return left + right;
    case Operation::Kind::subtract:
      return left - right;
    case Operation::Kind::multiply:
      return left * right;
    case Operation::Kind::divide:
      return left / right;
    case Operation::Kind::power:
      return std::pow(left, right);
    case Operation::Kind::negate:
      return -left;
    default:
      return value_of(o.call, left, right);
  }
}

}  // namespace

class Formula::Compiler {
 public:
  explicit Compiler(std::vector<Step>& steps) : steps_(steps) {}

  void take(const Operation& o) {
    switch (o.kind) {
      case Operation::Kind::number:
        push({.what = Do::number, .number = o.number});
        break;
      case Operation::Kind::name:
        push({.what = Do::variable, .variable = static_cast<std::uint32_t>(o.name)});
        break;
      case Operation::Kind::negate:
        one(o, {.what = Do::negate});
        break;
      case Operation::Kind::call:
        if (takes_one(o.call)) {
          one(o, {.what = Do::call_one, .call = o.call});
        } else {
          two(o);
        }
        break;
      case Operation::Kind::unit:
        throw std::logic_error("a formula of plain numbers holds a unit");
      default:
        two(o);
    }
  }
  std::size_t deepest() const { return deepest_; }

 private:
  static bool takes_one(Call call) {
    for (const FormulaFunction& f : formula_functions)
      if (f.call == call) return f.arguments == 1;
    return false;
  }
  bool is_number(std::size_t begin, std::size_t end) const {
    return end == begin + 1 && steps_[begin].what == Do::number;
  }
  void push(const Step& step) {
    begins_.push_back(steps_.size());
    steps_.push_back(step);
    deepest_ = std::max(deepest_, begins_.size());
  }
  void one(const Operation& o, const Step& step) {
    const std::size_t begin = begins_.back();
    if (!is_number(begin, steps_.size())) return steps_.push_back(step);
    double& x = steps_.back().number;
    x = finite_constant(constant_of(o, x, 0), o.kind, o.call, x, 0);
  }
  void two(const Operation& o) {
    const std::size_t right = begins_.back(), left = begins_[begins_.size() - 2];
    begins_.pop_back();
    const bool number_left = is_number(left, right), number_right = is_number(right, steps_.size());
    if (number_left && number_right) {
      const double a = steps_[left].number, b = steps_[right].number;
      steps_.pop_back();
      steps_.back().number = finite_constant(constant_of(o, a, b), o.kind, o.call, a, b);
    } else if (number_right) {
      const double b = steps_.back().number;
      steps_.pop_back();
      with_number_right(o, b);
    } else if (number_left && with_number_left(o.kind) != Do::number) {
      const double a = steps_[left].number;
      steps_.erase(steps_.begin() + static_cast<std::ptrdiff_t>(left));
      steps_.push_back({.what = with_number_left(o.kind), .number = a});
    } else {
      steps_.push_back(of_two(o));
    }
  }
  static Step of_two(const Operation& o) {
    switch (o.kind) {
      case Operation::Kind::add:
        return {.what = Do::add};
      case Operation::Kind::subtract:
        return {.what = Do::subtract};
      case Operation::Kind::multiply:
        return {.what = Do::multiply};
      case Operation::Kind::divide:
        return {.what = Do::divide};
      case Operation::Kind::power:
        return {.what = Do::power};
      default:
        return {.what = Do::call_two, .call = o.call};
    }
  }
  /// Do::number: it stays a step of its own.
  static Do with_number_left(Operation::Kind kind) {
    switch (kind) {
      case Operation::Kind::add:
        return Do::add_number;
      case Operation::Kind::subtract:
        return Do::number_minus;
      case Operation::Kind::multiply:
        return Do::multiply_number;
      case Operation::Kind::divide:
        return Do::number_over;
      default:
        return Do::number;
    }
  }
  void with_number_right(const Operation& o, double b) {
    if (o.kind == Operation::Kind::power || o.call == Call::pow) return to_the_power(b);
    switch (o.kind) {
      case Operation::Kind::add:
        return steps_.push_back({.what = Do::add_number, .number = b});
      case Operation::Kind::subtract:
        return steps_.push_back({.what = Do::add_number, .number = -b});
      case Operation::Kind::multiply:
        return steps_.push_back({.what = Do::multiply_number, .number = b});
      case Operation::Kind::divide:
        if (b == 0) throw UnitError("divides by 0");
        return steps_.push_back({.what = Do::divide_number, .number = b});
      default:
        steps_.push_back({.what = Do::number, .number = b});
        steps_.push_back(of_two(o));
    }
  }
  /// x^2, x^0.5 and x^-1 are cheaper than pow, and no less exact.
  void to_the_power(double p) {
    if (p == 1) return;
    if (p == 2) return steps_.push_back({.what = Do::square});
    if (p == 0.5) return steps_.push_back({.what = Do::call_one, .call = Call::sqrt});
    if (p == -1) return steps_.push_back({.what = Do::number_over, .number = 1});
    steps_.push_back({.what = Do::power_number, .number = p});
  }

  std::vector<Step>& steps_;
  std::vector<std::size_t> begins_;  ///< of the steps of each value on the stack
  std::size_t deepest_ = 0;
};

Formula::Formula(std::string_view text, std::span<const std::string> variables) {
  Compiler compiler(steps_);
  for (const Operation& o : read_formula(text, {.names = variables})) compiler.take(o);
  if (compiler.deepest() > deepest_stack) throw std::logic_error("a formula needs a stack beyond its levels");
}

template <class Number>
Number Formula::run(const Number* at) const {
  std::array<Number, deepest_stack> stack;  // not set: a formula touches its first values only
  Number* top = stack.data() - 1;           // the last value
  for (const Step& s : steps_) {
    switch (s.what) {
      case Do::number:
        jets::set(*++top, s.number);
        break;
      case Do::variable:
        *++top = at[s.variable];
        break;
      case Do::negate:
        *top = jets::negated(*top);
        break;
      case Do::add:
        --top, *top = jets::sum(top[0], top[1]);
        break;
      case Do::subtract:
        --top, *top = jets::difference(top[0], top[1]);
        break;
      case Do::multiply:
        --top, *top = jets::product(top[0], top[1]);
        break;
      case Do::divide:
        --top, *top = jets::quotient(top[0], top[1]);
        break;
      case Do::power:
        --top, *top = jets::power(top[0], top[1]);
        break;
      case Do::add_number:
        *top = jets::sum(*top, s.number);
        break;
      case Do::number_minus:
        *top = jets::difference(s.number, *top);
        break;
      case Do::multiply_number:
        *top = jets::product(*top, s.number);
        break;
      case Do::divide_number:
        *top = jets::quotient(*top, s.number);
        break;
      case Do::number_over:
        *top = jets::quotient(s.number, *top);
        break;
      case Do::power_number:
        *top = jets::power(*top, s.number);
        break;
      case Do::square:
        *top = jets::product(*top, *top);
        break;
      case Do::call_one:
        *top = jets::call(s.call, *top);
        break;
      case Do::call_two:
        --top, *top = jets::call(s.call, top[0], top[1]);
        break;
    }
  }
  return stack[0];
}

double Formula::operator()(const double* at) const { return run(at); }
Jet<1> Formula::operator()(const Jet<1>* at) const { return run(at); }
Jet<2> Formula::operator()(const Jet<2>* at) const { return run(at); }

}  // namespace subsoil::sim
