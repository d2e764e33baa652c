#pragma once
#include <memory>
#include <type_traits>
#include <typeinfo>

/// A contact law as the engine holds it. The laws themselves (one header each, listed in laws/list.cmake) are known to
/// their own object files only: a change in one compiles its kernels, this interface for it, and the scenario reader.
namespace subsoil::dem {

struct Friction;
struct Bond;
struct StiffnessBound;
struct WorstContact;
struct PairJob;
struct PlaneJob;
struct SurfaceJob;
class Law;
template <class T>
struct Approach;
template <class T>
struct NormalForce;

/// Numbers that a contact may keep for its law at most.
inline constexpr int kOwnMemory = 2;

/// What kernels are compiled for; the build has portable and others (SUBSOIL_SIMD).
enum class InstructionSet { portable, avx2, avx512 };

/// The loops over contacts, compiled for one law and one instruction set. `parameters` as ContactLaw gives them.
struct LawKernels {
  void (*pairs)(const void* parameters, PairJob& job);
  void (*mixed_pairs)(const void* parameters, PairJob& job);  ///< in mixed precision
  void (*planes)(const void* parameters, PlaneJob& job);
  void (*surface)(const void* parameters, SurfaceJob& job);
};

/// A law whose parameters are resolved. Calls are virtual: for what is asked once per run of contacts or less often.
class ContactLaw {
 public:
  virtual ~ContactLaw() = default;

  virtual const char* name() const = 0;  ///< the scenario's name for it
  /// Maximum gap across which the law acts without bonds, between bodies whose effective radius is r_eff at most, m; at
  /// surfaces the spheres' own.
  virtual double cutoff(double r_eff) const = 0;
  /// Likewise with bonds, between spheres up to a radius, m; of a pair r_eff is half of it at most.
  virtual double pair_cutoff(double largest_radius) const = 0;
  virtual double rest_overlap() const = 0;  ///< of a pair at rest without load, m
  virtual const Friction& friction() const = 0;
  virtual const Bond* bond() const = 0;  ///< null: spheres of this law are never bonded
  virtual int own_memory() const = 0;    ///< numbers that each contact keeps for the law, at most kOwnMemory
  /// Whether part of the force loses energy along its path, so that it is no slope of the stored energy.
  virtual bool plastic() const = 0;
  /// Whether by a convention of the law a contact that parts may set energy free which it never stored.
  virtual bool may_gain() const = 0;
  virtual NormalForce<double> normal(const Approach<double>& a, double (&memory)[kOwnMemory]) const = 0;
  virtual StiffnessBound bound(const WorstContact& worst) const = 0;
  /// Throws std::invalid_argument when attraction is stronger than the contact of bodies of this r_eff.
  virtual void refuse_collapse(double r_eff) const = 0;

  virtual Law weakened(double share) const = 0;  ///< with a share of its attraction
  virtual Law with_friction(const Friction& friction) const = 0;

  virtual const LawKernels& kernels(InstructionSet set) const = 0;
  virtual const void* parameters() const = 0;
  /// Its parameters if they are of this type, else null.
  virtual const void* parameters_of(const std::type_info& type) const = 0;
};

/// `given` with what follows from its parameters filled in, as Cohesive or Bonded where it has either. Throws
/// std::invalid_argument when they contradict each other. Defined in the law's own object file (contact_law_of.hpp):
/// that of a type that laws/list.cmake does not list is not found by the linker.
template <class L>
std::shared_ptr<const ContactLaw> make_law(const L& given);

/// Handle of a law: copies share it.
class Law {
 public:
  template <class L>
  requires requires(const L& law) { law.resolved(); }
  Law(const L& given) : law_(make_law(given)) {}
  explicit Law(std::shared_ptr<const ContactLaw> law) : law_(std::move(law)) {}

  const ContactLaw* operator->() const { return law_.get(); }
  /// The parameters, resolved, if the law is of this type; else null.
  template <class L>
  const L* get_if() const {
    return static_cast<const L*>(law_->parameters_of(typeid(L)));
  }

 private:
  std::shared_ptr<const ContactLaw> law_;
};

}  // namespace subsoil::dem
