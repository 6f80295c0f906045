#include "obj_document.h"

#include "obj_files.h"
#include "polygon.h"

#include <equistream/camera_limits.h>
#include <equistream/error.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace equistream {

namespace {

constexpr std::size_t element_limit = std::size_t{1} << 28;  ///< corners of all triangles, and vertices, each
constexpr std::size_t polygon_limit = 4096;
constexpr std::size_t object_limit = std::size_t{1} << 20;
constexpr std::size_t index_digits = 9;

class ObjReader {
public:
    ObjReader(const std::filesystem::path& file, ObjNotes& notes) : path_(file), lines_(file, "model"), notes_(notes) {
        out_.file = file.string();
    }

    ObjDocument read() {
        tinyobj::callback_t callbacks;
        callbacks.vertex_cb = [](void* self, float x, float y, float z, float) { of(self).add_position({x, y, z}); };
        callbacks.normal_cb = [](void* self, float x, float y, float z) {
            of(self).out_.normals.push_back(of(self).finite(glm::vec3(x, y, z), "vn"));
        };
        callbacks.texcoord_cb = [](void* self, float x, float y, float) {
            of(self).out_.uvs.push_back(of(self).finite(glm::vec2(x, y), "vt"));
        };
        StatementStream stream([this] { return next(); });
        tinyobj::LoadObjWithCallback(stream, callbacks, this);
        finish_materials();
        return std::move(out_);
    }

private:
    static ObjReader& of(void* self) { return *static_cast<ObjReader*>(self); }
    std::string where() const { return lines_.where(line_); }

    /// The next statement that tinyobjloader is to see: a vertex. The others on the way there are read here.
    std::optional<std::string> next() {
        while (const auto line = lines_.next()) {
            line_ = line->number;
            const std::string& keyword = line->keyword;
            if (keyword == "v" || keyword == "vn" || keyword == "vt")
                return vertex_statement(*line);
            if (keyword == "f" || keyword == "fo")
                read_face(*line);
            else if (keyword == "g")
                begin_group(*line);
            else if (keyword == "usemtl" && !line->rest.empty())
                use_material(line->rest);
            else if (keyword == "o" && !line->rest.empty())
                begin_object(line->rest);
            else if (keyword == "s")
                set_smoothing_group(*line);
            else if (keyword == "mtllib")
                material_names_.insert(line->rest).second ? read_materials(line->rest) : void();
            else if (keyword != "usemtl" && keyword != "o")
                notes_.add(where(), "\"" + keyword + "\" is not used");
        }
        return std::nullopt;
    }

    /// `v` must be numbers; other vertices that are none count as 0, as some exporters write "-1.#IND" for a normal.
    std::string vertex_statement(const ObjLine& line) {
        const std::size_t wanted = line.keyword == "vt" ? 1 : 3;
        std::string text = line.keyword;
        std::size_t numbers = 0;
        for (std::size_t at = 0; numbers < 3 && at < line.rest.size(); ++numbers) {
            std::string word(line.next_word(at));
            if (word.empty() || word.front() == '#')
                break;
            if (!obj_number(word)) {
                if (line.keyword == "v")
                    throw InputError(expected_found(where(), "numbers after v", word));
                notes_.add(where(), "a number of " + line.keyword + " is none: taken as 0");
                word = "0";
            }
            text += " " + (word.front() == '+' ? word.substr(1) : word);
        }
        if (numbers < wanted)
            throw InputError(expected_found(where(), std::to_string(wanted) + " numbers after " + line.keyword,
                                            std::to_string(numbers)));
        if (std::max({out_.positions.size(), out_.normals.size(), out_.uvs.size()}) >= element_limit)
            throw InputError(expected_found(where(), "fewer than 2^28 vertices", "more"));
        return text;
    }

    void read_face(const ObjLine& line) {
        face_.clear();
        for (std::size_t at = 0; at < line.rest.size();) {
            const std::string_view word = line.next_word(at);
            if (word.empty() || word.front() == '#')
                break;
            face_.push_back(corner_of(word));
        }
        if (!face_.empty())
            add_face();
    }

    /// Numbers of v, vt and vn in "12", "12/5", "12//7" or "12/5/7", each with a sign or without; 0: not given. Slashes
    /// with nothing behind them are common.
    std::array<int, 3> corner_of(std::string_view word) const {
        std::array<int, 3> numbers{};
        const std::string_view corner = word.substr(0, word.find_last_not_of('/') + 1);
        bool good = std::count(word.begin(), word.end(), '/') <= 2;
        for (std::size_t part = 0, at = 0; good && at <= corner.size(); ++part) {
            std::string_view text = corner.substr(at, corner.find('/', at) - at);
            at += text.size() + 1;
            if (text.size() > 1 && text[0] == '+' && text[1] != '-')  // from_chars takes none
                text.remove_prefix(1);
            const char* end = text.data() + text.size();
            good = text.empty() || text == "-" ? part == 1
                                               : std::from_chars(text.data(), end, numbers[part]).ptr == end &&
                                                     text.size() - text.starts_with('-') <= index_digits;
        }
        if (!good)
            throw InputError(expected_found(where(), "corners like 1, 1/2, 1//3 or 1/2/3 after f", std::string(word)));
        return numbers;
    }

    void set_smoothing_group(const ObjLine& line) {
        std::size_t at = 0;
        const std::string word(line.next_word(at));
        const auto number = obj_number(word);
        if (!number && word != "off" && word != "on")
            notes_.add(where(), "a smoothing group that is no number: taken as off");
        smoothing_group_ = word == "on"                             ? 1
                           : number && *number > 0 && *number < 1e9 ? static_cast<std::uint32_t>(*number)
                                                                    : 0;
    }

    /// Numbers that are too large for floats count as 0 too.
    template <typename Vector>
    Vector finite(Vector v, const char* keyword) {
        for (int i = 0; i < v.length(); ++i)
            if (!std::isfinite(v[i])) {
                notes_.add(where(), std::string("a number of ") + keyword + " is too large: taken as 0");
                v[i] = 0;
            }
        return v;
    }

    void add_position(const glm::vec3& p) {
        if (!is_position(p))
            throw InputError(expected_found(where(), "coordinates from -1e9 to 1e9", "one outside"));
        out_.positions.push_back(p);
    }

    /// Index from 0 of what `index` (from 1, or back from -1) means among `count`; no_index if it is not there.
    static std::uint32_t resolved(int index, std::size_t count) {
        const auto n = static_cast<std::int64_t>(count);
        const std::int64_t from_0 = index > 0 ? index - std::int64_t{1} : n + index;
        return index != 0 && from_0 >= 0 && from_0 < n ? static_cast<std::uint32_t>(from_0) : no_index;
    }

    void add_face() {
        if (face_.size() > polygon_limit)
            throw InputError(expected_found(where(), "a face of at most 4096 corners", std::to_string(face_.size())));
        corners_.clear();
        for (const auto& [v, vt, vn] : face_) {
            const ObjCorner corner{resolved(v, out_.positions.size()), resolved(vt, out_.uvs.size()),
                                   resolved(vn, out_.normals.size())};
            if (corner.position == no_index)
                throw InputError(expected_found(where(),
                                                "one of the " + std::to_string(out_.positions.size()) +
                                                    " vertices so far (1 is the first, -1 the last)",
                                                std::to_string(v)));
            if ((vt != 0 && corner.uv == no_index) || (vn != 0 && corner.normal == no_index))
                notes_.add(where(), "a vt or vn that does not exist: left out");
            // A corner that is repeated makes no area, but would hide the polygon's ears.
            if (corners_.empty() || corners_.back().position != corner.position)
                corners_.push_back(corner);
        }
        while (corners_.size() > 1 && corners_.back().position == corners_.front().position)
            corners_.pop_back();
        if (corners_.size() < 3)
            return notes_.add(where(), "a face without an area is left out");
        add_triangles();
    }

    void add_triangles() {
        polygon_.clear();
        triangles_.clear();
        for (const ObjCorner& corner : corners_)
            polygon_.push_back(out_.positions[corner.position]);
        triangulate(polygon_, triangles_);
        ObjPart& part = current_part();
        for (const auto& t : triangles_) {
            const glm::dvec3 a(polygon_[t[0]]), b(polygon_[t[1]]), c(polygon_[t[2]]);
            if (glm::cross(b - a, c - a) == glm::dvec3(0)) {
                notes_.add(where(), "a face without an area is left out");
                continue;
            }
            for (const std::uint32_t corner : t)
                part.corners.push_back(corners_[corner]);
            part.smoothing_groups.push_back(smoothing_group_);
            corner_count_ += 3;
        }
        if (corner_count_ >= element_limit)
            throw InputError(expected_found(where(), "fewer than 2^28 corners of triangles", "more"));
    }

    ObjPart& current_part() {
        if (!part_) {
            const auto [entry, added] = part_of_.try_emplace({current_object(), material_}, out_.parts.size());
            if (added) {
                out_.parts.emplace_back();
                out_.parts.back().object = entry->first.first;
                out_.parts.back().material = material_;
            }
            part_ = entry->second;
        }
        return out_.parts[*part_];
    }

    std::uint32_t object_named(const std::string& name, int parent) {
        const auto [entry, added] = object_of_.try_emplace({parent, name}, out_.objects.size());
        if (added) {
            if (out_.objects.size() >= object_limit)
                throw InputError(expected_found(where(), "fewer than 2^20 objects and groups", "more"));
            out_.objects.push_back({name, parent, glm::mat4(1)});
        }
        return entry->second;
    }

    std::uint32_t current_object() {
        if (group_ && (object_ < 0 || *group_ != out_.objects[static_cast<std::size_t>(object_)].name))
            return object_named(*group_, object_);
        return object_ < 0 ? object_named("default", -1) : static_cast<std::uint32_t>(object_);
    }

    void begin_object(const std::string& name) {
        object_ = static_cast<int>(object_named(name, -1));
        group_.reset();
        part_.reset();
    }

    void begin_group(const ObjLine& line) {
        std::string name;
        for (std::size_t at = 0; at < line.rest.size();)
            name += (name.empty() ? "" : " ") + std::string(line.next_word(at));
        group_ = name.empty() ? "default" : name;
        part_.reset();
    }

    /// Names are numbered as they are met and looked up at the end: an mtllib may come after its usemtl.
    void use_material(const std::string& name) {
        const auto [entry, added] = material_of_name_.try_emplace(name, used_names_.size());
        if (added)
            used_names_.push_back({name, where()});
        material_ = static_cast<std::uint32_t>(entry->second);
        part_.reset();
    }

    void read_materials(const std::string& names) {
        const auto files = find_material_files(path_.parent_path(), names);
        if (files.empty())
            notes_.add(where(), "no material file \"" + names + "\": left out");
        for (const auto& file : files) {
            std::error_code error;
            if (!material_files_.insert(std::filesystem::canonical(file, error)).second)
                continue;
            for (MtlMaterial& material : read_mtl(file, notes_))
                out_.materials.push_back(std::move(material));
            if (out_.materials.size() > material_limit)
                throw InputError(expected_found(where(), "at most 2^16 materials in all files", "more"));
        }
    }

    /// From numbers of names to indices into the materials; the first of a name counts.
    void finish_materials() {
        std::map<std::string, std::uint32_t> index_of_name;
        for (std::uint32_t i = 0; i < out_.materials.size(); ++i)
            if (!index_of_name.try_emplace(out_.materials[i].values.name, i).second)
                notes_.add(lines_of(out_.materials[i]),
                           "a second material of the name \"" + out_.materials[i].values.name + "\" is not used");
        const auto none = static_cast<std::uint32_t>(out_.materials.size());
        std::vector<std::uint32_t> index;
        for (const auto& [name, place] : used_names_) {
            const auto found = index_of_name.find(name);
            if (found == index_of_name.end())
                notes_.add(place, "no material \"" + name + "\": grey");
            index.push_back(found == index_of_name.end() ? none : found->second);
        }
        for (ObjPart& part : out_.parts)
            part.material = part.material == no_index ? none : index[part.material];
    }

    static std::string lines_of(const MtlMaterial& material) {
        return material.file + ":" + std::to_string(material.line);
    }

    std::filesystem::path path_;
    ObjLines lines_;
    ObjNotes& notes_;
    ObjDocument out_;
    int line_ = 0;
    int object_ = -1;  ///< -1: none begun
    std::optional<std::string> group_;
    std::uint32_t material_ = no_index;  ///< number of a name
    std::uint32_t smoothing_group_ = 0;
    std::optional<std::size_t> part_;  ///< that faces go to; found anew after a change
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> part_of_;  ///< by object and material
    std::map<std::pair<int, std::string>, std::uint32_t> object_of_;          ///< by parent and name
    std::map<std::string, std::size_t> material_of_name_;
    std::vector<std::pair<std::string, std::string>> used_names_;  ///< name, where it is first used
    std::set<std::string> material_names_;                         ///< of mtllib statements
    std::set<std::filesystem::path> material_files_;               ///< that have been read
    std::size_t corner_count_ = 0;
    std::vector<std::array<int, 3>> face_;  ///< of the face being read: what its corners say
    std::vector<ObjCorner> corners_;        ///< what they mean
    std::vector<glm::vec3> polygon_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
};

}  // namespace

ObjDocument read_obj(const std::filesystem::path& file, ObjNotes& notes) {
    return ObjReader(file, notes).read();
}

}  // namespace equistream
