#include "data/stairs.h"

#include <algorithm>

namespace atrium::generator {
namespace {

constexpr int kRisers = 10, kRise = 180, kGoing = 280;  // of a flight
constexpr int kFlightWidth = 1250, kLandingThick = 300, kLandingLap = 200;
// The landing at a door lies a little lower than the threshold, as if the door had a sill: no edge
// of the stairs lies on an edge of the well's walls, so that these still read as a closed shell.
constexpr int kSill = 5;
constexpr int kStart = 1400;  // from the south wall to the first riser
constexpr int kRun = (kRisers - 1) * kGoing;
constexpr int kHalfLanding = kStart + kRun;  // from the south wall to its edge
static_assert(2 * kRisers * kRise == kStoreyPitch);
static_assert(kHalfLanding + 1200 < kStairLength && 2 * kFlightWidth < kStairWidth);

// The soffit is parallel to the steps and ends at the landing's lower edge: above step k's end it
// lies at (k + 1)·rise - thickness. So far from the first riser it is at this height:
constexpr double soffit_from_riser(int height) {
  return double{kGoing} * (kLandingThick + height) / kRise - kGoing;
}
static_assert(soffit_from_riser(-kSill) > 0 && soffit_from_riser(0) < kLandingLap);

// x0..x1, first riser at y, going up in direction `up` (±1) from z, where it stands on something
// `sunk` lower; `wall` is the side that touches the stairwell's wall. The landing's front is the
// last riser.
void flight(ModelBuilder& out, PaintId paint, int x0, int x1, int y, int up, int z, int sunk,
            Side wall) {
  const double foot = soffit_from_riser(-sunk);
  const auto at = [&](double x, double along, double height) {
    return Vec3(x, y + up * along, z + height) / 1000.0;
  };
  // Corners given counter-clockwise for a flight going north.
  const auto face = [&](Polygon corners) {
    if (up < 0) std::reverse(corners.begin(), corners.end());
    out.face(paint, corners);
  };
  for (int k = 1; k < kRisers; ++k) {
    const int from = (k - 1) * kGoing, to = k * kGoing, low = k == 1 ? -sunk : (k - 1) * kRise,
              high = k * kRise;
    face({at(x0, from, low), at(x1, from, low), at(x1, from, high), at(x0, from, high)});
    face({at(x0, from, high), at(x1, from, high), at(x1, to, high), at(x0, to, high)});
    const double soffit_to = high + kRise - kLandingThick;
    Polygon side;
    const int x = wall == Side::kWest ? x1 : x0;
    if (k == 1) {
      side = {at(x, 0, low), at(x, foot, low), at(x, to, soffit_to), at(x, to, high),
              at(x, 0, high)};
    } else {
      side = {at(x, from, low + kRise - kLandingThick), at(x, to, soffit_to), at(x, to, high),
              at(x, from, high)};
    }
    if (wall == Side::kEast) std::reverse(side.begin(), side.end());
    face(std::move(side));
  }
  const double end = kRisers * kRise - kLandingThick;
  face({at(x1, foot, -sunk), at(x0, foot, -sunk), at(x0, kRun, end), at(x1, kRun, end)});
}

// A slab between three walls: its top, underside and edge are seen.
void landing(ModelBuilder& out, PaintId paint, const Rect& r, int bottom, int top, Side edge) {
  const unsigned seen = kTopFace | kBottomFace | 1u << static_cast<int>(edge);
  constexpr unsigned kAll = 63;
  out.box(paint, {metres(r.a0), metres(r.b0), metres(bottom)},
          {metres(r.a1), metres(r.b1), metres(top)}, kAll & ~seen);
}

}  // namespace

void build_stairs(ModelBuilder& out, PaintId paint, const Room& well, int storeys) {
  const Rect& r = well.area;
  for (int s = 0; s < std::max(storeys, 1); ++s) {
    const std::string name = well.name + "/stairs" + std::to_string(s + 1);
    const int z = well.z0 + s * kStoreyPitch, half = z + kStoreyPitch / 2;
    out.begin(name + "/flight_up");
    flight(out, paint, r.a0, r.a0 + kFlightWidth, r.b0 + kStart, 1, z, s > 0 ? kSill : 0,
           Side::kWest);
    out.begin(name + "/half_landing");
    landing(out, paint, {r.a0, r.a1, r.b0 + kHalfLanding, r.b1}, half - kLandingThick, half,
            Side::kSouth);
    if (storeys == 0) return;
    out.begin(name + "/flight_back");
    flight(out, paint, r.a1 - kFlightWidth, r.a1, r.b0 + kHalfLanding + kLandingLap, -1, half, 0,
           Side::kEast);
    out.begin(name + "/landing");
    landing(out, paint, {r.a0, r.a1, r.b0, r.b0 + kStart + kLandingLap},
            z + kStoreyPitch - kLandingThick, z + kStoreyPitch - kSill, Side::kNorth);
  }
}

}  // namespace atrium::generator
