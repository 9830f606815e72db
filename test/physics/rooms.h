// Scenes by hand for closed forms: one plain builder of named rectangles.
#pragma once

#include <numbers>
#include <string>

#include "test/agree/run.h"

namespace atrium::testing {

inline constexpr double kPi = std::numbers::pi;

class Builder {
 public:
  explicit Builder(std::string title) { model_.title = std::move(title); }

  // luminance: cd/m²; M = πL.
  PaintId paint(const std::string& name, double reflectance, double luminance = 0) {
    model_.paints.push_back({name, Spectrum{reflectance}, Spectrum{luminance}});
    return static_cast<PaintId>(model_.paints.size() - 1);
  }

  Builder& face(const std::string& name, PaintId paint, const Polygon& corners) {
    model_.groups.push_back({name, static_cast<std::uint32_t>(model_.faces.size()), 1});
    model_.faces.push_back({paint, static_cast<std::uint32_t>(model_.vertices.size()),
                            static_cast<std::uint32_t>(corners.size())});
    model_.vertices.insert(model_.vertices.end(), corners.begin(), corners.end());
    return *this;
  }
  // From a corner along u, then v; it faces u × v.
  Builder& rectangle(const std::string& name, PaintId paint, const Vec3& corner, const Vec3& u,
                     const Vec3& v) {
    return face(name, paint, {corner, corner + u, corner + u + v, corner + v});
  }

  // A room's walls and floor, seen from inside; the ceiling apart.
  Builder& walls_and_floor(PaintId paint, const Vec3& lo, const Vec3& hi) {
    const Vec3 d = hi - lo, x{d.x, 0, 0}, y{0, d.y, 0}, z{0, 0, d.z};
    rectangle("floor", paint, lo, x, y);
    rectangle("wall_south", paint, lo, z, x);
    rectangle("wall_west", paint, lo, y, z);
    rectangle("wall_north", paint, lo + y, x, z);
    return rectangle("wall_east", paint, lo + x, z, y);
  }
  Builder& ceiling(PaintId paint, const Vec3& lo, const Vec3& hi) {
    const Vec3 d = hi - lo;
    return rectangle("ceiling", paint, {lo.x, lo.y, hi.z}, {0, d.y, 0}, {d.x, 0, 0});
  }
  // A ceiling with a square lamp flush in its middle, four strips around it.
  Builder& ceiling_with_lamp(PaintId paint, PaintId lamp, const Vec3& lo, const Vec3& hi,
                             double side) {
    const double x0 = (lo.x + hi.x - side) / 2, x1 = (lo.x + hi.x + side) / 2;
    const double y0 = (lo.y + hi.y - side) / 2, y1 = (lo.y + hi.y + side) / 2;
    const auto down = [&](const std::string& name, PaintId p, double ax, double ay, double bx,
                          double by) {
      rectangle(name, p, {ax, ay, hi.z}, {0, by - ay, 0}, {bx - ax, 0, 0});
    };
    down("ceiling_south", paint, lo.x, lo.y, hi.x, y0);
    down("ceiling_north", paint, lo.x, y1, hi.x, hi.y);
    down("ceiling_west", paint, lo.x, y0, x0, y1);
    down("ceiling_east", paint, x1, y0, hi.x, y1);
    down("lamp", lamp, x0, y0, x1, y1);
    return *this;
  }
  // A box that stands on the floor: its sides and its top, seen from outside.
  Builder& standing_box(const std::string& name, PaintId paint, const Vec3& lo, const Vec3& hi) {
    const Vec3 d = hi - lo, x{d.x, 0, 0}, y{0, d.y, 0}, z{0, 0, d.z};
    rectangle(name + "_south", paint, lo, x, z);
    rectangle(name + "_west", paint, lo, z, y);
    rectangle(name + "_north", paint, lo + y, z, x);
    rectangle(name + "_east", paint, lo + x, y, z);
    return rectangle(name + "_top", paint, lo + z, x, y);
  }

  GeneratedModel take() { return std::move(model_); }

 private:
  GeneratedModel model_;
};

// E's luminance at a point, lx.
inline double illuminance(SolvedRun& run, const Probe& p) {
  const std::optional<SurfaceSample> s = run.at(p);
  EXPECT_TRUE(s.has_value()) << "no surface at " << p.x.x << " " << p.x.y << " " << p.x.z;
  return s ? luminance(s->irradiance) : -1;
}

// ∫ E dA over all patches that are not inert, and ∫ (1-ρ) E dA, luminance, lm.
struct Balance {
  double area = 0, arrived = 0, absorbed = 0, emitted = 0;
};
inline Balance balance(SolvedRun& run) {
  Balance b;
  const Status s = run.solution().for_each_cluster([&](ClusterId, const ClusterView& view) {
    for (std::size_t p = 0; p < view.size(); ++p) {
      const PatchHead& h = view.patch_head(p);
      if (h.inert) continue;
      const std::span<const double> root = view.patch(p).e_of(0);
      const Spectrum e{root[0], root[1], root[2]};
      b.area += h.area;
      b.arrived += h.area * luminance(e);
      b.absorbed += h.area * luminance((Spectrum{1} - h.reflectance) * e);
      b.emitted += h.area * luminance(h.exitance);
    }
  });
  EXPECT_TRUE(s.ok()) << s.message();
  return b;
}

}  // namespace atrium::testing
