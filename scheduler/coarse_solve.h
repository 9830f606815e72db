// Coarse solve: (I - K) x = r over the coarse units (equilibrium.h), in two grids as for integral
// equations of the second kind [Brakhage 1960; Hackbusch 1985, ch. 16]. Over undivided patches it
// is solved by BiCGSTAB; over their parts a cycle is one step in their order and what that leaves
// over undivided patches, and cycles are taken together so as to leave least, by conjugate
// residuals [Eisenstat, Elman, Schultz 1983]. Most leave .1, where BiCGSTAB over parts took fifty
// products with K, or 150 at ρ = .99999. By themselves they need not leave less: in a white office,
// between a wall and what stands close before it, one made four times as much of it.
//
// Functions of their arguments.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scheduler/coarse_rows.h"
#include "scheduler/coarse_units.h"

namespace atrium {

// Rows of K by unit.
using CoarseMatrix = std::vector<std::vector<CoarseEntry>>;

// x of r = light, damping times K taken: to a fifth of it where patches are divided, else as good
// as exact. What is left is left to the sweeps.
std::vector<Spectrum> solve_coarse(const CoarseUnits& units, const CoarseMatrix& k, double damping,
                                   std::span<const Spectrum> light);

// Of undivided patches: which one a unit is of, counted by their first parts.
std::vector<std::uint32_t> undivided_numbers(const CoarseUnits& units);

}  // namespace atrium
