#include <gtest/gtest.h>

#include "tests/tools/tine_pass.hpp"

/// The energy of a coupled pass: bed, machine and what is between them close within 1 % of the work put in, although no
/// term is a remainder; and the same criterion sees when a term is missing.
namespace subsoil::coupling::test::tine_energy {
namespace {

bool closes(const TineEnergy& e) { return std::abs(e.closure()) < 0.01 * e.put_in; }

/// A pass of 60 mm with the tine on a spring behind the trolley, so that machine and soil exchange energy both ways.
const TineEnergy& energy_of_a_pass() {
  static const TineEnergy energy = [] {
    TinePass pass({.seed = 3, .sprung = true, .settle = 0.1});
    pass.run(0.03, 0.06);
    return pass.energy();
  }();
  return energy;
}

TEST(TineEnergy, ClosesWithinOnePercentOfTheWorkPutIn) {
  const TineEnergy& e = energy_of_a_pass();
  EXPECT_GT(e.put_in, 2) << "J: the tine must have worked";
  EXPECT_TRUE(closes(e)) << e.closure() << " of " << e.put_in;
  // Not by luck of signs: each balance closes on its own.
  EXPECT_LT(std::abs(e.bed), 0.005 * e.put_in);
  EXPECT_LT(std::abs(e.machine), 1e-6 * e.put_in);
  EXPECT_LT(std::abs(e.interface), 0.005 * e.put_in);
}

TEST(TineEnergy, ADroppedDissipationTermIsSeen) {
  const TineEnergy& e = energy_of_a_pass();
  for (double dem::Losses::*term : {&dem::Losses::damping, &dem::Losses::sliding, &dem::Losses::rolling}) {
    TineEnergy without = e;
    without.bed -= e.lost.*term;
    EXPECT_FALSE(closes(without)) << e.lost.*term << " J left out of " << e.put_in;
  }
}

}  // namespace
}  // namespace subsoil::coupling::test::tine_energy
