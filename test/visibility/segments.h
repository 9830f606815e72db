// The global oracle's judge: random segments between lit patches, tested against every surface.
// What a free segment joins, and what a blocked one meets first, must be in the oracle's rows.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <sstream>
#include <string>

#include "engine/model.h"
#include "engine/scene.h"
#include "visibility/box_tree.h"
#include "visibility/contact.h"

namespace atrium {

struct SegmentReport {
  std::size_t joined = 0, blocked = 0;
  std::size_t missed = 0;  // clusters that a segment witnesses and a row lacks
  std::string first;       // the first of them, in words
};

class SegmentJudge {
 public:
  SegmentJudge(const Scene& scene, const Model& model, std::uint64_t seed)
      : scene_(scene), model_(model), tree_(surface_tree(scene)), rng_(seed) {
    for (const Surface& s : scene.surfaces) planes_.push_back(plane_of(scene.polygon(s)));
    near_ = 1e-5 * scene.bounds.diagonal();
    double sum = 0;
    for (const Patch& p : model.patches) {
      sum += p.inert ? 0 : area(model.polygon(p));
      areas_.push_back(sum);
    }
    patches_of_.resize(scene.surfaces.size());
    for (std::uint32_t p = 0; p < model.patches.size(); ++p)
      patches_of_[model.patches[p].surface.value].push_back(p);
  }

  SegmentReport run(std::size_t segments) {
    SegmentReport report;
    while (segments-- > 0) {
      const std::uint32_t p = pick(), q = pick();
      const Vec3 x = point_on(p), y = point_on(q);
      const Plane px = plane(p), py = plane(q);
      if (px.distance(y) <= near_ || py.distance(x) <= near_) continue;
      if (crowded(x) || crowded(y)) continue;
      const Hit hit = first_hit(x, y);
      if (hit.surface == kNothing) {
        ++report.joined;
        expect(p, model_.patches[q].cluster, x, y, report);
        expect(q, model_.patches[p].cluster, y, x, report);
      } else {
        ++report.blocked;
        expect_blocker(p, hit, x, y, report);
      }
    }
    return report;
  }

 private:
  static constexpr std::uint32_t kNothing = ~0u;
  struct Hit {
    std::uint32_t surface = kNothing;
    double t = 1;
  };

  double uniform() { return std::uniform_real_distribution<double>(0, 1)(rng_); }

  std::uint32_t pick() {
    const auto at = std::upper_bound(areas_.begin(), areas_.end(), uniform() * areas_.back());
    return static_cast<std::uint32_t>(std::min(at, areas_.end() - 1) - areas_.begin());
  }

  Plane plane(std::uint32_t patch) const { return plane_of(model_.polygon(model_.patches[patch])); }

  Vec3 point_on(std::uint32_t patch) {
    const PolygonView polygon = model_.polygon(model_.patches[patch]);
    double left = uniform() * area(polygon);
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      const Vec3 u = polygon[i - 1] - polygon[0], v = polygon[i] - polygon[0];
      const double a = 0.5 * length(cross(u, v));
      if (left > a && i + 1 < polygon.size()) {
        left -= a;
        continue;
      }
      double s = uniform(), t = uniform();
      if (s + t > 1) s = 1 - s, t = 1 - t;
      return polygon[0] + s * u + t * v;
    }
    return polygon[0];
  }

  // Near more than one surface nobody can say on which side a point lies.
  bool crowded(const Vec3& x) const {
    Box box;
    box.extend(x - Vec3{near_});
    box.extend(x + Vec3{near_});
    int faces = 0;
    tree_.visit(box, [&](std::uint32_t i) {
      faces += std::abs(planes_[i].distance(x)) <= near_ &&
               contains(scene_.polygon(scene_.surfaces[i]), planes_[i].normal, x, near_);
    });
    return faces > 1;
  }

  Hit first_hit(const Vec3& x, const Vec3& y) const {
    const double l = length(y - x), margin = near_ / l;
    Hit hit;
    hit.t = 1 - margin;
    Box box;
    box.extend(x);
    box.extend(y);
    tree_.visit(box, [&](std::uint32_t i) {
      const double a = planes_[i].distance(x), b = planes_[i].distance(y);
      if ((a > 0) == (b > 0)) return;
      const double t = a / (a - b);
      if (t <= margin || t >= hit.t) return;
      if (contains(scene_.polygon(scene_.surfaces[i]), planes_[i].normal, x + t * (y - x), 0))
        hit = {i, t};
    });
    return hit;
  }

  bool listed(std::uint32_t patch, ClusterId other) const {
    const auto row = model_.visible[model_.patches[patch].cluster.value];
    return std::binary_search(row.begin(), row.end(), other);
  }

  void expect(std::uint32_t patch, ClusterId other, const Vec3& x, const Vec3& y,
              SegmentReport& report) const {
    if (!listed(patch, other)) miss("joins", patch, x, y, report);
  }

  // Some patch that lies where the segment is blocked is listed; patches block from both sides.
  void expect_blocker(std::uint32_t patch, const Hit& hit, const Vec3& x, const Vec3& y,
                      SegmentReport& report) const {
    const Vec3 z = x + hit.t * (y - x);
    Box box;
    box.extend(z - Vec3{near_});
    box.extend(z + Vec3{near_});
    bool found = false;
    tree_.visit(box, [&](std::uint32_t i) {
      for (std::uint32_t q : patches_of_[i]) {
        const Patch& other = model_.patches[q];
        const Plane facing = plane(q);
        found |= std::abs(facing.distance(z)) <= near_ &&
                 contains(model_.polygon(other), facing.normal, z, near_) &&
                 listed(patch, other.cluster);
      }
    });
    if (!found) miss("is blocked", patch, x, y, report);
  }

  void miss(const char* what, std::uint32_t patch, const Vec3& x, const Vec3& y,
            SegmentReport& report) const {
    if (report.missed++ > 0) return;
    std::ostringstream text;
    text.precision(17);
    text << "cluster " << model_.patches[patch].cluster.value << " " << what << ": " << x.x << " "
         << x.y << " " << x.z << " -> " << y.x << " " << y.y << " " << y.z;
    report.first = text.str();
  }

  const Scene& scene_;
  const Model& model_;
  BoxTree tree_;
  std::mt19937_64 rng_;
  std::vector<Plane> planes_;
  std::vector<double> areas_;
  std::vector<std::vector<std::uint32_t>> patches_of_;
  double near_ = 0;
};

inline SegmentReport shoot_segments(const Scene& scene, const Model& model, std::size_t segments,
                                    std::uint64_t seed) {
  return SegmentJudge(scene, model, seed).run(segments);
}

}  // namespace atrium
