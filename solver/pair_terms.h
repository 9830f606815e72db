// What refinement knows of a pair of sites before it decides: what may reach from one to the other
// at the most, how a kernel varies over either end, and how sure a look at it is. Shared by pairs
// of elements (refine.cpp) and those with groups (refine_groups.cpp).
//
// Pure functions, any thread.
#pragma once

#include "solver/coupling.h"

namespace atrium {

// A transfer is thin where all of it, not its error alone, weighs less than this share of what a
// link's error may.
inline constexpr double kThin = 0.2;
// Radiosity, of the mean irradiance, below which a source is not less worth looking at.
inline constexpr double kDarkest = 0.5;
// Radiosity, likewise, that an error in the form factor of a close source costs at the least. Found
// on rooms and a ward: .5 made twice the elements of a ward at 2%, .08 left floors under boxes lit.
inline constexpr double kDarkStake = 0.2;
// A transfer below this share is left to the closing of its row.
inline constexpr double kNegligible = 2e-3;
// Root mean square error left by a mixed bundle of 16 segments, relative to √(v(1-v)) of the
// transfer.
inline constexpr double kMixed = 0.5;
// The same for a bundle that agrees on every segment though something may stand between: its four
// ends on either side are as good as four segments where a blocker is close to one of them, a table
// over the floor.
inline constexpr double kUnsureFour = 0.19;
// And where sixteen more segments between ends of their own agree as well.
inline constexpr double kUnsure = 0.04;
// A shadow that rays from all elements of a source miss alike counts for so many times what one of
// them errs by, at the most: a wall beside a curtain had the light of a hundred spots, each within
// what it may be wrong by, in a strip that sees none of them.
inline constexpr double kMostAlike = 2;
// Of the variation below a partly hidden source's element, how much may go by what is hidden: the
// spot that a lamp's panel lights on the ceiling above it is hidden from all but the panel.
inline constexpr double kHidden = 1;
// Of the light at an element, or of what a link may bring it, how much is taken to jump across a
// contact line; and how many times a link's threshold that may leave of all the light, as the errors
// of about ten links together do.
inline constexpr double kJump = 0.5;
inline constexpr double kJumpOfLinks = 3;
// From the standard deviation of E over an element to how far below the mean its dark end lies: √3
// for a slope across a square.
inline constexpr double kDarkEnd = 1.73;
// What nodes alone leave open of a form factor, relative to it.
inline constexpr double kUnsureShape = 0.01;

// Has either of two elements' sites anything in front of the other?
bool facing(const Site& a, const Site& b, double tolerance);

// An upper bound, nearly, of the form factor receiver → source, root mean square over the receiver.
double form_factor_bound(const Site& r, const Site& s);

// Mean square over the source of the receiver's sensitivity to it, as its nodes tell.
double mean_square_over_source(const Site& r, const Site& s, const Kernel& kernel);

// Spread over the source of the receiver's sensitivity to it, as a form factor. A receiver close to
// a large source sees mostly a part of it, near which there need be no node: a lamp's back sees the
// spot of the ceiling that it lights.
double sensitivity_spread(const Site& r, const Site& s, const Kernel& kernel);

// The least of the receiver's nodes' configuration factors.
double darkest_row(const Kernel& kernel);

// The most that any part of the receiver is known to see: in the mean, or at a probe.
double largest_factor(const Kernel& kernel);

// Share of the transfer that comes through, weighed pair by pair.
double seen_share(const Site& r, const Kernel& open, const Kernel& seen);

// Variance of a form factor of which 16 segments see the share v, by the rule of succession: that
// none got through, or all, does not make it certain.
double variance_of(double form_factor, double v);

}  // namespace atrium
