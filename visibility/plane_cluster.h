// Surfaces grouped by the plane they lie in: the candidates for the subdivision's planes.
// Deterministic; the order of planes follows surfaces' areas and the files' order, so that a turned
// or shifted copy of a scene gives the same planes. Pure; safe from any thread.
#pragma once

#include <vector>

#include "engine/geometry.h"
#include "engine/scene.h"

namespace atrium {

struct CandidatePlane {
  Plane plane;      // that of the largest surface in it
  Frame frame;      // in that plane, along that surface's longest edge
  double area = 0;  // m² of surfaces, the larger of the two ways they face
};

struct PlaneClusters {
  struct Member {
    SurfaceId surface;
    std::uint32_t plane = 0;
    bool along = true;  // the surface's normal runs along the plane's
  };
  std::vector<CandidatePlane> planes;  // those with at least the least area
  std::vector<Member> members;         // of those planes, in the surfaces' order
};

PlaneClusters cluster_planes(const Scene& scene, double least_area);

// The two directions most area faces, made orthogonal, and their cross product.
Frame dominant_frame(std::span<const CandidatePlane> planes, const Vec3& origin);

}  // namespace atrium
