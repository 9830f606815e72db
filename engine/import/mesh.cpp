#include "engine/import/mesh.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "engine/import/ears.h"
#include "engine/import/plane_pieces.h"
#include "engine/import/weld.h"

namespace atrium {
namespace {

// Of the tolerance: what welding and the deviations of outlines may use up each, so that faces
// stay planar and convex within the whole of it.
constexpr double kWeldShare = 0.5;

// The ring from its least vertex on: equal for faces that differ in where they start only.
Ring canonical(const Ring& ring) {
  Ring r = ring;
  std::rotate(r.begin(), std::min_element(r.begin(), r.end()), r.end());
  return r;
}

struct RingHash {
  std::size_t operator()(const Ring& ring) const noexcept {
    std::uint64_t h = ring.size();
    for (const std::uint32_t v : ring) h = (h ^ v) * 0x9e3779b97f4a7c15ull + (h >> 31);
    return h;
  }
};

class MeshMaker {
 public:
  MeshMaker(const RawModel& model, const SceneFrame& frame, double tolerance,
            const std::vector<Material>& materials, WarningLog& warnings)
      : model_(model),
        frame_(frame),
        materials_(materials),
        warnings_(warnings),
        welder_(kWeldShare * tolerance),
        welded_(model.vertices.size(), kNone) {
    mesh_.tolerance = tolerance;
  }

  Mesh make(const std::vector<bool>& kept) {
    // All vertices first, so that later points of cuts come after them.
    for (std::size_t i = 0; i < model_.faces.size(); ++i)
      if (kept[i])
        for (const std::uint32_t v : model_.corners_of(model_.faces[i]))
          if (welded_[v] == kNone)
            welded_[v] = welder_.weld(frame_.to_internal(model_.vertices[v]));
    mesh_.vertices = welder_.take();
    for (std::size_t i = 0; i < model_.faces.size(); ++i)
      if (kept[i]) add(static_cast<std::uint32_t>(i));
    return std::move(mesh_);
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  void add(std::uint32_t raw) {
    const RawFace& f = model_.faces[raw];
    Ring ring;
    for (const std::uint32_t v : model_.corners_of(f))
      if (ring.empty() || ring.back() != welded_[v]) ring.push_back(welded_[v]);
    while (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
    Polygon scratch;
    if (ring.size() < 3 || width(mesh_.polygon(ring, scratch)) <= mesh_.tolerance) {
      warnings_.add("degenerate faces dropped", model_.describe(f));
      return;
    }
    if (planarity(mesh_.polygon(ring, scratch)) > mesh_.tolerance) {
      warnings_.add("faces that are not planar, cut into triangles", model_.describe(f));
      add_ears(ring, raw);
      return;
    }
    const bool keyholed = names_a_vertex_twice(ring);
    if (!keyholed && is_convex(mesh_.polygon(ring, scratch), mesh_.tolerance)) {
      add_simple(ring, raw);
      return;
    }
    // Concave: cut only to see that it can be, for rejoining looks at whole faces.
    const std::size_t vertices = mesh_.vertices.size();
    mesh_.polygon(ring, scratch);
    const auto pieces = convex_pieces_in_space(
        mesh_.vertices, std::span(&ring, 1), frame_for(plane_of(scratch), scratch),
        kWeldShare * mesh_.tolerance, kAreaSlack * area(scratch));
    if (!pieces) {
      warnings_.add("faces that cross themselves, cut into triangles", model_.describe(f));
      add_ears(ring, raw);
    } else if (keyholed) {
      for (const Ring& piece : *pieces) add_simple(piece, raw);
    } else {
      mesh_.vertices.resize(vertices);
      add_simple(ring, raw);
    }
  }

  void add_ears(const Ring& ring, std::uint32_t raw) {
    Polygon polygon;
    mesh_.polygon(ring, polygon);
    Polygon scratch;
    for (const auto& ear : clip_ears(polygon)) {
      const Ring triangle{ring[ear[0]], ring[ear[1]], ring[ear[2]]};
      if (width(mesh_.polygon(triangle, scratch)) > mesh_.tolerance) add_simple(triangle, raw);
    }
  }

  void add_simple(const Ring& ring, std::uint32_t raw) {
    const RawFace& f = model_.faces[raw];
    Face face;
    face.object = ObjectId(f.object);
    face.material = MaterialId(f.material);
    face.raw = raw;
    Polygon scratch;
    face.plane = plane_of(mesh_.polygon(ring, scratch));
    face.area = area(scratch);
    face.first_corner = static_cast<std::uint32_t>(mesh_.corners.size());
    face.corner_count = static_cast<std::uint32_t>(ring.size());
    Ring key = canonical(ring);
    key.push_back(f.object);
    const auto [twin, added] =
        seen_.try_emplace(std::move(key), static_cast<std::uint32_t>(mesh_.faces.size()));
    if (!added) {
      warnings_.add("duplicate faces dropped", model_.describe(f));
      Face& first = mesh_.faces[twin->second];
      // The emitter counts, else the first.
      if (materials_[f.material].emits() && !materials_[first.material.value].emits())
        first.material = face.material;
      return;
    }
    mesh_.corners.insert(mesh_.corners.end(), ring.begin(), ring.end());
    mesh_.faces.push_back(face);
  }

  const RawModel& model_;
  const SceneFrame& frame_;
  const std::vector<Material>& materials_;
  WarningLog& warnings_;
  Welder welder_;
  std::vector<std::uint32_t> welded_;  // by vertex of the model
  std::unordered_map<Ring, std::uint32_t, RingHash> seen_;
  Mesh mesh_;
};

// Union-find with path halving.
std::uint32_t root(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

}  // namespace

double width(PolygonView polygon) {
  const double extent = bounds(polygon).diagonal();
  return extent > 0 ? 2 * area(polygon) / extent : 0;
}

Mesh make_mesh(const RawModel& model, const std::vector<bool>& kept, const SceneFrame& frame,
               double tolerance, const std::vector<Material>& materials, WarningLog& warnings) {
  return MeshMaker(model, frame, tolerance, materials, warnings).make(kept);
}

void split_unnamed_objects(RawModel& model, Mesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto unnamed = [&](const Face& f) { return model.objects[f.object.value].unnamed_file; };
  for (const Face& f : mesh.faces)
    if (unnamed(f))
      for (const std::uint32_t v : mesh.corners_of(f))
        parent[root(parent, v)] = root(parent, mesh.corners[f.first_corner]);
  // The parts of each object, by their roots, in the order of their first faces.
  std::vector<std::unordered_map<std::uint32_t, std::uint32_t>> parts(model.objects.size());
  for (const Face& f : mesh.faces)
    if (unnamed(f))
      parts[f.object.value].try_emplace(root(parent, mesh.corners[f.first_corner]),
                                        static_cast<std::uint32_t>(parts[f.object.value].size()));
  std::vector<RawObject> objects;
  std::vector<std::uint32_t> first(model.objects.size());
  for (std::size_t o = 0; o < model.objects.size(); ++o) {
    first[o] = static_cast<std::uint32_t>(objects.size());
    for (std::size_t part = 0; part < std::max<std::size_t>(1, parts[o].size()); ++part) {
      objects.push_back(model.objects[o]);
      if (parts[o].size() > 1) objects.back().name += " part " + std::to_string(part + 1);
    }
  }
  for (RawFace& f : model.faces) f.object = first[f.object];
  for (Face& f : mesh.faces) {
    const std::size_t o = f.object.value;
    std::uint32_t index = first[o];
    if (unnamed(f)) index += parts[o].at(root(parent, mesh.corners[f.first_corner]));
    f.object = ObjectId(index);
    model.faces[f.raw].object = index;
  }
  model.objects = std::move(objects);
}

}  // namespace atrium
