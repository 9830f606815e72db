#include "engine/import/overlap.h"

namespace atrium {

void resolve_overlaps(const Mesh& mesh, const std::vector<PatchRing>& patches, const RawModel&,
                      Scene& scene, WarningLog&) {
  for (const PatchRing& p : patches) {
    Surface s;
    s.object = p.object;
    s.material = p.material;
    s.sides = p.sides;
    s.first_vertex = static_cast<std::uint32_t>(scene.vertices.size());
    s.vertex_count = static_cast<std::uint32_t>(p.ring.size());
    for (const std::uint32_t v : p.ring) scene.vertices.push_back(mesh.vertices[v]);
    scene.surfaces.push_back(s);
    ++scene.patches;
    scene.lights += scene.materials[p.material.value].emits();
  }
}

}  // namespace atrium
