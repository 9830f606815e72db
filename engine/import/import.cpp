#include "engine/import/import.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>

#include "engine/import/assign.h"
#include "engine/import/materials.h"
#include "engine/import/mesh.h"
#include "engine/import/name_pattern.h"
#include "engine/import/overlap.h"
#include "engine/import/raw_model.h"
#include "engine/import/read_gltf.h"
#include "engine/import/read_obj.h"
#include "engine/import/rejoin.h"
#include "engine/import/sides.h"
#include "engine/import/topology.h"

namespace atrium {
namespace {

// Coordinates far from zero carry this many units of rounding; less than that is no length.
constexpr double kRoundingUlps = 16;

Status check(const ImportOptions& options) {
  const auto refused = [](const std::string& cause, const std::string& remedy) {
    return Status(Code::kUsage, "", "", cause, remedy);
  };
  if (options.files.empty()) return refused("no scene file is named", "name one or more");
  if (!(options.unit > 0 && std::isfinite(options.unit)))
    return refused("the unit is not a positive length", "write --unit m, cm, mm, ft or in");
  if (!(options.white >= 0 && options.white < 1))
    return refused("--white is not within 0 to below 1", "write 0.9");
  return {};
}

Status read_file(const std::string& path, RawModel& model, WarningLog& warnings) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (extension == ".obj") return read_obj(path, model, warnings);
  if (extension == ".gltf" || extension == ".glb") return read_gltf(path, model, warnings);
  return Status(Code::kScene, path, "", "is neither .obj nor .gltf nor .glb",
                "convert it to one of these");
}

// By object: is it left out, by --drop or by the assign file?
Result<std::vector<bool>> dropped_objects(const RawModel& model, const ImportOptions& options,
                                          const Assignment& assignment, WarningLog& warnings) {
  std::vector<bool> dropped(model.objects.size(), false);
  const auto drop = [&](const std::string& pattern, const auto& matches) {
    bool any = false;
    for (std::size_t o = 0; o < dropped.size(); ++o) {
      if (!matches(model.objects[o].name)) continue;
      any = dropped[o] = true;
      warnings.add("objects dropped as asked", "'" + model.objects[o].name + "'");
    }
    if (!any) warnings.add("patterns to drop that match no object", "'" + pattern + "'");
  };
  for (const std::string& text : options.drop) {
    const Result<NamePattern> pattern = NamePattern::compile(text);
    if (!pattern.ok()) return pattern.status();
    drop(text, [&](const std::string& name) { return pattern->found_in(name); });
  }
  for (const std::string& glob : assignment.dropped_objects)
    drop(glob, [&](const std::string& name) { return glob_matches(glob, name); });
  return dropped;
}

// By face: does it count? Dropped objects' faces and clear glass do not.
std::vector<bool> kept_faces(const RawModel& model, const std::vector<bool>& dropped) {
  std::vector<bool> kept(model.faces.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const RawFace& f = model.faces[i];
    kept[i] = !dropped[f.object] && !is_clear(model.materials[f.material]);
  }
  return kept;
}

// Near zero the internal origin is the files' own; far from it a round point of the scene, so that
// positions keep their digits.
SceneFrame frame_of_bounds(const Box& box, double unit) {
  SceneFrame frame;
  frame.unit = unit;
  const double step = std::exp2(std::ceil(std::log2(box.diagonal())));
  for (int k = 0; k < 3; ++k) frame.origin[k] = step * std::round(box.center()[k] / step);
  return frame;
}

Box bounds_in_metres(const RawModel& model, const std::vector<bool>& kept, double unit) {
  Box box;
  for (std::size_t i = 0; i < kept.size(); ++i)
    if (kept[i])
      for (const std::uint32_t v : model.corners_of(model.faces[i]))
        box.extend(model.vertices[v] * unit);
  return box;
}

double tolerance_of(const Box& box) {
  double largest = 0;
  for (int k = 0; k < 3; ++k)
    largest = std::max({largest, std::abs(box.lo[k]), std::abs(box.hi[k])});
  return std::max(kToleranceOfDiagonal * box.diagonal(),
                  kRoundingUlps * std::numeric_limits<double>::epsilon() * largest);
}

class Importer {
 public:
  explicit Importer(const ImportOptions& options) : options_(options) {}

  Result<Scene> run() {
    ATRIUM_RETURN_IF_ERROR(check(options_));
    Assignment assignment;
    if (!options_.assign_file.empty()) {
      Result<Assignment> read = read_assignment(options_.assign_file);
      if (!read.ok()) return read.status();
      assignment = std::move(*read);
    }
    for (const std::string& file : options_.files)
      ATRIUM_RETURN_IF_ERROR(read_file(file, model_, warnings_));
    default_materials(model_, warnings_);
    assign_materials(assignment, model_, warnings_);
    const Result<std::vector<bool>> dropped =
        dropped_objects(model_, options_, assignment, warnings_);
    if (!dropped.ok()) return dropped.status();
    return build(kept_faces(model_, *dropped), *dropped);
  }

 private:
  Result<Scene> build(const std::vector<bool>& kept, const std::vector<bool>& dropped) {
    Result<std::vector<Material>> materials =
        physical_materials(model_, used_materials(dropped), options_, warnings_);
    if (!materials.ok()) return materials.status();
    const Box box = bounds_in_metres(model_, kept, options_.unit);
    if (!(box.diagonal() > 0) || !std::isfinite(box.diagonal()))
      return Status(Code::kScene, options_.files[0], "", "no faces with any extent are left",
                    "check the file, --drop and what is clear glass");
    scene_.files = model_.files;
    scene_.frame = frame_of_bounds(box, options_.unit);
    scene_.tolerance = tolerance_of(box);
    scene_.materials = std::move(*materials);
    Mesh mesh =
        make_mesh(model_, kept, scene_.frame, scene_.tolerance, scene_.materials, warnings_);
    if (mesh.faces.empty())
      return Status(Code::kScene, options_.files[0], "", "all faces are degenerate",
                    "check the file");
    split_unnamed_objects(model_, mesh);
    surfaces_of(mesh);
    count();
    return std::move(scene_);
  }

  std::vector<bool> used_materials(const std::vector<bool>& dropped) const {
    std::vector<bool> used(model_.materials.size(), false);
    for (const RawFace& f : model_.faces)
      if (!dropped[f.object]) used[f.material] = true;
    return used;
  }

  void surfaces_of(Mesh& mesh) {
    const auto by_object = faces_by_object(mesh, model_.objects.size());
    std::vector<Ring> rings = rings_of(mesh);
    for (const std::vector<std::uint32_t>& faces : by_object) enter_junctions(mesh, faces, rings);
    decide_sides(mesh, rings, by_object, model_, scene_.materials, options_.sides, warnings_);
    const std::vector<PatchRing> patches = rejoin(mesh, rings, model_, warnings_);
    resolve_overlaps(mesh, patches, model_, scene_, warnings_);
  }

  void count() {
    for (const RawObject& o : model_.objects) scene_.objects.push_back({o.name, o.file});
    scene_.polygons = model_.faces.size();
    scene_.faces_of_material.assign(scene_.materials.size(), 0);
    for (const RawFace& f : model_.faces) ++scene_.faces_of_material[f.material];
    for (const Surface& s : scene_.surfaces) scene_.bounds.extend(bounds(scene_.polygon(s)));
    scene_.warnings = warnings_.take();
  }

  const ImportOptions& options_;
  RawModel model_;
  WarningLog warnings_;
  Scene scene_;
};

}  // namespace

Result<Scene> import_scene(const ImportOptions& options) { return Importer(options).run(); }

}  // namespace atrium
