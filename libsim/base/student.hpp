#pragma once

namespace subsoil::sim {

/// Half of the two-sided interval of Student's t with so many degrees of freedom (> 0), in standard errors.
double student_t(double freedoms, double confidence = 0.95);

}  // namespace subsoil::sim
