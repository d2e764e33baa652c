#include "libsim/base/student.hpp"

#include <boost/math/distributions/students_t.hpp>

namespace subsoil::sim {

double student_t(double freedoms, double confidence) {
  return boost::math::quantile(boost::math::complement(boost::math::students_t(freedoms), 0.5 * (1 - confidence)));
}

}  // namespace subsoil::sim
