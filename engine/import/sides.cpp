#include "engine/import/sides.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "engine/import/topology.h"

namespace atrium {
namespace {

// How far before a face, in tolerances, it is asked which shell encloses it.
constexpr double kBefore = 10;
// Winding numbers of closed shells are whole; halfway is on the shell.
constexpr double kInside = 0.75;

const char* const kSolids = "sides: closed solids, their outside counts";
const char* const kRooms = "sides: closed shells facing inwards, their inside counts";
const char* const kInsideOut = "sides: closed solids inside out, both sides count";
const char* const kLampWithin = "sides: closed shells with a lamp within, both sides count";
const char* const kSheets = "sides: open sheets, both sides count";
const char* const kTogether = "sides: sheets that together close a shell, their front counts";

// A closed shell: some faces with their volume, positive if they face outwards.
struct Shell {
  std::vector<std::uint32_t> faces;
  double volume = 0;
  Box box;
};

class SidesDecision {
 public:
  SidesDecision(Mesh& mesh, const RawModel& model, const std::vector<Material>& materials,
                WarningLog& warnings)
      : mesh_(mesh), model_(model), materials_(materials), warnings_(warnings) {}

  void decide(const std::vector<Ring>& rings,
              const std::vector<std::vector<std::uint32_t>>& by_object) {
    find_lamps(by_object);
    std::vector<std::uint32_t> open;
    for (std::uint32_t o = 0; o < by_object.size(); ++o) {
      if (by_object[o].empty()) continue;
      const std::vector<Shell> shells = closed_shells(by_object[o], rings, open);
      if (!shells.empty()) decide_shells(shells, o);
    }
    decide_open(open, rings_of(mesh_));
  }

 private:
  struct Lamp {
    Vec3 before{0};  // a point just before its face
    std::uint32_t object = 0;
  };

  void find_lamps(const std::vector<std::vector<std::uint32_t>>& by_object) {
    Polygon scratch;
    boxes_.resize(by_object.size());
    before_.resize(by_object.size());
    for (std::uint32_t o = 0; o < by_object.size(); ++o) {
      bool lit = false;
      for (const std::uint32_t i : by_object[o]) {
        const Face& f = mesh_.faces[i];
        mesh_.polygon(mesh_.corners_of(f), scratch);
        boxes_[o].extend(bounds(scratch));
        const bool lamp = !lit && materials_[f.material.value].emits();
        if (!lamp && i != by_object[o].front()) continue;
        const Vec3 before = centroid(scratch) + kBefore * mesh_.tolerance * f.plane.normal;
        if (i == by_object[o].front()) before_[o] = before;
        if (lamp) lamps_.push_back({before, o});
        lit |= lamp;
      }
      whole_.extend(boxes_[o]);
    }
  }

  // The closed components among the faces; the others' faces go to `open`.
  std::vector<Shell> closed_shells(const std::vector<std::uint32_t>& faces,
                                   const std::vector<Ring>& rings,
                                   std::vector<std::uint32_t>& open) const {
    const EdgeTable edges(faces, rings);
    const std::vector<std::uint32_t> component = components(faces, edges);
    const std::vector<bool> closed = balanced(faces, component, edges);
    std::vector<Shell> all(closed.size());
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (closed[component[i]])
        all[component[i]].faces.push_back(faces[i]);
      else
        open.push_back(faces[i]);
    }
    std::vector<Shell> shells;
    for (Shell& s : all)
      if (!s.faces.empty()) {
        measure(s);
        shells.push_back(std::move(s));
      }
    return shells;
  }

  void measure(Shell& shell) const {
    Polygon scratch;
    const Vec3 origin = mesh_.vertices[mesh_.corners[mesh_.faces[shell.faces[0]].first_corner]];
    for (const std::uint32_t i : shell.faces) {
      mesh_.polygon(mesh_.corners_of(mesh_.faces[i]), scratch);
      shell.box.extend(bounds(scratch));
      shell.volume += dot(area_vector(scratch), scratch[0] - origin) / 6;
    }
  }

  void decide_shells(const std::vector<Shell>& shells, std::uint32_t object) {
    double volume = 0;
    for (const Shell& s : shells) volume += s.volume;
    const std::vector<bool> holds_lamp = lamps_within(shells, object);
    for (std::size_t i = 0; i < shells.size(); ++i) {
      const Shell& s = shells[i];
      if (holds_lamp[i])
        set(s.faces, kBothSides, kLampWithin);
      else if (s.volume >= 0 || volume > 0)  // the hollow of a solid faces inwards rightly
        set(s.faces, kFront, kSolids);
      else if (is_room(s, object))
        set(s.faces, kFront, kRooms);
      else
        set(s.faces, kBothSides, kInsideOut);
    }
  }

  // A shell that faces inwards is a room if an object stands in it, or if it holds everything.
  bool is_room(const Shell& shell, std::uint32_t object) const {
    if (shell.box.contains(whole_.lo, mesh_.tolerance) &&
        shell.box.contains(whole_.hi, mesh_.tolerance))
      return true;
    for (std::uint32_t o = 0; o < boxes_.size(); ++o)
      if (o != object && !boxes_[o].empty() && shell.box.contains(before_[o]) &&
          winding_number(shell, before_[o]) < -kInside)
        return true;
    return false;
  }

  // Which of these shells have another object's lamp inside the solids they bound? A lamp in a
  // hollow is not: there the hollow's shell takes back what the outer one encloses.
  std::vector<bool> lamps_within(const std::vector<Shell>& shells, std::uint32_t object) const {
    std::vector<bool> holds(shells.size(), false);
    std::vector<double> winding(shells.size());
    for (const Lamp& lamp : lamps_) {
      if (lamp.object == object) continue;
      double sum = 0;
      for (std::size_t i = 0; i < shells.size(); ++i) {
        const bool near = shells[i].box.contains(lamp.before);
        sum += winding[i] = near ? winding_number(shells[i], lamp.before) : 0;
      }
      if (sum <= kInside) continue;
      for (std::size_t i = 0; i < shells.size(); ++i)
        if (winding[i] > kInside) holds[i] = true;
    }
    return holds;
  }

  // How often the shell goes round the point: its solid angle over 4π. [van Oosterom 1983]
  double winding_number(const Shell& shell, const Vec3& x) const {
    double solid = 0;
    for (const std::uint32_t i : shell.faces) {
      const auto ring = mesh_.corners_of(mesh_.faces[i]);
      const Vec3 a = mesh_.vertices[ring[0]] - x;
      for (std::size_t k = 2; k < ring.size(); ++k) {
        const Vec3 b = mesh_.vertices[ring[k - 1]] - x, c = mesh_.vertices[ring[k]] - x;
        const double la = length(a), lb = length(b), lc = length(c);
        const double cosine = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
        solid += 2 * std::atan2(dot(a, cross(b, c)), cosine);
      }
    }
    return solid / (4 * std::numbers::pi);
  }

  // Sheets that close no shell by themselves may do so together: a room modelled wall by wall.
  void decide_open(const std::vector<std::uint32_t>& open, std::vector<Ring> rings) {
    if (open.empty()) return;
    enter_junctions(mesh_, open, rings);
    std::vector<std::uint32_t> sheets;
    const std::uint32_t nobody = static_cast<std::uint32_t>(boxes_.size());
    for (const Shell& s : closed_shells(open, rings, sheets)) {
      if (lamps_within({s}, nobody)[0])
        set(s.faces, kBothSides, kLampWithin);
      else if (s.volume >= 0 || is_room(s, nobody))
        set(s.faces, kFront, kTogether);
      else
        set(s.faces, kBothSides, kInsideOut);
    }
    set(sheets, kBothSides, kSheets);
  }

  void set(const std::vector<std::uint32_t>& faces, Sides sides, const char* why) {
    for (const std::uint32_t i : faces) {
      mesh_.faces[i].sides = sides;
      warnings_.add(why, "'" + model_.objects[mesh_.faces[i].object.value].name + "'");
    }
  }

  Mesh& mesh_;
  const RawModel& model_;
  const std::vector<Material>& materials_;
  WarningLog& warnings_;
  std::vector<Lamp> lamps_;
  std::vector<Box> boxes_;    // by object
  std::vector<Vec3> before_;  // by object: a point just before its first face
  Box whole_;
};

}  // namespace

void decide_sides(Mesh& mesh, const std::vector<Ring>& rings,
                  const std::vector<std::vector<std::uint32_t>>& by_object, const RawModel& model,
                  const std::vector<Material>& materials, SidesChoice choice,
                  WarningLog& warnings) {
  if (choice == SidesChoice::kAuto) {
    SidesDecision(mesh, model, materials, warnings).decide(rings, by_object);
  } else {
    for (Face& f : mesh.faces) f.sides = choice == SidesChoice::kTwo ? kBothSides : kFront;
  }
  for (Face& f : mesh.faces) {
    const RawMaterial& m = model.materials[f.material.value];
    if (m.sides)
      f.sides = *m.sides;
    else if (m.double_sided && choice == SidesChoice::kAuto)
      f.sides = kBothSides;
  }
}

}  // namespace atrium
