// BiCGSTAB: A x = b for a matrix that is not symmetric and known by what it does to a vector alone;
// one system a channel, side by side. [van der Vorst 1992] Preconditioned by the diagonal.
//
// Every channel takes the steps that it would take alone, and stands still once it is solved. Our
// own, because a library's wants a copy of the matrix, one channel at a time, that is as large as
// all else the coarse system holds. Pure function.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "engine/spectrum.h"

namespace atrium {

// Writes A x into y.
using Times = std::function<void(std::span<const Spectrum> x, std::span<Spectrum> y)>;

// solved: the relative residual at which a channel ends; steps: at most.
std::vector<Spectrum> bicgstab(const Times& times, std::span<const Spectrum> diagonal,
                               std::span<const Spectrum> b, double solved, int steps);

// Vectors of as many spectra as b that it holds at once, x included.
inline constexpr std::size_t kVectorsOfBicgstab = 8;

}  // namespace atrium
