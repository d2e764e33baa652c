#pragma once
#include <atomic>
#include <thread>

namespace subsoil::dem {

/// Tells other threads how far one has come, where a barrier would have all wait for all. What the raising thread wrote
/// before is seen by those that waited.
class Flag {
 public:
  void raise(long sweep) { std::atomic_ref(sweep_).store(sweep, std::memory_order_release); }
  /// Returns once it was raised for this sweep. Threads may be more than cores: after a while others are let pass.
  void await(long sweep) {
    constexpr int patience = 1000;  // some 20 us, a part of the shortest step that is worth two threads
    for (int tries = 0; std::atomic_ref(sweep_).load(std::memory_order_acquire) != sweep; ++tries) {
      if (tries > patience) std::this_thread::yield();
#if defined(__x86_64__)
      __builtin_ia32_pause();
#endif
    }
  }

 private:
  alignas(64) long sweep_ = -1;
};

}  // namespace subsoil::dem
