#pragma once
#include <cstdio>
#include <stdexcept>
#include <string>

/// Why a machine is refused, or comes to no end. Who handles it reads the fields; the text is for people alone.
namespace subsoil::mbd {

/// A part of a model.
struct PartName {
  enum class Kind { machine, body, joint, driver, force, controller, event };
  Kind kind = Kind::machine;
  std::string name{};  ///< none for the machine as a whole

  /// "joint 'H3'"
  std::string text() const {
    constexpr const char* words[] = {"machine", "body", "joint", "driver", "force", "controller", "event"};
    const std::string word = words[static_cast<int>(kind)];
    return kind == Kind::machine ? word : word + " '" + name + "'";
  }
  bool operator==(const PartName&) const = default;
};

/// A parameter of an element that is out of order, by the name that describe() gives it: KEY must be ...
struct KeyFault : std::invalid_argument {
  KeyFault(const std::string& name, const std::string& broken)
      : std::invalid_argument(name + " " + broken), key(name), rule(broken) {}

  std::string key, rule;
};

/// A model or start that contradicts itself.
struct ModelFault : std::invalid_argument {
  ModelFault(PartName part, const std::string& text, std::string its_key = {})
      : std::invalid_argument(text), of(std::move(part)), key(std::move(its_key)) {}

  PartName of;      ///< the first part that the text names
  std::string key;  ///< its parameter that is out of order; none where it is the part as a whole
};

/// A motion that cannot be followed beyond an instant.
struct MotionFault : std::runtime_error {
  enum class Cause { other, long_step, blow_up };

  MotionFault(double at, const std::string& text, Cause of = Cause::other)
      : std::runtime_error(timed(at, text)), time(at), cause(of) {}
  /// The same with more text behind it.
  MotionFault(const MotionFault& fault, const std::string& more)
      : std::runtime_error(fault.what() + more), time(fault.time), cause(fault.cause) {}

  double time;  ///< s
  Cause cause;

 private:
  static std::string timed(double at, const std::string& text) {
    char start[48];
    std::snprintf(start, sizeof start, "t = %.9g s: ", at);
    return start + text;
  }
};

}  // namespace subsoil::mbd
