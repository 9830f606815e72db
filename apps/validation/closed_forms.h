// Closed forms of form factors and configuration factors, for the suites of `atrium validate`. None
// of them shares a line with what they judge (solver/form_factor.h). All functions are pure.
#pragma once

#include <array>

namespace atrium {

// An interval of a coordinate.
struct Range {
  double lo = 0, hi = 0;
};

// From opposite equal rectangles a × b at distance c, one to the other. [Howell C-11]
double opposite_rectangles(double a, double b, double c);

// From a floor w deep to a wall h high on their common edge l. [Howell C-14]
double perpendicular_rectangles(double h, double w, double l);

// From the rectangle x1 × y1 to x2 × y2 in the plane `distance` away. [Ehlert and Smith 1993]
double parallel_rectangles(Range x1, Range y1, Range x2, Range y2, double distance);

// From the floor x × y1 to the wall y2 × z, which stands in the plane x = 0; neither goes below 0.
// [Ehlert and Smith 1993]
double floor_to_wall(Range x, Range y1, Range y2, Range z);

// From an element at the origin that faces a parallel rectangle x × y at `distance`: by Lambert's
// contour the sum over its corners, each the element under a rectangle's corner. [Siegel and
// Howell, appendix]
double element_to_parallel(Range x, Range y, double distance);

// From an element `height` over a floor, in a plane perpendicular to it, to the part x × y of the
// floor; x is measured from below the element along its normal and is not negative. [likewise]
double element_to_perpendicular(Range x, Range y, double height);

}  // namespace atrium
