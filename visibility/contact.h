// Contacts: the segments of a patch's plane where other surfaces meet it on its lit side. Radiosity
// may jump across them: a box's foot on the floor, a partition's on a slab that runs on under it. The
// outline of what hovers close over the plane counts too: a lamp's panel just below a ceiling.
// Pure functions; safe from any thread.
#pragma once

#include <optional>
#include <vector>

#include "engine/geometry.h"
#include "engine/model.h"
#include "engine/scene.h"
#include "visibility/box_tree.h"

namespace atrium {

// The boxes of all surfaces of the scene, for find_contacts and cut_at_footprints.
BoxTree surface_tree(const Scene& scene);

// Where a polygon meets the plane with some of it in front: along an edge that lies in the plane,
// or across its inside.
std::optional<Contact> meet(PolygonView polygon, const Plane& plane, double tolerance);

// The contacts of a polygon seen counter-clockwise from its lit side: clipped to its inside, those
// along its own edges left out, overlapping ones merged.
std::vector<Contact> find_contacts(const Scene& scene, const BoxTree& surfaces,
                                   PolygonView polygon);

}  // namespace atrium
