#include "visibility/partition.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "visibility/bsp.h"
#include "visibility/contact.h"
#include "visibility/footprint.h"
#include "visibility/gap.h"
#include "visibility/global_oracle.h"
#include "visibility/patch_cut.h"
#include "visibility/portal.h"
#include "visibility/sealed.h"

namespace atrium {

namespace {

struct Space {
  Bsp bsp;
  std::vector<CellPortal> portals;  // between lit cells
  std::vector<bool> lit;
  std::vector<Gap> gaps;
  Rooms rooms;
};

// A patch before it has found its place among the clusters.
struct LoosePatch {
  Patch patch;
  PatchPiece piece;
  std::uint32_t room = 0;
  std::uint32_t part = 0;  // of its object in that room, where it was split by proximity
};

Polygon side_of(const Scene& scene, const Surface& surface, Sides side) {
  const PolygonView view = scene.polygon(surface);
  Polygon polygon(view.begin(), view.end());
  if (side == kBack) std::reverse(polygon.begin(), polygon.end());
  return polygon;
}

std::vector<std::uint32_t> cells_of_emitters(const Scene& scene, const Bsp& bsp) {
  std::vector<CellPiece> pieces;
  for (const Surface& s : scene.surfaces) {
    if (!scene.materials[s.material.value].emits()) continue;
    for (Sides side : {kFront, kBack}) {
      if (!(s.sides & side)) continue;
      const Polygon polygon = side_of(scene, s, side);
      drop_polygon(bsp, bsp.root, polygon, plane_of(polygon).normal, pieces);
    }
  }
  std::vector<std::uint32_t> cells;
  for (const CellPiece& piece : pieces) cells.push_back(piece.cell);
  return cells;
}

std::vector<CellJoint> joints(const std::vector<CellPortal>& portals) {
  std::vector<CellJoint> out;
  for (const CellPortal& p : portals) out.push_back({p.front, p.back});
  return out;
}

Space divide_space(const Scene& scene, double gap) {
  Space space;
  space.bsp = build_bsp(scene, gap);
  const auto light = [&] {
    space.portals = find_portals(space.bsp);
    space.gaps = close_gaps(space.bsp, gap, space.portals);
    space.lit = flood(space.bsp.cells.size(), space.portals, cells_of_emitters(scene, space.bsp));
  };
  light();
  space.bsp = prune(space.bsp, joints(space.portals), space.lit,
                    find_rooms(space.bsp, space.portals, space.lit).of_cell);
  light();
  std::erase_if(space.portals, [&](const CellPortal& p) { return !space.lit[p.front]; });
  space.rooms = find_rooms(space.bsp, space.portals, space.lit);
  return space;
}

// The room that has most of the patch.
std::uint32_t main_room(const PatchPiece& piece, const Rooms& rooms) {
  std::map<std::uint32_t, double> share;
  for (const CellPiece& p : piece.pieces) share[rooms.of_cell[p.cell]] += area(p.polygon);
  return std::max_element(share.begin(), share.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

// What a convex polygon leaves of convex pieces in its plane.
std::vector<Polygon> subtract(std::vector<Polygon> pieces, PolygonView hole, const Vec3& normal,
                              double tolerance) {
  std::vector<Polygon> left;
  for (std::size_t i = 0; i < hole.size() && !pieces.empty(); ++i) {
    const Vec3 edge = hole[(i + 1) % hole.size()] - hole[i];
    if (!(length(edge) > 0)) continue;
    const Vec3 outward = normalize(cross(edge, normal));
    std::vector<Polygon> inside;
    for (const Polygon& piece : pieces) {
      Split parts = split(piece, {outward, dot(outward, hole[i])}, tolerance);
      if (!parts.front.empty()) left.push_back(std::move(parts.front));
      if (!parts.back.empty()) inside.push_back(std::move(parts.back));
    }
    pieces = std::move(inside);
  }
  return left;
}

// Do other surfaces count on this side of the whole piece? Then the piece is nothing there.
bool covered(const Scene& scene, const BoxTree& tree, std::uint32_t own, const Polygon& piece) {
  const Vec3 side = plane_of(piece).normal;
  std::vector<Polygon> left{piece};
  tree.visit(bounds(piece), [&](std::uint32_t i) {
    const Surface& s = scene.surfaces[i];
    const PolygonView polygon = scene.polygon(s);
    const Plane plane = plane_of(polygon);
    const Sides here = dot(plane.normal, side) > 0 ? kFront : kBack;
    if (i == own || !(s.sides & here)) return;
    const bool coplanar = std::all_of(piece.begin(), piece.end(), [&](const Vec3& x) {
      return std::abs(plane.distance(x)) <= kSliverTolerances * scene.tolerance;
    });
    if (coplanar) left = subtract(std::move(left), polygon, plane.normal, scene.tolerance);
  });
  return std::all_of(left.begin(), left.end(), [&](const Polygon& rest) {
    return strip_width(rest) < kSliverTolerances * scene.tolerance;
  });
}

// Adds the patch; one with too many corners is halved from corner to corner until none has.
void add_patch(LoosePatch loose, double tolerance, std::vector<LoosePatch>& patches) {
  const Polygon& polygon = loose.piece.polygon;
  if (polygon.size() <= kMaxPatchVertices) {
    patches.push_back(std::move(loose));
    return;
  }
  const Vec3 a = polygon.front(), across = polygon[polygon.size() / 2] - a;
  const Vec3 normal = normalize(cross(across, plane_of(polygon).normal));
  const Plane cut{normal, dot(normal, a)};
  for (const Plane& half : {cut, cut.flipped()}) {
    LoosePatch part = loose;
    part.piece = clip(loose.piece, half, tolerance);
    if (!part.piece.pieces.empty()) add_patch(std::move(part), tolerance, patches);
  }
}

// What both sides of the surfaces show to lit space.
std::vector<LoosePatch> find_patches(const Scene& scene, const Space& space, const BoxTree& tree,
                                     const SealedSolids& sealed, double median,
                                     std::span<const std::uint32_t> surfaces,
                                     std::uint64_t& dark_surfaces) {
  std::vector<LoosePatch> patches;
  for (std::uint32_t i : surfaces) {
    const Surface& s = scene.surfaces[i];
    const std::size_t before = patches.size();
    bool faces_light = false;
    for (Sides side : {kFront, kBack}) {
      const bool inert = !(s.sides & side);
      for (PatchPiece& piece :
           cut_patch(space.bsp, space.lit, space.rooms, side_of(scene, s, side))) {
        faces_light = true;
        if (inert && covered(scene, tree, i, piece.polygon)) continue;
        LoosePatch loose;
        loose.patch.surface = SurfaceId(i);
        loose.patch.material = s.material;
        loose.patch.back = side == kBack;
        loose.room = main_room(piece, space.rooms);
        std::vector<PatchPiece> parts;
        if (inert)
          parts.push_back(std::move(piece));
        else
          parts = cut_at_footprints(scene, tree, median, i, std::move(piece));
        for (PatchPiece& part : parts) {
          loose.patch.inert = inert || sealed.darken(part.polygon);
          loose.patch.footprint = part.footprint;
          loose.piece = std::move(part);
          add_patch(loose, scene.tolerance, patches);
        }
      }
    }
    if (patches.size() == before && !faces_light) ++dark_surfaces;
  }
  return patches;
}

// Halves a crowd along its longest axis until no part is larger than `most`.
void split_crowd(std::vector<LoosePatch>& patches, std::vector<std::uint32_t> crowd,
                 std::uint32_t most, std::uint32_t& next_part) {
  if (crowd.size() <= most) {
    for (std::uint32_t i : crowd) patches[i].part = next_part;
    ++next_part;
    return;
  }
  Box box;
  for (std::uint32_t i : crowd) box.extend(centroid(patches[i].piece.polygon));
  const Vec3 size = box.extent();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::stable_sort(crowd.begin(), crowd.end(), [&](std::uint32_t a, std::uint32_t b) {
    return centroid(patches[a].piece.polygon)[axis] < centroid(patches[b].piece.polygon)[axis];
  });
  const auto middle = crowd.begin() + static_cast<std::ptrdiff_t>(crowd.size() / 2);
  split_crowd(patches, {crowd.begin(), middle}, most, next_part);
  split_crowd(patches, {middle, crowd.end()}, most, next_part);
}

void split_crowds(std::vector<LoosePatch>& patches, std::uint32_t most) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> in_room;
  for (std::uint32_t i = 0; i < patches.size(); ++i) in_room[patches[i].room].push_back(i);
  for (auto& [room, crowd] : in_room) {
    if (crowd.size() <= most) continue;
    std::uint32_t part = 0;
    split_crowd(patches, std::move(crowd), most, part);
  }
}

// Lays an object's patches out in the model, a cluster for each room and part of a crowd, and adds
// what of each cluster each cell has.
void lay_out(std::span<const LoosePatch> sorted, ObjectId object, const Bsp& bsp, Model& model,
             std::vector<ClusterInCell>& out) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Box> places;
  const LoosePatch* last = nullptr;
  for (const LoosePatch& loose : sorted) {
    if (!last || last->room != loose.room || last->part != loose.part) {
      Cluster cluster;
      cluster.object = object;
      cluster.room = loose.room;
      cluster.first_patch = static_cast<std::uint32_t>(model.patches.size());
      model.clusters.push_back(cluster);
    }
    last = &loose;
    Cluster& cluster = model.clusters.back();
    const auto id = static_cast<std::uint32_t>(model.clusters.size() - 1);
    Patch patch = loose.patch;
    patch.cluster = ClusterId(id);
    patch.first_vertex = static_cast<std::uint32_t>(model.vertices.size());
    patch.vertex_count = static_cast<std::uint32_t>(loose.piece.polygon.size());
    model.vertices.insert(model.vertices.end(), loose.piece.polygon.begin(),
                          loose.piece.polygon.end());
    model.patches.push_back(patch);
    ++cluster.patch_count;
    cluster.bounds.extend(bounds(loose.piece.polygon));
    for (const CellPiece& p : loose.piece.pieces)
      places[{id, p.cell}].extend(bounds(p.polygon, bsp.frame));
  }
  std::vector<CellId> row;
  for (auto at = places.begin(); at != places.end();) {
    const auto [cluster, cell] = at->first;
    out.push_back({cluster, cell, at->second});
    row.push_back(CellId(cell));
    if (++at != places.end() && at->first.first == cluster) continue;
    model.cells_of_cluster.push_row(row);
    row.clear();
  }
}

// Objects' patches one object after the other: before they are laid out they take much room.
std::vector<ClusterInCell> lay_out_patches(const Scene& scene, const Space& space,
                                           const BoxTree& tree, std::uint32_t most_of_cluster,
                                           Model& model) {
  std::vector<std::vector<std::uint32_t>> surfaces_of(scene.objects.size());
  for (std::uint32_t i = 0; i < scene.surfaces.size(); ++i)
    surfaces_of[scene.surfaces[i].object.value].push_back(i);
  const double median = median_of_area(scene);
  const SealedSolids sealed(scene, tree, surfaces_of);
  std::vector<ClusterInCell> places;
  for (std::uint32_t object = 0; object < surfaces_of.size(); ++object) {
    std::vector<LoosePatch> patches =
        find_patches(scene, space, tree, sealed, median, surfaces_of[object], model.dark_surfaces);
    split_crowds(patches, most_of_cluster);
    std::stable_sort(patches.begin(), patches.end(), [](const LoosePatch& a, const LoosePatch& b) {
      return std::tie(a.room, a.part) < std::tie(b.room, b.part);
    });
    lay_out(patches, ObjectId(object), space.bsp, model, places);
  }
  return places;
}

Rows<Contact> contacts_of_patches(const Scene& scene, const BoxTree& tree, const Model& model) {
  std::vector<std::vector<Contact>> found(model.patches.size());
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
    const Patch& p = model.patches[i];
    if (!p.inert) found[i] = find_contacts(scene, tree, model.polygon(p));
  });
  Rows<Contact> contacts;
  for (const std::vector<Contact>& row : found) contacts.push_row(row);
  return contacts;
}

void lay_out_space(const Space& space, Model& model) {
  for (std::size_t c = 0; c < space.bsp.cells.size(); ++c) {
    Cell cell;
    for (const CellFace& face : space.bsp.cells[c].faces) cell.bounds.extend(bounds(face.polygon));
    cell.lit = space.lit[c];
    cell.room = space.rooms.of_cell[c];
    model.cells.push_back(cell);
  }
  for (const CellPortal& p : space.portals) {
    Portal portal;
    portal.a = CellId(p.front);
    portal.b = CellId(p.back);
    portal.first_vertex = static_cast<std::uint32_t>(model.portal_vertices.size());
    portal.vertex_count = static_cast<std::uint32_t>(p.polygon.size());
    portal.area = p.area;
    model.portal_vertices.insert(model.portal_vertices.end(), p.polygon.begin(), p.polygon.end());
    model.portals.push_back(portal);
  }
  model.rooms = space.rooms.count;
}

bool any_emitter(const Scene& scene) {
  return std::any_of(scene.surfaces.begin(), scene.surfaces.end(), [&](const Surface& s) {
    return s.sides != kNoSide && scene.materials[s.material.value].emits();
  });
}

}  // namespace

PartitionCounts count(const Model& model) {
  PartitionCounts n;
  n.splits = model.cells.size() - 1;
  for (const Cell& c : model.cells) n.lit_cells += c.lit;
  std::vector<std::pair<std::uint32_t, std::uint8_t>> sides;
  for (const Patch& p : model.patches) {
    n.inert_patches += p.inert;
    n.lit_patches += !p.inert;
    if (!p.inert) sides.emplace_back(p.surface.value, p.back);
  }
  std::sort(sides.begin(), sides.end());
  n.lit_sides = static_cast<std::uint64_t>(
      std::distance(sides.begin(), std::unique(sides.begin(), sides.end())));
  n.visible_pairs = model.visible.items.size();
  return n;
}

Result<Model> partition(const Scene& scene, const PartitionOptions& options) {
  ATRIUM_CHECK(scene.tolerance > 0);
  if (!any_emitter(scene))
    return Status(Code::kScene, scene.files.empty() ? "" : scene.files.front(), "",
                  "no surface emits light", "give a material an emission (Ke, or --assign)");
  const Space space = divide_space(scene, options.close_gaps);
  const BoxTree tree = surface_tree(scene);
  Model model;
  model.tolerance = scene.tolerance;
  model.closed_gaps = gaps_of_light(scene, tree, space.gaps, space.lit);
  std::vector<ClusterInCell> places =
      lay_out_patches(scene, space, tree, options.most_patches_of_cluster, model);
  lay_out_space(space, model);
  model.contacts = contacts_of_patches(scene, tree, model);
  model.visible = find_visible(space.bsp, space.portals, model, std::move(places));
  return model;
}

}  // namespace atrium
