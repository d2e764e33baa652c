#pragma once
#include <span>
#include <vector>

#include "libdem/contacts/surface_contacts.hpp"

/// Forces on spheres at edges, corners and curved surfaces, and what all contacts of a boundary add up to. Flat faces
/// are part of the sweep.
namespace subsoil::dem {

/// What forces at boundaries are made of. Written meanwhile: the chunk and its entries.
struct SurfaceForces {
  const Kernel& kernel;
  const ContactLaws& laws;
  const ParticleStore& particles;
  std::span<const Boundary> boundaries;
  SurfaceContacts& contacts;
  double elapsed;  ///< s since the last step

  /// Contacts of a chunk's entries: geometry one sphere at a time (geometry/), the law eight contacts at a time.
  void evaluate(SurfaceChunk& chunk) const;
};

/// One lane of a job at edges and curved surfaces. @param turn of the normal (surface_motion.hpp)
void put_contact(SurfaceJob& job, std::uint32_t lane, std::uint32_t sphere, const Sphere& s, double mass,
                 const Boundary& b, const Vec3& n, double distance, const Vec3& turn);
/// Into the lanes beyond its last contact.
void repeat_first(SurfaceJob& job);
/// Of a lane that has been evaluated.
ContactRecord record_of(const SurfaceJob& job, std::uint32_t lane, const Sphere& s, std::uint32_t boundary,
                        const Vec3& point, const Vec3& force);

/// What the plane runs of a boundary have in common in a step.
PlaneJob plane_job(const Boundary& b, const ParticleStore& particles, double elapsed);

/// The work that each boundary's motion since the last step did, from its wrenches then and now.
void add_boundary_work(std::span<Boundary> boundaries, double elapsed);

/// Wrench of each boundary in the order of its contacts, and that work.
void sum_wrenches(std::vector<Boundary>& boundaries, const SurfaceContacts& contacts, double elapsed);

}  // namespace subsoil::dem
