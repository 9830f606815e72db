#include "scheduler/history.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

namespace atrium {

namespace {

using Json = nlohmann::ordered_json;

std::string quoted(const std::string& s) { return Json(s).dump(); }

std::string list(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& s : items) text += (text.empty() ? "" : ", ") + quoted(s);
  return "[" + text + "]";
}

// A run can be resumed from anywhere.
std::string absolute(const std::string& path) {
  return path.empty() ? path : std::filesystem::absolute(path).lexically_normal().string();
}

const char* name(SidesChoice s) {
  return s == SidesChoice::kAuto ? "auto" : s == SidesChoice::kOne ? "one" : "two";
}

// What looking through tubes saved. The yardstick, `rays_untubed`, is what the same pairs would
// have taken without: sixteen rays for every pair looked at closely, be it split, linked or dropped
// after, and one for every thin one, which gets no more here either.
Json visibility_json(const RefineCounters& c) {
  constexpr std::uint64_t kRaysALink = 16;
  const auto share = [](std::uint64_t part, std::uint64_t whole) {
    return whole > 0 ? double(part) / double(whole) : 0.0;
  };
  Json j;
  j["pairs"] = c.kernels;
  j["pairs_visible"] = c.tubes_visible;
  j["pairs_invisible"] = c.tubes_invisible;
  j["pairs_partial"] = c.tubes_partial;
  j["thin_pairs"] = c.thin_pairs;
  j["rays"] = c.rays;
  j["rays_of_thin_pairs"] = c.thin_rays;
  j["rays_untubed"] = kRaysALink * c.kernels + c.thin_pairs;
  j["rays_a_partial_pair"] = share(c.rays - c.thin_rays, c.tubes_partial);
  j["links_made"] = c.links;
  j["links_without_rays"] = share(c.links_without_rays, c.links);
  return j;
}

void put_estimate(const ErrorEstimate& e, Json& j) {
  if (e.points == 0) {  // none was made
    j["error_estimate"] = nullptr;
    return;
  }
  j["error_estimate"] = e.error;
  j["error_estimate_low"] = e.low;
  j["error_estimate_high"] = e.high;
  j["energy_closure"] = e.closure - 1;
}

// What became of links between iterations.
Json links_json(const SolveSummary& s) {
  const auto part = [](std::uint64_t clusters, std::uint64_t bytes) {
    return Json{{"clusters", clusters}, {"bytes", bytes}};
  };
  const LinksKept& k = s.links_kept;
  Json j;
  j["in_memory"] = part(k.in_memory, k.in_memory_bytes);
  j["streamed"] = part(k.streamed, k.streamed_bytes);
  return j;
}

// What the plan thought it would take; what it took is beside it under the same names.
Json estimate_json(const CostEstimate& e) {
  Json j;
  j["elements"] = e.elements;
  j["links"] = e.links;
  j["peak_rss_bytes"] = e.memory_bytes;
  j["file_bytes"] = e.disk_bytes;
  j["cpu_seconds"] = e.cpu_seconds;
  return j;
}

}  // namespace

std::string program_version() { return "atrium " ATRIUM_VERSION; }

std::string history_json(const HistoryLine& h) {
  Json j;
  j["seconds"] = h.seconds;
  j["cpu_seconds"] = h.cpu_seconds;
  j["iteration"] = h.iteration;
  j["clusters_gathered"] = h.clusters_gathered;
  j["residual"] = h.residual;
  put_estimate(h.estimate, j);
  if (h.error_true >= 0) j["error_true"] = h.error_true;
  j["elements"] = h.elements;
  j["links"] = h.links;
  j["rays"] = h.rays;
  j["reads"] = h.reads;
  j["writes"] = h.writes;
  j["bytes_read"] = h.bytes_read;
  j["bytes_written"] = h.bytes_written;
  j["hit_ratio"] = h.hit_ratio;
  j["solver_seconds"] = h.solver_seconds;
  j["io_seconds"] = h.io_seconds;
  j["stall_seconds"] = h.stall_seconds;
  j["max_working_set_bytes"] = h.max_working_set_bytes;
  j["peak_rss_bytes"] = h.peak_rss_bytes;
  if (!h.working_sets.largest.empty())
    j["working_sets"] = {{"largest", h.working_sets.largest}, {"mean", h.working_sets.mean}};
  return j.dump();
}

std::string summary_json(const SolveSummary& s) {
  Json j;
  j["scene"] = s.scene;
  j["patches"] = s.patches;
  j["clusters"] = s.clusters;
  j["cells"] = s.cells;
  j["portals"] = s.portals;
  j["lights"] = s.lights;
  j["iterations"] = s.iterations;
  j["elements"] = s.elements;
  j["links"] = s.links;
  j["max_working_set_bytes"] = s.max_working_set_bytes;
  j["max_working_set_links"] = s.max_working_set_links;
  j["max_working_set_elements"] = s.max_working_set_elements;
  j["links_processed"] = s.links_processed;
  j["total_data_bytes"] = s.total_data_bytes;
  j["visibility"] = visibility_json(s.refined);
  j["store_bytes"] = s.store_bytes;
  j["flux_emitted"] = s.flux_emitted;
  j["flux_absorbed"] = s.flux_absorbed;
  j["flux_escaped"] = s.flux_escaped;
  j["hit_ratio"] = s.hit_ratio;
  j["reads"] = s.reads;
  j["writes"] = s.writes;
  j["evictions"] = s.evictions;
  j["bytes_read"] = s.bytes_read;
  j["bytes_written"] = s.bytes_written;
  j["solver_seconds"] = s.solver_seconds;
  j["io_seconds"] = s.io_seconds;
  j["stall_seconds"] = s.stall_seconds;
  j["total_seconds"] = s.total_seconds;
  j["residual"] = s.residual;
  put_estimate(s.estimate, j);
  if (s.error_true >= 0) j["error_true"] = s.error_true;
  j["stop_reason"] = s.stop_reason;
  j["exit_code"] = s.exit_code;
  j["left_out"] = Json::array();
  for (const LeftOut& l : s.left_out)
    j["left_out"].push_back({{"feature", l.feature}, {"why", l.why}});
  if (!s.from.empty())
    j["warm"] = {{"from", s.from},
                 {"patches_kept", s.warm.patches_kept},
                 {"elements_kept", s.warm.elements_kept},
                 {"clusters_changed", s.warm.clusters_changed},
                 {"clusters_reached", s.warm.clusters_reached},
                 {"clusters_kept", s.clusters - s.warm.clusters_reached}};
  j["threads"] = s.threads;
  j["checkpoints"] = s.checkpoints;
  j["resumes"] = s.resumes;
  j["reads_ahead"] = s.reads_ahead;
  j["streamed_bytes_read"] = s.streamed_bytes_read;
  j["streamed_bytes_written"] = s.streamed_bytes_written;
  j["live_bytes"] = s.live_bytes;
  j["allocated_bytes"] = s.allocated_bytes;
  j["links_kept"] = links_json(s);
  j["peak_rss_bytes"] = s.peak_rss_bytes;
  j["file_bytes"] = s.file_bytes;
  j["cpu_seconds"] = s.cpu_seconds;
  j["estimated"] = estimate_json(s.estimated);
  j["version"] = program_version();
  return j.dump(1) + "\n";
}

std::string run_toml(const SolveOptions& o) {
  std::vector<std::string> files;
  for (const std::string& f : o.scene.files) files.push_back(absolute(f));
  std::ostringstream t;
  t.precision(17);
  const auto path = [&](const char* key, const std::string& file) {
    if (!file.empty()) t << key << " = " << quoted(absolute(file)) << "\n";
  };
  // Numbers of 64 bits go as texts: TOML's own end at 2^63.
  const auto limit = [&](const char* key, auto value, const char* unit) {
    if (value != 0) t << key << " = \"" << value << unit << "\"\n";
  };
  t << "# The effective configuration of this run. What was not set has no line.\n"
    << "version = " << quoted(program_version()) << "\n"
    << "scene = " << list(files) << "\n";
  path("assign", o.scene.assign_file);
  t << "drop = " << list(o.scene.drop) << "\n"
    << "sides = " << quoted(name(o.scene.sides)) << "\n"
    << "unit = \"" << o.scene.unit << "m\"\n"
    << "emission = " << (o.scene.emission_is_exitance ? "\"exitance\"" : "\"luminance\"") << "\n"
    << "white = " << o.scene.white << "\n";
  limit("close-gaps", o.partition.close_gaps, "m");
  t << "memory = \"" << o.memory << "\"\n";
  limit("arena", o.arena, "");
  t << "error = " << o.error << "\n";
  limit("residual", o.residual, "");
  limit("iterations", o.iterations, "");
  limit("time-limit", o.time_limit, "s");
  limit("min-edge", o.min_edge, "m");
  t << "order = " << quoted(o.order) << "\n"
    << "policy = " << quoted(o.policy) << "\n"
    << "basis = " << o.basis << "\n"
    << "links = " << quoted(o.links) << "\n"
    << "seed = \"" << o.seed << "\"\n";
  limit("threads", o.threads, "");
  path("reference", o.reference);
  t << "force = " << list(o.force) << "\n"
    << "io = " << quoted(o.io) << "\n"
    << "checkpoint-every = \"" << o.checkpoint_every << "s\"\n";
  path("trace", o.trace);
  path("from", o.from);
  return t.str();
}

}  // namespace atrium
