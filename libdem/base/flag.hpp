#pragma once
#include <atomic>
#include <chrono>
#include <thread>

namespace subsoil::dem {

/// Tells other threads how far one has come, where a barrier would have all wait for all. What the raising thread wrote
/// before is seen by those that waited.
class Flag {
 public:
  void raise(long sweep) { std::atomic_ref(sweep_).store(sweep, std::memory_order_release); }
  /// Returns once it was raised for this sweep. Threads may be more than cores: after a while others are let pass, then
  /// it sleeps.
  void await(long sweep) {
    // Some 20 us, a part of the shortest step that is worth two threads; then some 100 us.
    constexpr int patience = 1000, courtesy = patience + 200;
    for (int tries = 0; std::atomic_ref(sweep_).load(std::memory_order_acquire) != sweep; ++tries) {
      if (tries > courtesy)
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      else if (tries > patience)
        std::this_thread::yield();
#if defined(__x86_64__)
      __builtin_ia32_pause();
#endif
    }
  }

 private:
  alignas(64) long sweep_ = -1;
};

}  // namespace subsoil::dem
