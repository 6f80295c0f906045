#include "old_scene.h"

#include <equistream/error.h>

#include <pugixml.hpp>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <optional>
#include <ranges>
#include <set>
#include <span>
#include <sstream>
#include <string_view>
#include <utility>

namespace equistream::mitsuba_xml {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t size_limit = 256 << 20;
constexpr std::size_t file_limit = 1000;

/// What old names have become. Several names stand in one text between blanks.
struct Renamed {
    std::string_view of;  ///< the elements they belong to; empty for any
    std::string_view old_names, new_name;
    std::string_view advice = {};  ///< the whole sentence where there is no other name
};

constexpr Renamed elements[] = {
    {"", "srgb", "rgb"},
    {"", "lookAt", "lookat"},
    {"", "luminaire", "emitter"},
    {"", "camera", "sensor"},
    {"", "blackbody", "",
     "write <spectrum type=\"blackbody\"> with a <float name=\"temperature\"> in place of <blackbody>"},
    {"", "animation", "transform"},
    {"", "subsurface", "", "leave out <subsurface>: subsurface scattering is a medium now (homogeneous)"},
};

constexpr Renamed plugins[] = {
    {"integrator", "bdpt pssmlt mlt erpt photonmapper ppm sppm vpl ao", "path"},
    {"integrator", "irrcache", "", "leave out the integrator irrcache and keep the one in it"},
    {"integrator", "adaptive", "", "leave out the integrator adaptive and keep the one in it"},
    {"integrator", "volpath_simple", "volpath"},
    {"sensor", "spherical", "equirect"},
    {"sensor", "telecentric", "orthographic"},
    {"sensor", "perspective_rdist", "perspective"},
    {"sampler", "halton hammersley sobol", "multijitter"},
    {"film", "ldrfilm tiledhdrfilm mfilm", "hdrfilm"},
    {"bsdf", "phong roughcoating", "roughplastic"},
    {"bsdf", "ward", "roughconductor"},
    {"bsdf", "coating", "plastic"},
    {"bsdf", "difftrans roughdiffuse hk irawan", "diffuse"},
    {"bsdf", "mixturebsdf", "blendbsdf"},
    {"texture", "gridtexture", "checkerboard"},
    {"texture", "scale", "", "leave out the texture scale and scale the colours of the one in it"},
    {"texture", "wireframe", "", "leave out the texture wireframe: write <rgb> in its place"},
    {"texture", "curvature", "", "leave out the texture curvature: write <rgb> in its place"},
    {"texture", "vertexcolors", "",
     "write <texture type=\"mesh_attribute\"> with a <string name=\"name\" value=\"vertex_color\"/> in place of the "
     "texture vertexcolors"},
    {"emitter", "sun sky", "sunsky"},
    {"emitter", "collimated", "directional"},
    {"shape", "heightfield", "", "write a mesh (ply, obj) in place of the shape heightfield"},
    {"shape", "hair", "bsplinecurve"},
    {"shape", "deformable", "ply"},
    {"phase", "hg_mixture mixturephase", "blendphase"},
    {"phase", "kkay", "hg"},
    {"phase", "microflake", "sggx"},
};

/// Values of <string>, by the property's name in both spellings.
constexpr Renamed values[] = {
    {"filterType filter_type", "trilinear ewa", "bilinear"},
    {"distribution", "phong", "beckmann"},
    {"distribution", "as", "ggx"},
    {"wrapMode wrap_mode", "zero one", "clamp"},
    {"fileFormat", "png jpeg", "openexr"},
};

/// Properties without a successor of the same meaning.
constexpr Renamed properties[] = {
    {"integrator", "strictNormals", "", "leave out strictNormals"},
    {"film", "attachLog", "", "leave out attachLog"},
    {"film", "highQualityEdges", "", "leave out highQualityEdges"},
    {"film", "gamma", "", "leave out gamma: an hdrfilm is linear"},
    {"medium", "sigmaS", "", "write albedo, sigmaS / (sigmaS + sigmaA), in place of sigmaS"},
    {"medium", "sigmaA", "", "write sigma_t, sigmaS + sigmaA, in place of sigmaA"},
    {"bsdf", "exponent", "", "write alpha, sqrt(2 / (exponent + 2)), in place of exponent"},
    {"emitter", "sunRadiusScale", "", "leave out sunRadiusScale"},
    {"bsdf", "extEta", "", "leave out extEta: eta and k are relative to the outside"},
    {"shape", "maxSmoothAngle", "", "leave out maxSmoothAngle"},
    {"texture", "gamma", "", "write <boolean name=\"raw\"> in place of gamma: true where it is 1"},
};

bool lists(std::string_view names, std::string_view name) {
    return names.find(name) != names.npos && std::ranges::any_of(std::views::split(names, ' '), [&](const auto& each) {
               return std::string_view(each.begin(), each.end()) == name;
           });
}

const Renamed* find(std::span<const Renamed> table, std::string_view of, std::string_view name) {
    const auto row = std::ranges::find_if(table, [&](const Renamed& each) {
        return lists(each.old_names, name) && (each.of.empty() || lists(each.of, of));
    });
    return row == table.end() ? nullptr : &*row;
}

/// toWorld: to_world. Empty for a name without a capital behind a small letter.
std::string underscored(std::string_view name) {
    std::string text;
    bool changed = false;
    for (std::size_t i = 0; i < name.size(); ++i) {
        const auto is = [&](std::size_t at, int (*kind)(int)) {
            return kind(static_cast<unsigned char>(name[at])) != 0;
        };
        const bool capital = is(i, std::isupper);
        if (capital && i > 0 && is(i - 1, std::islower)) {
            text += '_';
            changed = true;
        }
        text += static_cast<char>(capital ? std::tolower(static_cast<unsigned char>(name[i])) : name[i]);
    }
    return changed ? text : "";
}

/// A list of colours, unlike "0.5" and "400:0.1, 500:0.2".
bool is_list_of_colours(std::string_view value) {
    const std::size_t first = value.find_first_not_of(" \t\r\n");
    return first != value.npos && value.find_first_of(", \t\r\n", first) < value.find_last_of("0123456789") &&
           value.find(':') == value.npos;
}

struct File {
    explicit File(const fs::path& name) : path(name) {
        std::error_code error;
        if (!fs::is_regular_file(name, error))
            throw InputError(expected_found(name.string(), "a scene in Mitsuba's XML", "no such file"));
        if (fs::file_size(name, error) > size_limit || error)
            throw InputError(expected_found(name.string(), "a scene in Mitsuba's XML", "more than 256 MiB"));
        std::ostringstream bytes;
        bytes << std::ifstream(name, std::ios::binary).rdbuf();
        text = bytes.str();
        const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
        if (!result || !document.document_element())
            throw InputError(expected_found(name.string() + ":" + std::to_string(line_at(result.offset)),
                                            "a scene in Mitsuba's XML", result.description()));
    }

    /// Of offsets in ascending order.
    int line_at(std::ptrdiff_t offset) {
        for (; counted < offset && static_cast<std::size_t>(counted) < text.size(); ++counted)
            line += text[static_cast<std::size_t>(counted)] == '\n';
        return line;
    }

    fs::path path;
    std::string text;
    pugi::xml_document document;
    std::ptrdiff_t counted = 0;
    int line = 1;
};

class Changes {
public:
    /// The properties of versions before 2 are renamed by Mitsuba 3 itself. `version`: that of what includes the file.
    void read(const fs::path& xml, std::optional<int> version) {
        if (!read_.insert(fs::weakly_canonical(xml)).second || read_.size() > file_limit)
            return;
        File file(xml);
        const pugi::xml_node root = file.document.document_element();
        if (const pugi::xml_attribute own = root.attribute("version"))
            version = own.as_int();
        else if (!version)
            say(file, root, "write <scene version=\"0.6.0\">: Mitsuba 3 then renames toWorld and the like by itself");
        visit(file, root, version.value_or(0));
    }

    std::vector<std::string> list() const {
        std::vector<std::string> lines;
        for (const Change& change : changes_)
            lines.push_back(quotable(change.place + ": " + change.what, 900) +
                            (change.times > 1 ? " (" + std::to_string(change.times) + " times)" : ""));
        return lines;
    }

private:
    struct Change {
        std::string place, what;
        int times = 1;
    };

    /// The same thing is said of a file once, where it comes first.
    void say(File& file, const pugi::xml_node& node, const std::string& what) {
        const auto [known, is_new] = places_.try_emplace({file.path.string(), what}, changes_.size());
        if (is_new)
            changes_.push_back({file.path.string() + ":" + std::to_string(file.line_at(node.offset_debug())), what});
        else
            ++changes_[known->second].times;
    }

    /// `kind`: what the name is, with a blank behind it.
    bool say_renamed(File& file, const pugi::xml_node& node, std::span<const Renamed> table, std::string_view of,
                     std::string_view name, const std::string& kind) {
        const Renamed* row = find(table, of, name);
        if (row)
            say(file, node,
                row->advice.empty() ? "write " + kind + std::string(row->new_name) + " in place of " + std::string(name)
                                    : std::string(row->advice));
        return row != nullptr;
    }

    /// In the order of the file, without recursion: XML may nest as deep as it likes.
    void visit(File& file, const pugi::xml_node& root, int version) {
        for (pugi::xml_node node = root; node;) {
            if (node.type() == pugi::node_element)
                look_at(file, node, version);
            if (node.first_child()) {
                node = node.first_child();
                continue;
            }
            while (node != root && !node.next_sibling())
                node = node.parent();
            if (node == root)
                return;
            node = node.next_sibling();
        }
    }

    void look_at(File& file, const pugi::xml_node& node, int version) {
        const std::string_view tag = node.name(), value = node.attribute("value").value();
        const std::string name = node.attribute("name").value();
        say_renamed(file, node, elements, "", tag, "the element ");
        say_renamed(file, node, plugins, tag, node.attribute("type").value(), "the " + std::string(tag) + " ");
        if (tag == "include")
            include(file, node, version);
        if (tag == "string")
            say_renamed(file, node, values, name, value, "the " + name + " ");
        if (tag == "spectrum" && is_list_of_colours(value))
            say(file, node, "write the element rgb in place of spectrum: its values are red, green, blue");
        if (tag == "rgb" && value.find('#') != value.npos)
            say(file, node, "write three numbers from 0 to 1 in place of #rrggbb");
        const bool said = say_renamed(file, node, properties, node.parent().name(), name, "");
        if (const std::string now = underscored(name); !said && version >= 2 && tag != "default" && !now.empty())
            say(file, node, "write the name " + now + " in place of " + name);
    }

    void include(const File& file, const pugi::xml_node& node, int version) {
        const fs::path included = file.path.parent_path() / node.attribute("filename").value();
        std::error_code error;
        if (fs::is_regular_file(included, error))
            read(included, version);
    }

    std::set<fs::path> read_;
    std::vector<Change> changes_;
    std::map<std::pair<std::string, std::string>, std::size_t> places_;  ///< of file and sentence
};

}  // namespace

std::vector<std::string> changes_for_mitsuba3(const fs::path& xml) {
    Changes changes;
    changes.read(xml, std::nullopt);
    return changes.list();
}

}  // namespace equistream::mitsuba_xml
