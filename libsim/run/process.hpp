#pragma once

namespace subsoil::sim {

/// Most memory that this process has held at once, bytes. Not getrusage: its maximum outlives exec, so a program
/// started by a large parent would report the parent's.
double peak_memory();

/// Time that processors have spent on this process since its start, s: its loading included.
double processor_time();

}  // namespace subsoil::sim
