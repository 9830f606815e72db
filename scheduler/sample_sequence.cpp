#include "scheduler/sample_sequence.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace atrium {

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

std::uint32_t reversed(std::uint32_t x) {
  x = (x >> 16) | (x << 16);
  x = ((x & 0xff00ff00u) >> 8) | ((x & 0x00ff00ffu) << 8);
  x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
  return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

// Owen's scrambling of the bits of x, the lowest the most significant; the constants are Burley's.
std::uint32_t scrambled(std::uint32_t x, std::uint32_t key) {
  x ^= x * 0x3d20adeau;
  x += key;
  x *= (key >> 16) | 1;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

// The second dimension of Sobol's sequence, its bits reversed as scrambled() wants them.
std::uint32_t second_dimension(std::uint32_t i) {
  std::uint32_t bits = 0;
  for (std::uint32_t v = 1u << 31; i != 0; i >>= 1, v ^= v >> 1)
    if (i & 1) bits ^= v;
  return reversed(bits);
}

double fraction(std::uint32_t bits) { return std::ldexp(static_cast<double>(bits), -32); }

}  // namespace

std::uint64_t mixed(std::uint64_t key, std::uint64_t number) {
  std::uint64_t z = key + (number + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

SampleSequence::SampleSequence(std::uint64_t key)
    : first_(static_cast<std::uint32_t>(mixed(key, 0))),
      second_(static_cast<std::uint32_t>(mixed(key, 1))) {}

Vec2 SampleSequence::at(std::uint32_t i) const {
  return {fraction(reversed(scrambled(i, first_))),
          fraction(reversed(scrambled(second_dimension(i), second_)))};
}

Hemisphere::Hemisphere(const Vec3& normal) {
  constexpr double kNotAlong = 0.6;
  frame_.n = normal;
  const Vec3 other = std::abs(normal.x) < kNotAlong ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  frame_.u = normalize(cross(other, normal));
  frame_.v = cross(frame_.n, frame_.u);
}

Vec3 Hemisphere::cosine_direction(const Vec2& square) const {
  const double r = std::sqrt(square.x), angle = kTwoPi * square.y;
  return r * std::cos(angle) * frame_.u + r * std::sin(angle) * frame_.v +
         std::sqrt(1 - square.x) * frame_.n;
}

// The square's first coordinate chooses a triangle of the fan around the first corner, and what is
// left of it a place there.
Vec3 point_of(PolygonView polygon, const Vec2& square) {
  const auto triangle = [&](std::size_t i) {
    return 0.5 * length(cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]));
  };
  double whole = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) whole += triangle(i);
  double left = square.x * whole, part = triangle(2);
  std::size_t i = 2;
  for (; i + 1 < polygon.size() && left >= part; part = triangle(++i)) left -= part;
  const double r = std::sqrt(part > 0 ? std::min(1.0, left / part) : 0);
  const Vec3 far = polygon[i - 1] + square.y * (polygon[i] - polygon[i - 1]);
  return polygon[0] + r * (far - polygon[0]);
}

}  // namespace atrium
