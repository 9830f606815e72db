#include "apps/report_json.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace atrium {
namespace {

using Json = nlohmann::ordered_json;

// Names may hold bytes that are no UTF-8: they are replaced rather than refused.
std::string document(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json number_or_null(double x) { return std::isnan(x) ? Json() : Json(x); }

Json known_or_null(double x) { return x < 0 ? Json() : Json(x); }

Json triple(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }

template <class Tag>
Json id_number(const Id<Tag>& id) {
  return id.valid() ? Json(id.value) : Json(-1);
}

Json left_out_json(const std::vector<LeftOut>& left_out) {
  Json rows = Json::array();
  for (const LeftOut& l : left_out) rows.push_back({{"feature", l.feature}, {"why", l.why}});
  return rows;
}

Json warm_json(const std::optional<WarmFigures>& f) {
  if (!f) return nullptr;
  return {{"patches_kept", f->patches_kept},
          {"elements_kept", f->elements_kept},
          {"clusters_changed", f->clusters_changed},
          {"clusters_reached", f->clusters_reached}};
}

Json gaps_json(const std::vector<NamedGap>& gaps) {
  Json rows = Json::array();
  for (const NamedGap& g : gaps)
    rows.push_back(
        {{"width", g.width}, {"length", g.length}, {"objects", g.objects}, {"at", triple(g.at)}});
  return rows;
}

// Counts of an arena that is too small are null.
Json simulation_row(const Simulation& s) {
  Json row{{"policy", s.policy}, {"arena", s.arena}};
  for (const NamedCount& c : kSimulationCounts)
    row[c.name] = s.feasible ? Json(s.*c.count) : Json();
  row["min_feasible_arena"] = s.min_feasible_arena;
  row["seconds"] = s.feasible ? Json(s.seconds) : Json();
  row["feasible"] = s.feasible;
  return row;
}

// What is no number is null.
Json suite_json(const Validation& v) {
  Json cases = Json::array();
  for (const ValidationCase& c : v.cases)
    cases.push_back({{"case", c.name},
                     {"expected", c.expected},
                     {"found", c.found},
                     {"difference", c.difference()},
                     {"allowed", c.allowed},
                     {"pass", c.pass}});
  Json report{{"suite", v.suite}, {"pass", v.pass()}, {"cases", cases}};
  for (const auto& [name, value] : v.figures) report[name] = value;
  report["examples"] = v.examples;
  return report;
}

// Under the names that the summary has for what happened.
Json estimate_json(const CostEstimate& e) {
  return {{"elements", e.elements},
          {"links", e.links},
          {"peak_rss_bytes", e.memory_bytes},
          {"file_bytes", e.disk_bytes},
          {"cpu_seconds", e.cpu_seconds}};
}

}  // namespace

std::string generated_json(const std::string& file, std::uint64_t clusters, std::uint64_t patches,
                           std::uint64_t lights) {
  return document(
      {{"file", file}, {"clusters", clusters}, {"patches", patches}, {"lights", lights}});
}

std::string scene_json(const SceneReport& r) {
  Json materials = Json::array(), warnings = Json::array();
  for (const MaterialReport& m : r.materials)
    materials.push_back({{"name", m.name},
                         {"faces", m.faces},
                         {"area", m.area},
                         {"reflectance", triple(m.reflectance)},
                         {"lumens", m.lumens}});
  for (const Warning& w : r.warnings)
    warnings.push_back({{"what", w.what}, {"count", w.count}, {"examples", w.examples}});
  Json bounds;
  if (!r.bounds.empty()) bounds = Json{{"min", triple(r.bounds.lo)}, {"max", triple(r.bounds.hi)}};
  return document({{"files", r.files},
                   {"polygons", r.polygons},
                   {"patches", r.patches},
                   {"clusters", r.clusters},
                   {"lights", r.lights},
                   {"materials", materials},
                   {"bounds", bounds},
                   {"area", r.area},
                   {"lumens", r.lumens},
                   {"warnings", warnings}});
}

std::string leaks_json(const std::vector<LeakRow>& leaks) {
  Json rows = Json::array();
  for (const LeakRow& l : leaks) {
    Json rooms = Json::array();
    for (const std::string& r : l.rooms)
      rooms.push_back(r == "outdoors" ? Json(r) : Json(std::stoul(r)));
    rows.push_back({{"width", l.width},
                    {"length", l.length},
                    {"rooms", rooms},
                    {"objects", l.objects},
                    {"at", triple(l.at)},
                    {"along", triple(l.along)}});
  }
  return document({{"leaks", rows}});
}

std::string run_json(const Model& model) {
  return document({{"patches", model.patches.size()},
                   {"clusters", model.clusters.size()},
                   {"cells", model.cells.size()},
                   {"portals", model.portals.size()}});
}

std::string listed(const std::string& json) {
  constexpr std::size_t kColumn = 28;
  std::string lines;
  const Json fields = Json::parse(json, nullptr, false);
  if (!fields.is_object()) return json;
  for (const auto& [name, value] : fields.items()) {
    const std::size_t gap = name.size() < kColumn ? kColumn - name.size() : 1;
    lines += name + std::string(gap, ' ') +
             (value.is_string() ? value.get<std::string>() : value.dump()) + "\n";
  }
  return lines;
}

std::string status_json(const RunLook& look) {
  const RunStatus s = look.page.value_or(RunStatus{});
  const bool ended = look.life == RunLife::kEnded;
  const auto since = seconds_since_checkpoint(s);
  return Json{{"state", to_string(look.life)},
              {"process", look.process ? Json(*look.process) : Json()},
              {"iteration", s.iteration},
              {"clusters_gathered", s.gathered},
              {"clusters", s.clusters},
              {"elements", s.elements},
              {"links", s.links},
              {"seconds", s.seconds},
              {"residual", known_or_null(s.residual)},
              {"hit_ratio", known_or_null(s.hit_ratio)},
              {"checkpoints", s.checkpoints},
              {"seconds_since_checkpoint", since ? Json(*since) : Json()},
              {"peak_rss_bytes", s.peak_rss_bytes},
              {"exit_code", ended ? Json(s.exit_code) : Json()},
              {"stop_reason", ended ? Json(look.stop_reason) : Json()}}
      .dump();
}

std::string check_json(const RunCheck& c) {
  Json records = Json::object();
  for (const CheckedRecords& r : c.records)
    records[r.kind] = {{"count", r.count}, {"bytes", r.bytes}};
  return document({{"ok", true},
                   {"begun", c.begun},
                   {"epoch", c.epoch},
                   {"roots", c.roots},
                   {"records", records},
                   {"summed_bytes", c.summed_bytes},
                   {"unsummed_bytes", c.unsummed_bytes}});
}

Result<std::string> stop_reason(const std::string& summary, const std::string& path) {
  const Json fields = Json::parse(summary, nullptr, false);
  if (fields.is_object() && fields.contains("stop_reason") && fields["stop_reason"].is_string())
    return fields["stop_reason"].get<std::string>();
  return Status(Code::kStore, path, "stop_reason", "it is not there",
                "run atrium check on the run");
}

std::string plan_json(const Plan& plan) {
  return document({{"patches", plan.patches},
                   {"clusters", plan.clusters},
                   {"cells", plan.cells},
                   {"portals", plan.portals},
                   {"rooms", plan.rooms},
                   {"lights", plan.lights},
                   {"visible_share", plan.visible_share},
                   {"memory", plan.memory},
                   {"arena", plan.arena},
                   {"smallest_memory", plan.smallest_memory},
                   {"smallest_arena", plan.smallest_arena},
                   {"disk", plan.estimated.disk_bytes},
                   {"smallest_disk", plan.smallest_disk},
                   {"estimated", estimate_json(plan.estimated)},
                   {"mean_irradiance_guess", plan.mean_irradiance_guess},
                   {"min_edge", plan.min_edge},
                   {"warm", warm_json(plan.warm)},
                   {"left_out", left_out_json(plan.left_out)},
                   {"closed_gaps", gaps_json(plan.closed_gaps)},
                   {"warnings", plan.warnings}});
}

std::string form_factor_json(double f12, double f21, double a1, double a2) {
  return document({{"F12", number_or_null(f12)},
                   {"F21", number_or_null(f21)},
                   {"A1", number_or_null(a1)},
                   {"A2", number_or_null(a2)}});
}

std::string probe_json(const std::vector<ProbePoint>& points,
                       const std::vector<ProbeAnswer>& answers) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ProbeAnswer& a = answers[i];
    rows.push_back({{"point", triple(points[i].x)},
                    {"normal", triple(points[i].normal)},
                    {"E", triple(a.irradiance)},
                    {"B", a.radiosity ? triple(*a.radiosity) : Json()},
                    {"cluster", id_number(a.cluster)},
                    {"cell", id_number(a.cell)}});
  }
  return document({{"points", rows}});
}

std::string reference_json(const ReferenceFigures& f) {
  return document({{"points", f.points},
                   {"paths", f.paths},
                   {"rays", f.rays},
                   {"seconds", f.seconds},
                   {"cpu_seconds", f.cpu_seconds},
                   {"noise", f.noise}});
}

std::string picture_json(const std::string& file, int width, int height,
                         std::optional<double> exposure_ev) {
  return document({{"file", file},
                   {"width", width},
                   {"height", height},
                   {"exposure", exposure_ev ? Json(*exposure_ev) : Json()}});
}

std::string export_json(const std::string& file, std::uint64_t bytes, std::uint64_t vertices,
                        std::uint64_t faces) {
  return document({{"file", file}, {"bytes", bytes}, {"vertices", vertices}, {"faces", faces}});
}

std::string page_json(const std::string& file, std::uint64_t bytes,
                      const std::vector<std::string>& runs) {
  return document({{"file", file}, {"bytes", bytes}, {"runs", runs}});
}

std::string trace_info_json(const TraceInfo& i) {
  return document({{"file", i.file},
                   {"format", i.format},
                   {"pins", i.pins},
                   {"complete", i.complete},
                   {"left_over", i.left_over},
                   {"requests", i.requests},
                   {"records", i.records},
                   {"bytes", i.bytes},
                   {"unique_bytes", i.unique_bytes},
                   {"dirties", i.dirties},
                   {"creates", i.creates},
                   {"gathers", i.gathers},
                   {"iterations", i.iterations},
                   {"checkpoints", i.checkpoints},
                   {"grown_records", i.grown_records},
                   {"growth", i.growth},
                   {"smallest_arena", i.smallest_arena}});
}

std::string conversion_json(const std::string& file, const std::string& format,
                            std::uint64_t requests, const std::vector<std::string>& lost) {
  return document({{"file", file}, {"format", format}, {"requests", requests}, {"lost", lost}});
}

std::string simulation_json(const SimulationTable& table) {
  Json rows = Json::array(), bounds = Json::array(), bytes = Json::array();
  for (const Simulation& s : table.rows) rows.push_back(simulation_row(s));
  for (const std::optional<double>& b : table.bounds) bounds.push_back(b ? Json(*b) : Json());
  for (const std::optional<LeastBytes>& b : table.bytes)
    bytes.push_back(b ? Json{{"in_this_order", b->in_this_order}, {"in_any_order", b->in_any_order}}
                      : Json());
  return document({{"rows", rows},
                   {"lower_bound_misses", bounds},
                   {"lower_bound_bytes", bytes},
                   {"unit_size", table.unit_size}});
}

std::string curve_json(const MissCurve& curve) {
  Json points = Json::array();
  for (const CurvePoint& p : curve.points)
    points.push_back({{"arena", p.arena},
                      {"misses", p.misses},
                      {"miss_ratio", miss_ratio(p.misses, curve.requests)},
                      {"miss_bytes", p.miss_bytes},
                      {"writebacks", p.writebacks},
                      {"writeback_bytes", p.writeback_bytes},
                      {"final_flush", p.final_flush}});
  return document({{"policy", curve.policy},
                   {"requests", curve.requests},
                   {"smallest_arena", curve.smallest_arena},
                   {"sample", curve.sample},
                   {"points", points}});
}

std::string replay_json(const Simulation& simulated, const Replay& replayed) {
  return document({{"simulated", simulation_row(simulated)},
                   {"replayed", simulation_row(replayed.counts)},
                   {"differ", differing_counts(simulated, replayed.counts)},
                   {"fragmentation_evictions", replayed.fragmentation_evictions},
                   {"io_seconds", replayed.io_seconds}});
}

std::string validation_json(const Validation& v) { return document(suite_json(v)); }

std::string validations_json(const std::vector<Validation>& all) {
  Json suites = Json::array();
  bool pass = true;
  for (const Validation& v : all) {
    suites.push_back(suite_json(v));
    pass = pass && v.pass();
  }
  return document({{"pass", pass}, {"suites", suites}});
}

}  // namespace atrium
