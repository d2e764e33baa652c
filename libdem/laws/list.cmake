# The contact laws, in the order in which `subsoil explain` and docs/reference/keys.md show them:
#   contact_law(CLASS HEADER [COHESION] [BOND])
# COHESION, BOND: the class has a member `cohesion`, `bond`; its kernels are compiled with either, too.
# libdem/CMakeLists.txt writes of each line the object files of the law: its interface (contact_law_of.hpp) and its
# kernels; and of all lines law_list.hpp, from which reader, reference and tests take the laws.
contact_law(Wet wet.hpp)
contact_law(Linear linear.hpp COHESION BOND)
contact_law(HertzMindlin hertz_mindlin.hpp COHESION BOND)
contact_law(HuntCrossley hunt_crossley.hpp COHESION)
contact_law(Jkr jkr.hpp)
contact_law(Hysteretic hysteretic.hpp COHESION)
contact_law(Luding luding.hpp)
contact_law(Eepa eepa.hpp)
contact_law(VariableRestitution variable_restitution.hpp)
