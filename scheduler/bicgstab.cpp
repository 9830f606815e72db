#include "scheduler/bicgstab.h"

#include <cmath>
#include <limits>

#include "engine/squared.h"

namespace atrium {

namespace {

constexpr int kSystems = Spectrum::length();

Spectrum inner(std::span<const Spectrum> x, std::span<const Spectrum> y) {
  Spectrum sum{0};
  for (std::size_t i = 0; i < x.size(); ++i) sum += x[i] * y[i];
  return sum;
}

// 0 where there is nothing to divide by: that system stands still.
Spectrum divided(const Spectrum& x, const Spectrum& y) {
  Spectrum q{0};
  for (int c = 0; c < kSystems; ++c)
    if (y[c] != 0) q[c] = x[c] / y[c];
  return q;
}

}  // namespace

std::vector<Spectrum> bicgstab(const Times& times, std::span<const Spectrum> diagonal,
                               std::span<const Spectrum> b, double solved, int steps) {
  const std::size_t n = b.size();
  using Vector = std::vector<Spectrum>;
  Vector x(n, Spectrum{0}), r(b.begin(), b.end()), shadow = r;
  Vector p(n, Spectrum{0}), v = p, t = p, ready = p;
  const Spectrum enough = squared(solved) * inner(b, b);
  Spectrum shadow2 = inner(r, r), r2 = shadow2, rho{1}, alpha{1}, omega{1};
  for (int step = 0; step < steps; ++step) {
    const Spectrum last = rho;
    rho = inner(shadow, r);
    Spectrum open{0};
    bool at_right_angles = false;
    for (int c = 0; c < kSystems; ++c) {
      if (!(r2[c] > enough[c])) continue;
      open[c] = 1;
      constexpr double kNothing = std::numeric_limits<double>::epsilon();
      at_right_angles |= std::abs(rho[c]) < squared(kNothing) * shadow2[c];
    }
    if (open == Spectrum{0}) break;
    Spectrum beta = divided(rho, last) * divided(alpha, omega);
    if (at_right_angles) {  // to its shadow, a residual tells nothing: begin anew from here
      shadow = r;
      shadow2 = rho = r2;
      beta = Spectrum{0};
    }
    for (std::size_t i = 0; i < n; ++i) {
      p[i] = r[i] + beta * (p[i] - omega * v[i]);
      ready[i] = p[i] / diagonal[i];
    }
    times(ready, v);
    alpha = open * divided(rho, inner(shadow, v));
    for (std::size_t i = 0; i < n; ++i) {
      x[i] += alpha * ready[i];
      r[i] -= alpha * v[i];
      ready[i] = r[i] / diagonal[i];
    }
    times(ready, t);
    omega = open * divided(inner(t, r), inner(t, t));
    for (std::size_t i = 0; i < n; ++i) {
      x[i] += omega * ready[i];
      r[i] -= omega * t[i];
    }
    r2 = inner(r, r);
  }
  return x;
}

}  // namespace atrium
