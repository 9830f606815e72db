#include "engine/import/read_obj.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <unordered_map>

#include "engine/import/read_mtl.h"
#include "engine/import/text.h"

namespace atrium {
namespace {

// Statements of OBJ that say nothing about surfaces or that this engine has no use for.
constexpr std::string_view kIgnored[] = {"vt",        "vn",       "s",      "bevel",
                                         "c_interp",  "d_interp", "lod",    "shadow_obj",
                                         "trace_obj", "maplib",   "usemap", "mg"};
// Geometry that is left out, with a warning.
constexpr std::string_view kLeftOut[] = {"p",    "l",     "vp",   "cstype", "deg",  "bmat", "step",
                                         "curv", "curv2", "surf", "parm",   "trim", "hole", "scrv",
                                         "sp",   "end",   "con",  "ctech",  "stech"};

template <std::size_t N>
bool is_one_of(std::string_view word, const std::string_view (&list)[N]) {
  return std::find(std::begin(list), std::end(list), word) != std::end(list);
}

bool looks_like_a_keyword(std::string_view word) {
  return std::all_of(word.begin(), word.end(),
                     [](unsigned char c) { return std::isalnum(c) || c == '_'; });
}

class ObjReader {
 public:
  ObjReader(const std::string& path, RawModel& model, WarningLog& warnings)
      : path_(path),
        model_(model),
        warnings_(warnings),
        file_(static_cast<std::uint32_t>(model.files.size())),
        first_vertex_(model.vertices.size()),
        first_face_(model.faces.size()) {
    model_.files.push_back(path);
  }

  Status read() {
    const Result<std::string> text = read_whole_file(path_);
    if (!text.ok()) return text.status();
    has_objects_ = names_objects(*text);
    Statements statements(*text);
    while (statements.next()) {
      cut_off_ = statements.at_end() && !text->ends_with('\n');
      ATRIUM_RETURN_IF_ERROR(statement(statements));
    }
    return finish();
  }

 private:
  // `o` blocks are the objects; `g` blocks only where a file has no `o`.
  static bool names_objects(std::string_view text) {
    return text.starts_with("o ") || text.find("\no ") != std::string_view::npos ||
           text.find("\no\t") != std::string_view::npos;
  }

  Status broken(const std::string& cause, const std::string& remedy) const {
    return Status(Code::kScene, path_, "line " + std::to_string(line_), cause, remedy);
  }

  Status statement(const Statements& s) {
    line_ = s.line();
    const std::string_view word = s.keyword();
    if (word == "v") return vertex(s.words());
    if (word == "f" || word == "fo") return face(s.words());
    if (word == "o" || word == "g") return object(s);
    if (word == "usemtl") return use_material(s.remainder());
    if (word == "mtllib") return library(s);
    if (is_one_of(word, kIgnored)) return {};
    if (is_one_of(word, kLeftOut)) {
      warnings_.add("points, lines, curves and free-form surfaces left out",
                    path_ + ", line " + std::to_string(line_));
      return {};
    }
    if (!looks_like_a_keyword(word))
      return broken("is no OBJ statement", "check that the file is a text OBJ and undamaged");
    warnings_.add("unknown statements ignored",
                  "'" + std::string(word) + "' in " + path_ + ", line " + std::to_string(line_));
    return {};
  }

  // x y z, with a weight or a colour or both behind them that nothing here reads.
  Status vertex(const std::vector<std::string_view>& words) {
    const std::size_t numbers = words.size() - 1;
    if (numbers < 3 || numbers == 5 || numbers > 7)
      return broken("a vertex has " + std::to_string(numbers) + " numbers, not 3",
                    "check the line; the file may be cut off");
    double values[7];
    for (std::size_t i = 0; i < numbers; ++i)
      if (!parse_finite(words[i + 1], values[i]))
        return broken("'" + std::string(words[i + 1]) + "' is not a finite number",
                      "write the vertex with three finite numbers");
    model_.vertices.push_back({values[0], values[1], values[2]});
    return {};
  }

  // The vertex of "v", "v/vt", "v//vn" or "v/vt/vn": from 1, or from -1 backwards.
  bool parse_corner(std::string_view word, long long& index) const {
    for (int part = 0; part < 3; ++part) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      const std::string_view number = word.substr(0, slash);
      long long value = 0;
      const bool may_be_empty = part == 1 && slash < word.size();
      const auto [rest, error] =
          std::from_chars(number.data(), number.data() + number.size(), value);
      const bool whole = error == std::errc() && rest == number.data() + number.size();
      if (!(number.empty() && may_be_empty) && (!whole || value == 0)) return false;
      if (part == 0) index = value;
      if (slash == word.size()) return true;
      word.remove_prefix(slash + 1);
    }
    return false;
  }

  Status face(const std::vector<std::string_view>& words) {
    // Some exporters write edges as faces of two corners: degenerate, unless the file ends there.
    if (words.size() == 1 || (words.size() < 4 && cut_off_))
      return broken("a face has " + std::to_string(words.size() - 1) + " corners, not 3 or more",
                    "check the line; the file may be cut off");
    RawFace f;
    f.first_corner = static_cast<std::uint32_t>(model_.corners.size());
    f.corner_count = static_cast<std::uint32_t>(words.size() - 1);
    f.object = current_object();
    f.material = material_;
    f.place = line_;
    const long long count = static_cast<long long>(model_.vertices.size() - first_vertex_);
    for (std::size_t i = 1; i < words.size(); ++i) {
      long long index = 0;
      if (!parse_corner(words[i], index))
        return broken("'" + std::string(words[i]) + "' is no corner of a face",
                      "write v, v/vt, v//vn or v/vt/vn with whole numbers other than 0");
      if (index < 0) index += count + 1;
      if (index < 1)
        return broken("corner " + std::string(words[i]) + " points before the first vertex",
                      "check the face's indices");
      if (index > count && (last_forward_line_ == 0 || index > largest_index_)) {
        largest_index_ = index;
        last_forward_line_ = line_;
      }
      model_.corners.push_back(static_cast<std::uint32_t>(first_vertex_ + index - 1));
    }
    model_.faces.push_back(f);
    return {};
  }

  Status object(const Statements& s) {
    if (s.keyword() == "g" && has_objects_) return {};
    const std::string name(s.remainder());
    if (object_open_ && name == object_name_) return {};
    object_open_ = true;
    object_name_ = name;
    object_started_ = false;
    named_ = true;
    return {};
  }

  // Objects come to be with their first face, so that empty groups leave no trace.
  std::uint32_t current_object() {
    if (!object_started_) {
      RawObject o;
      o.name = named_ ? (object_name_.empty() ? "unnamed" : object_name_)
                      : std::filesystem::path(path_).stem().string();
      o.file = file_;
      o.place_word = "line";
      o.unnamed_file = false;
      model_.objects.push_back(o);
      object_started_ = true;
    }
    return static_cast<std::uint32_t>(model_.objects.size() - 1);
  }

  Status use_material(std::string_view name) {
    const auto [at, added] = materials_.try_emplace(std::string(name), std::uint32_t{0});
    if (added) {
      warnings_.add("materials that no library defines, taken as the default",
                    "'" + std::string(name) + "' in " + path_);
      at->second = static_cast<std::uint32_t>(model_.materials.size());
      model_.materials.push_back(undefined_material(std::string(name), file_));
    }
    material_ = at->second;
    return {};
  }

  Status library(const Statements& s) {
    // The whole remainder may be one name with blanks in it, or several names.
    const std::filesystem::path folder = std::filesystem::path(path_).parent_path();
    const auto resolved = [&](std::string_view name) {
      std::string plain(name);
      std::replace(plain.begin(), plain.end(), '\\', '/');
      return (folder / plain).string();
    };
    std::vector<std::string> names{resolved(s.remainder())};
    if (!std::filesystem::exists(names[0])) {
      names.clear();
      for (std::size_t i = 1; i < s.words().size(); ++i) names.push_back(resolved(s.words()[i]));
    }
    for (const std::string& name : names) {
      if (!std::filesystem::exists(name)) {
        warnings_.add("material libraries not found", name + " named in " + path_);
        continue;
      }
      ATRIUM_RETURN_IF_ERROR(read_mtl(name, file_, model_, materials_, warnings_));
    }
    return {};
  }

  Status finish() {
    const std::size_t vertices = model_.vertices.size() - first_vertex_;
    if (largest_index_ > static_cast<long long>(vertices)) {
      line_ = last_forward_line_;
      return broken("corner " + std::to_string(largest_index_) + " is out of range: the file has " +
                        std::to_string(vertices) + " vertices",
                    "check the face's indices; the file may be cut off");
    }
    if (model_.faces.size() == first_face_)
      return Status(Code::kScene, path_, "", "holds no faces", "check that this is the right file");
    if (!named_) model_.objects.back().unnamed_file = true;
    return {};
  }

  const std::string& path_;
  RawModel& model_;
  WarningLog& warnings_;
  const std::uint32_t file_;
  const std::size_t first_vertex_, first_face_;
  std::unordered_map<std::string, std::uint32_t> materials_;  // by name, in this file
  std::uint32_t material_ = RawFace::kNoMaterial;
  std::string object_name_;
  bool has_objects_ = false, named_ = false, object_open_ = false, object_started_ = false;
  std::uint32_t line_ = 0;
  bool cut_off_ = false;  // the statement ends the file without ending its line
  // The largest index that pointed past the vertices read so far: settled at the file's end.
  long long largest_index_ = 0;
  std::uint32_t last_forward_line_ = 0;
};

}  // namespace

Status read_obj(const std::string& path, RawModel& model, WarningLog& warnings) {
  return ObjReader(path, model, warnings).read();
}

}  // namespace atrium
