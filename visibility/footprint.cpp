#include "visibility/footprint.h"

#include <algorithm>
#include <functional>
#include <map>

#include "visibility/contact.h"
#include "visibility/plane_region.h"

namespace atrium {

namespace {

bool is_sliver(PolygonView polygon, double tolerance) {
  return polygon.empty() || strip_width(polygon) < kSliverTolerances * tolerance;
}

// The convex outlines that segments close to, counter-clockwise about the normal. Each segment is
// part of one at most.
std::vector<Polygon> outlines_of(std::vector<Contact> segments, const Vec3& normal,
                                 double tolerance) {
  const double near = kSliverTolerances * tolerance;
  std::vector<Polygon> out;
  while (!segments.empty()) {
    const Vec3 start = segments.back().a;
    Vec3 at = segments.back().b;
    segments.pop_back();
    Polygon outline{start};
    while (length(at - start) > near) {
      const auto next = std::ranges::find_if(segments, [&](const Contact& s) {
        return length(s.a - at) <= near || length(s.b - at) <= near;
      });
      if (next == segments.end()) break;
      outline.push_back(at);
      at = length(next->a - at) <= near ? next->b : next->a;
      segments.erase(next);
    }
    if (outline.size() < 3 || length(at - start) > near) continue;
    if (dot(plane_of(outline).normal, normal) < 0) std::ranges::reverse(outline);
    if (is_convex(outline, tolerance)) out.push_back(std::move(outline));
  }
  return out;
}

struct Footprint {
  std::vector<Plane> rims;  // outwards
  double area = 0;          // m², of it within the piece
};

Polygon within(PolygonView polygon, std::span<const Plane> rims, double tolerance) {
  Polygon left(polygon.begin(), polygon.end());
  for (const Plane& rim : rims)
    if (!left.empty()) left = clip(left, rim.flipped(), tolerance);
  return left;
}

Footprint footprint_of(PolygonView outline, PolygonView piece, const Vec3& normal,
                       double tolerance) {
  Footprint f;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec3 edge = outline[(i + 1) % outline.size()] - outline[i];
    const Vec3 outward = normalize(cross(edge, normal));
    f.rims.push_back({outward, dot(outward, outline[i])});
  }
  const Polygon part = within(piece, f.rims, tolerance);
  f.area = is_sliver(part, tolerance) ? 0 : area(part);
  return f;
}

// By object, along which lines its surfaces meet the piece's plane.
using Feet = std::map<std::uint32_t, std::vector<Contact>>;
Feet feet_on(const Scene& scene, const BoxTree& surfaces, std::uint32_t own, PolygonView piece,
             const Plane& plane) {
  Feet feet;
  surfaces.visit(bounds(piece), [&](std::uint32_t s) {
    if (s == own) return;
    const Surface& surface = scene.surfaces[s];
    if (const auto line = meet(scene.polygon(surface), plane, scene.tolerance))
      feet[surface.object.value].push_back(*line);
  });
  return feet;
}

// Rim by rim what is outside of it, and last what is inside of all.
void cut_out(PatchPiece piece, std::span<const Plane> rims, double tolerance,
             std::vector<PatchPiece>& out) {
  for (const Plane& rim : rims) {
    PatchPiece outside = clip(piece, rim, tolerance);
    PatchPiece inside = clip(piece, rim.flipped(), tolerance);
    if (is_sliver(outside.polygon, tolerance) || is_sliver(inside.polygon, tolerance)) continue;
    out.push_back(std::move(outside));
    piece = std::move(inside);
  }
  piece.footprint = true;
  out.push_back(std::move(piece));
}

}  // namespace

std::vector<PatchPiece> cut_at_footprints(const Scene& scene, const BoxTree& surfaces,
                                          double median, std::uint32_t own, PatchPiece piece) {
  const double whole = area(piece.polygon), worth = kFootprintWorthACut * whole;
  if (whole < kCutOfMedian * median) return {std::move(piece)};
  const Plane plane = plane_of(piece.polygon);
  std::vector<Footprint> footprints;
  for (auto& [object, lines] : feet_on(scene, surfaces, own, piece.polygon, plane))
    for (const Polygon& outline : outlines_of(std::move(lines), plane.normal, scene.tolerance)) {
      Footprint f = footprint_of(outline, piece.polygon, plane.normal, scene.tolerance);
      // Not all of the piece: the walls of a room go round its floor too.
      if (f.area >= worth && f.area <= whole - worth) footprints.push_back(std::move(f));
    }
  std::ranges::stable_sort(footprints, std::greater{}, &Footprint::area);
  footprints.resize(std::min(footprints.size(), kMostFootprints));

  std::vector<PatchPiece> pieces{std::move(piece)};
  for (const Footprint& f : footprints) {
    std::vector<PatchPiece> cut;
    for (PatchPiece& p : pieces) {
      if (is_sliver(within(p.polygon, f.rims, scene.tolerance), scene.tolerance))
        cut.push_back(std::move(p));
      else
        cut_out(std::move(p), f.rims, scene.tolerance, cut);
    }
    pieces = std::move(cut);
  }
  return pieces;
}

}  // namespace atrium
