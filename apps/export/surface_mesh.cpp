#include "apps/export/surface_mesh.h"

#include <numbers>

#include "apps/picture/shaded_patch.h"
#include "apps/picture/tone.h"

namespace atrium {
namespace {

constexpr std::uint64_t kMostVertices = 0xffffffff;

class MeshBuilder {
 public:
  explicit MeshBuilder(const RunModel& run) : run_(run) { mesh_.origin = run.frame.origin; }

  void add(ClusterId id, const ClusterView& cluster) {
    if (full()) return;
    const ObjectId object = run_.model.clusters[id.value].object;
    if (object != object_) begin(object);
    const std::vector<ShadedPatch> shaded = shade(cluster, run_.tolerance);
    for (std::size_t p = 0; p < cluster.size(); ++p)
      if (cluster.patch_head(p).inert == 0) add(cluster.patch(p), shaded[p]);
    MeshObject& o = mesh_.objects.back();
    o.vertex_count = static_cast<std::uint32_t>(mesh_.vertices.size()) - o.first_vertex;
    o.triangle_count = static_cast<std::uint32_t>(mesh_.triangles.size()) - o.first_triangle;
  }

  bool full() const { return mesh_.vertices.size() >= kMostVertices / 2; }

  SurfaceMesh take() {
    std::erase_if(mesh_.objects, [](const MeshObject& o) { return o.triangle_count == 0; });
    mesh_.exposure = automatic_exposure(std::move(lights_));
    return std::move(mesh_);
  }

 private:
  void begin(ObjectId object) {
    object_ = object;
    mesh_.objects.push_back({run_.object_names[object.value],
                             static_cast<std::uint32_t>(mesh_.vertices.size()), 0,
                             static_cast<std::uint32_t>(mesh_.triangles.size()), 0});
  }

  std::uint32_t add_vertex(const ShadedPatch& patch, const ShadedCorner& corner) {
    mesh_.vertices.push_back({patch.frame.to_space(corner.p), corner.radiosity});
    return static_cast<std::uint32_t>(mesh_.vertices.size() - 1) -
           mesh_.objects.back().first_vertex;
  }

  void add(const PatchView& view, const ShadedPatch& patch) {
    constexpr std::uint32_t kUnused = 0xffffffff;
    std::vector<std::uint32_t> index(patch.corners.size() + patch.faces.size(), kUnused);
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::size_t f = 0; f < patch.faces.size(); ++f) {
      append_triangles(patch, f, triangles);
      const ShadedFace& face = patch.faces[f];
      if (!patch.emits)
        lights_.push_back({luminance(face.center.radiosity) / std::numbers::pi,
                           view.elements[face.element].area});
    }
    for (std::array<std::uint32_t, 3>& t : triangles) {
      for (std::uint32_t& c : t) {
        const std::size_t n = patch.corners.size();
        if (index[c] == kUnused)
          index[c] = add_vertex(patch, c < n ? patch.corners[c] : patch.faces[c - n].center);
        c = index[c];
      }
      mesh_.triangles.push_back(t);
    }
  }

  const RunModel& run_;
  SurfaceMesh mesh_;
  ObjectId object_;
  std::vector<Weighted> lights_;
};

}  // namespace

Result<SurfaceMesh> surface_mesh(Solution& solution) {
  MeshBuilder builder(solution.run());
  ATRIUM_RETURN_IF_ERROR(solution.for_each_cluster(
      [&](ClusterId id, const ClusterView& cluster) { builder.add(id, cluster); }));
  if (builder.full())
    return Status(Code::kUsage, "export", "", "more vertices than one file can index",
                  "export to .csv, or solve with a larger --min-edge");
  return builder.take();
}

}  // namespace atrium
