#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <sstream>

#include "tests/tools/laws.hpp"
#include "tests/tools/scratch.hpp"

/// Oblique impacts with spin by `conventions: lammps | liggghts`, beside those programs themselves (scripts/setup
/// --bench; left out where they are not installed). All three step as leapfrog does with forces from the velocities of
/// half a step before, so with one step their curves are the same but for rounding and for how contacts turn with the
/// normal: this program takes velocities of half a step in the plane of that instant, the others in that of the step's
/// end. That is of first order: 2.3e-6 with steps of 0.2 us, 1.1e-6 with these. A wall's normal stands still: there
/// LAMMPS differs by rounding alone, LIGGGHTS by the step of friction in which a contact that the dashpot pulls at
/// parts.
namespace subsoil::dem::test::peers_test {
namespace {

using subsoil::sim::test::Scratch;
using subsoil::sim::test::text_of;
using subsoil::sim::test::write_file;

constexpr double kDensity = 2500, kStep = 1e-7;
constexpr int kSteps = 12000, kEvery = 200;

/// Two spheres that meet obliquely, or the first and a plane y = 0.
std::vector<SphereSpec> spheres(bool wall) {
  std::vector<SphereSpec> out{{{0, 0, 0}, {0.5, 0.3, 0.1}, {3, 20, -15}, 0.01, kDensity, 0},
                              {{0.0180005, 0.002, 0.001}, {-0.5, -0.2, 0}, {0, -5, 10}, 0.008, kDensity, 0}};
  if (wall) out = {{{0, 0.01 + 1e-5, 0}, {0.4, -0.8, 0.2}, {3, 20, -15}, 0.01, kDensity, 0}};
  return out;
}

struct Peer {
  const char* command;
  std::string head, spin;  ///< before the contacts; how `set` names the spin
};
const Peer kLammps{"lmp", "atom_style sphere\ncomm_modify vel yes\n", "omega {} {} {}"};
const Peer kLiggghts{"liggghts", "atom_style granular\natom_modify map array\ncommunicate single vel yes\n",
                     "omegax {} omegay {} omegaz {}"};

std::string filled(std::string text, std::initializer_list<double> values) {
  for (const double value : values) {
    char number[40];
    std::snprintf(number, sizeof number, "%.17g", value);
    text.replace(text.find("{}"), 2, number);
  }
  return text;
}

std::string input(const Peer& peer, const std::string& contacts, bool wall) {
  std::string text = "units si\n" + peer.head +
                     "boundary f f f\nnewton off\nregion box block -0.2 0.2 -0.2 0.2 -0.2 0.2\ncreate_box 1 box\n";
  int id = 0;
  for (const SphereSpec& s : spheres(wall)) {
    const Vec3 &x = s.position, &v = s.velocity, &w = s.angular_velocity;
    text += filled("create_atoms 1 single {} {} {}\n", {x.x, x.y, x.z}) + "set atom " + std::to_string(++id) +
            filled(" diameter {} density {} vx {} vy {} vz {} " + peer.spin + "\n",
                   {2 * s.radius, s.density, v.x, v.y, v.z, w.x, w.y, w.z});
  }
  const bool lammps = &peer == &kLammps;
  const std::string number = lammps ? " %.17g" : " %.17g %.17g %.17g %.17g %.17g %.17g";
  return text + "neighbor 0.002 bin\nneigh_modify delay 0 every 1\n" + contacts + "fix move all nve/sphere\n" +
         filled("timestep {}\n", {kStep}) + "dump d all custom " + std::to_string(kEvery) +
         " out id vx vy vz omegax omegay omegaz\ndump_modify d sort id format " +
         (lammps ? "float" + number : "\"%d" + number + "\"") + "\nrun " + std::to_string(kSteps) + "\n";
}

/// Velocities and spins of every `kEvery`th step, sphere by sphere.
std::vector<Vec3> by_peer(const Peer& peer, const std::string& contacts, bool wall) {
  const Scratch scratch;
  write_file(scratch / "in", input(peer, contacts, wall));
  const std::string run = "cd " + scratch.path().string() + " && " + peer.command + " -in in >log 2>&1";
  if (std::system(run.c_str()) != 0) {
    ADD_FAILURE() << text_of(scratch / "log");
    return {};
  }
  std::istringstream dump(text_of(scratch / "out"));
  std::vector<Vec3> out;
  bool atoms = false;
  for (std::string line; std::getline(dump, line);) {
    if (line.rfind("ITEM:", 0) == 0) {
      atoms = line.rfind("ITEM: ATOMS", 0) == 0;
    } else if (atoms) {
      std::istringstream row(line);
      int id = 0;
      Vec3 v, w;
      row >> id >> v.x >> v.y >> v.z >> w.x >> w.y >> w.z;
      out.insert(out.end(), {v, w});
    }
  }
  return out;
}

std::vector<Vec3> by_engine(const Law& law, bool wall, const std::vector<SphereSpec>& specs) {
  Bed bed(table(law), quiet());
  bed.add(specs);
  if (wall) add_plane(bed, {}, {0, 1, 0});
  std::vector<Vec3> out;
  for (int n = 0; n <= kSteps; ++n) {
    const Snapshot s = observe(bed, kStep);
    if (n % kEvery == 0)
      for (std::size_t i = 0; i < s.id.size(); ++i) out.insert(out.end(), {s.velocity[i], s.angular_velocity[i]});
  }
  return out;
}

/// Largest difference of velocities over 1 m/s, and of spins over 100 rad/s.
double apart(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  EXPECT_EQ(a.size(), b.size());
  double most = a.size() == b.size() && !a.empty() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    most = std::max(most, norm(a[i] - b[i]) / (i % 2 == 0 ? 1 : 100));
  return most;
}

bool there(const Peer& peer) {
  return std::system((std::string("command -v ") + peer.command + " >/dev/null 2>&1").c_str()) == 0;
}

void expect_same(const Peer& peer, const std::string& what, const Law& law, const std::string& contacts, bool wall) {
  const std::vector<Vec3> ours = by_engine(law, wall, spheres(wall)), theirs = by_peer(peer, contacts, wall);
  const double difference = apart(ours, theirs);
  std::printf("%s, %s: %.1e\n", peer.command, what.c_str(), difference);
  EXPECT_LT(difference, wall && &peer == &kLammps ? 1e-13 : 2e-6) << what;
  EXPECT_GT(norm(ours.back() - ours[1]), 1) << what << ": nothing happened";
}

Linear springs(double ratio, double mu) {
  Linear law;
  law.k_n = 1e5, law.damping = 3, law.stiffness_ratio = ratio;
  law.friction.mu = mu;
  return law;
}

constexpr double kRadiusOfPair = 0.01 * 0.008 / 0.018;

TEST(Peers, LammpsLinear) {
  if (!there(kLammps)) GTEST_SKIP() << "no LAMMPS: scripts/setup --bench";
  for (const double mu : {0.05, 0.3, 3.0})
    for (const double damping : {0.0, 0.4, 1.0}) {
      Linear law = springs(0.3, mu);
      law.friction.take(Conventions::lammps);
      law.friction.damping_factor = damping;
      const std::string model =
          filled("hooke 1e5 3 damping velocity tangential linear_history 3e4 {} {}", {damping, mu});
      const std::string what = filled("linear, mu {}, x_gammat {}", {mu, damping});
      expect_same(kLammps, what, law, "pair_style granular\npair_coeff * * " + model + "\n", false);
      expect_same(kLammps, what + ", wall", law,
                  "pair_style granular\npair_coeff * * " + model + "\nfix wall all wall/gran granular " + model +
                      " yplane 0 NULL\n",
                  true);
    }
}

TEST(Peers, LammpsRolling) {
  if (!there(kLammps)) GTEST_SKIP() << "no LAMMPS: scripts/setup --bench";
  for (const double mu_r : {0.005, 0.1}) {
    Linear law = springs(0.3, 0.3);
    law.friction.take(Conventions::lammps);
    law.friction.mu_r = mu_r, law.friction.k_r = 2e4 * kRadiusOfPair * kRadiusOfPair;
    law.friction.c_r = 0.5 * kRadiusOfPair * kRadiusOfPair;
    expect_same(kLammps, filled("rolling, mu_r {}", {mu_r}), law,
                filled("pair_style granular\npair_coeff * * hooke 1e5 3 damping velocity tangential linear_history 3e4 "
                       "1 0.3 rolling sds 2e4 0.5 {}\n",
                       {mu_r}),
                false);
  }
}

/// LAMMPS's polynomial for the damping of `tsuji`, as the restitution that gives the same here.
double restitution_of_tsuji(double e) {
  const double alpha =
      1.2728 + e * (-4.2783 + e * (11.087 + e * (-22.348 + e * (27.467 + e * (-18.022 + e * 4.8218)))));
  const double beta = alpha / std::sqrt(5.0);
  return std::exp(-pi * beta / std::sqrt(1 - beta * beta));
}

TEST(Peers, LammpsHertz) {
  if (!there(kLammps)) GTEST_SKIP() << "no LAMMPS: scripts/setup --bench";
  for (const auto& [word, changing] :
       {std::pair("mindlin", Changing::keep_spring), std::pair("mindlin_rescale", Changing::rescale),
        std::pair("mindlin/force", Changing::keep_force), std::pair("mindlin_rescale/force", Changing::lossy)})
    for (const double mu : {0.1, 0.5}) {
      HertzMindlin law;
      law.E_eff = 2e7, law.G_eff = 6e6, law.restitution = restitution_of_tsuji(0.7);
      law.friction.mu = mu;
      law.friction.take(Conventions::lammps);
      law.friction.changing = changing, law.friction.damping_factor = 0.5;
      const std::string model = filled("hertz {} 0.7 damping tsuji tangential ", {4.0 / 3.0 * 2e7}) + word +
                                filled(" {} 0.5 {}", {8 * 6e6, mu});
      const std::string what = filled("hertz, mu {}, ", {mu}) + word;
      expect_same(kLammps, what, law, "pair_style granular\npair_coeff * * " + model + "\n", false);
      expect_same(kLammps, what + ", wall", law,
                  "pair_style granular\npair_coeff * * " + model + "\nfix wall all wall/gran granular " + model +
                      " yplane 0 NULL\n",
                  true);
    }
}

TEST(Peers, LiggghtsLinear) {
  if (!there(kLiggghts)) GTEST_SKIP() << "no LIGGGHTS: scripts/setup --bench";
  for (const double mu : {0.05, 0.3, 3.0})
    for (const bool damped : {true, false})
      for (const bool limited : {true, false}) {
        Linear law = springs(0.3, mu);
        law.friction.take(Conventions::liggghts);
        law.friction.c_t = damped ? 1.2 : 0, law.clip = limited;
        const std::string model = "model hooke/stiffness tangential history ";
        const std::string settings = std::string("absolute_damping on tangential_damping ") + (damped ? "on" : "off") +
                                     " limitForce " + (limited ? "on" : "off");
        const std::string contacts = filled(
            "fix p1 all property/global kn peratomtypepair 1 1e5\nfix p2 all property/global kt peratomtypepair 1 3e4\n"
            "fix p3 all property/global gamman_abs peratomtypepair 1 3\n"
            "fix p4 all property/global gammat_abs peratomtypepair 1 1.2\n"
            "fix p5 all property/global coefficientFriction peratomtypepair 1 {}\n",
            {mu});
        const std::string what =
            filled("linear, mu {}", {mu}) + (damped ? "" : ", no tangential dashpot") + (limited ? ", limitForce" : "");
        expect_same(kLiggghts, what, law, contacts + "pair_style gran " + model + settings + "\npair_coeff * *\n",
                    false);
        expect_same(kLiggghts, what + ", wall", law,
                    contacts + "pair_style gran " + model + settings + "\npair_coeff * *\nfix wall all wall/gran " +
                        model + "primitive type 1 yplane 0.0 " + settings + "\n",
                    true);
      }
}

TEST(Peers, LiggghtsHertz) {
  if (!there(kLiggghts)) GTEST_SKIP() << "no LIGGGHTS: scripts/setup --bench";
  for (const double mu : {0.1, 0.5}) {
    HertzMindlin law = elastic(2e7, 0.3, 0.7, mu);
    law.friction.take(Conventions::liggghts);
    const std::string contacts = filled(
        "fix p1 all property/global youngsModulus peratomtype 2e7\n"
        "fix p2 all property/global poissonsRatio peratomtype 0.3\n"
        "fix p3 all property/global coefficientRestitution peratomtypepair 1 0.7\n"
        "fix p4 all property/global coefficientFriction peratomtypepair 1 {}\n"
        "pair_style gran model hertz tangential history\npair_coeff * *\n",
        {mu});
    expect_same(kLiggghts, filled("hertz, mu {}", {mu}), law, contacts, false);
    expect_same(kLiggghts, filled("hertz, mu {}, wall", {mu}), law,
                contacts + "fix wall all wall/gran model hertz tangential history primitive type 1 yplane 0.0\n", true);
  }
}

/// The two spheres with opposite spins across the line of their centres: YADE turns the spring with the mean of the
/// spins about it, this program leaves the spring, and 1 rad/s over a contact of 0.6 ms turns it by 6e-4.
std::vector<SphereSpec> untwisted() {
  std::vector<SphereSpec> s = spheres(false);
  const Vec3 line = s[1].position - s[0].position, n = (1 / norm(line)) * line;
  s[0].angular_velocity = s[0].angular_velocity - dot(n, s[0].angular_velocity) * n;
  s[1].angular_velocity = -1.0 * s[0].angular_velocity;
  return s;
}

/// The two spheres by YADE's Cundall-Strack law, which has no dashpot. Its velocities are those of half a step before,
/// so that two of them, one step apart, have the velocity of the instant between as their mean. Its way against
/// ratcheting, which enlarges velocities by (r1 + r2)/(r1 + r2 - delta) before it takes the slip, is switched off.
std::string yade_script(const std::vector<SphereSpec>& s, double k_n, double ratio, double mu) {
  // k_n = 2 E r1 r2/(r1 + r2), k_t of Poisson's ratio alike
  const double young = k_n * (s[0].radius + s[1].radius) / (2 * s[0].radius * s[1].radius);
  std::string text = filled("m = O.materials.append(FrictMat(young={}, poisson={}, frictionAngle={}, density={}))\n",
                            {young, ratio, std::atan(mu), kDensity});
  for (const SphereSpec& b : s) {
    const Vec3 &x = b.position, &v = b.velocity, &w = b.angular_velocity;
    text += filled(
        "i = O.bodies.append(sphere(({}, {}, {}), {}, material=m))\nO.bodies[i].state.vel = ({}, {}, {})\n"
        "O.bodies[i].state.angVel = ({}, {}, {})\n",
        {x.x, x.y, x.z, b.radius, v.x, v.y, v.z, w.x, w.y, w.z});
  }
  text += filled("O.dt = {}\n", {kStep});
  text += "steps, every = " + std::to_string(kSteps) + ", " + std::to_string(kEvery) + "\n";
  return text + R"(
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]),
             InteractionLoop([Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False)], [Ip2_FrictMat_FrictMat_FrictPhys()],
                             [Law2_ScGeom_FrictPhys_CundallStrack()]),
             NewtonIntegrator(damping=0, gravity=(0, 0, 0))]
now = lambda: [Vector3(v) for b in O.bodies for v in (b.state.vel, b.state.angVel)]
with open('out', 'w') as out:
    before = now()
    for n in range(0, steps + 1, every):
        O.run(1, True)
        after = now()
        for a, b in zip(before, after): out.write('%.17g %.17g %.17g\n' % tuple((a + b) / 2))
        if n < steps:
            O.run(every - 1, True)
            before = now()
import os
os._exit(0)  # its own end may crash without a display
)";
}

TEST(Peers, YadeCundallStrack) {
  if (std::system("command -v yade >/dev/null 2>&1") != 0) GTEST_SKIP() << "no YADE: scripts/setup --bench";
  for (const double mu : {0.05, 0.3, 3.0}) {
    Linear law = springs(0.3, mu);
    law.damping = 0;
    const Scratch scratch;
    write_file(scratch / "in.py", yade_script(untwisted(), law.k_n, 0.3, mu));
    ASSERT_EQ(std::system(("cd " + scratch.path().string() + " && yade -n -x -j1 in.py >log 2>&1").c_str()), 0)
        << text_of(scratch / "log");
    std::vector<Vec3> theirs;
    std::istringstream rows(text_of(scratch / "out"));
    for (Vec3 row; rows >> row.x >> row.y >> row.z;) theirs.push_back(row);
    const std::vector<Vec3> ours = by_engine(law, false, untwisted());
    const double difference = apart(ours, theirs);
    std::printf("yade, mu %g: %.1e\n", mu, difference);
    EXPECT_LT(difference, 2e-6) << mu;
    EXPECT_GT(norm(ours.back() - ours[1]), 1) << "nothing happened";
  }
}

}  // namespace
}  // namespace subsoil::dem::test::peers_test
