# The contact laws, in the order in which `subsoil explain` and docs/reference/keys.md show them:
#   contact_law(CLASS HEADER [COHESION] [BOND] [BOND_KERNELS])
# COHESION, BOND: the class has a member `cohesion`, `bond`. Kernels with cohesion are compiled of each; of bonded
# spheres where BOND_KERNELS says so (10 to 20 s of processor time a law), else one kernel for all, which takes the law lane by
# lane (kernel/any_bonded_law.hpp).
# libdem/CMakeLists.txt writes of each line the object files of the law: its interface (contact_law_of.hpp) and its
# kernels; and of all lines law_list.hpp, from which reader, reference and tests take the laws.
contact_law(Wet wet.hpp BOND)
contact_law(Linear linear.hpp COHESION BOND BOND_KERNELS)
contact_law(HertzMindlin hertz_mindlin.hpp COHESION BOND BOND_KERNELS)
contact_law(HuntCrossley hunt_crossley.hpp COHESION BOND)
contact_law(Jkr jkr.hpp BOND)
contact_law(Hysteretic hysteretic.hpp COHESION BOND)
contact_law(Luding luding.hpp BOND)
contact_law(Eepa eepa.hpp BOND)
contact_law(VariableRestitution variable_restitution.hpp BOND)
