#pragma once

#include <memory>
#include <utility>

namespace subsoil::mbd {

/// A value of a class derived from Base, copied by Base::copy(), as std::polymorphic of C++26 is. What holds one is
/// copied and moved by its defaults. After a move it holds nothing.
template <class Base>
class Polymorphic {
 public:
  explicit Polymorphic(std::unique_ptr<Base> object) : object_(std::move(object)) {}
  Polymorphic(const Polymorphic& other) : object_(other.object_->copy()) {}
  Polymorphic(Polymorphic&&) noexcept = default;
  Polymorphic& operator=(Polymorphic other) noexcept {
    object_ = std::move(other.object_);
    return *this;
  }
  ~Polymorphic() = default;

  Base* operator->() { return object_.get(); }
  const Base* operator->() const { return object_.get(); }
  const Base& operator*() const { return *object_; }

 private:
  std::unique_ptr<Base> object_;
};

}  // namespace subsoil::mbd
