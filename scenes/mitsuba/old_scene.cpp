#include "old_scene.h"

#include <equistream/error.h>

#include <pugixml.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

namespace equistream::mitsuba_xml {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t size_limit = 256 << 20;
constexpr std::size_t file_limit = 1000;

/// What an old name has become; `advice` is the whole sentence where there is no other name.
struct Renamed {
    std::string_view of;  ///< the element it belongs to; empty for any
    std::string_view old_name, new_name, advice;
};

constexpr std::array elements{
    Renamed{"", "srgb", "rgb", ""},
    Renamed{"", "lookAt", "lookat", ""},
    Renamed{"", "luminaire", "emitter", ""},
    Renamed{"", "camera", "sensor", ""},
    Renamed{"", "blackbody", "",
            "write <spectrum type=\"blackbody\"> with a <float name=\"temperature\"> in place of "
            "<blackbody>"},
    Renamed{"", "animation", "transform", ""},
    Renamed{"", "subsurface", "", "leave out <subsurface>: subsurface scattering is a medium now (homogeneous)"},
};

constexpr std::array plugins{
    Renamed{"integrator", "bdpt", "path", ""},
    Renamed{"integrator", "pssmlt", "path", ""},
    Renamed{"integrator", "mlt", "path", ""},
    Renamed{"integrator", "erpt", "path", ""},
    Renamed{"integrator", "photonmapper", "path", ""},
    Renamed{"integrator", "ppm", "path", ""},
    Renamed{"integrator", "sppm", "path", ""},
    Renamed{"integrator", "vpl", "path", ""},
    Renamed{"integrator", "irrcache", "", "leave out the integrator irrcache and keep the one in it"},
    Renamed{"integrator", "adaptive", "", "leave out the integrator adaptive and keep the one in it"},
    Renamed{"integrator", "volpath_simple", "volpath", ""},
    Renamed{"integrator", "ao", "path", ""},
    Renamed{"sensor", "spherical", "equirect", ""},
    Renamed{"sensor", "telecentric", "orthographic", ""},
    Renamed{"sensor", "perspective_rdist", "perspective", ""},
    Renamed{"sampler", "halton", "multijitter", ""},
    Renamed{"sampler", "hammersley", "multijitter", ""},
    Renamed{"sampler", "sobol", "multijitter", ""},
    Renamed{"film", "ldrfilm", "hdrfilm", ""},
    Renamed{"film", "tiledhdrfilm", "hdrfilm", ""},
    Renamed{"film", "mfilm", "hdrfilm", ""},
    Renamed{"bsdf", "phong", "roughplastic", ""},
    Renamed{"bsdf", "ward", "roughconductor", ""},
    Renamed{"bsdf", "coating", "plastic", ""},
    Renamed{"bsdf", "roughcoating", "roughplastic", ""},
    Renamed{"bsdf", "difftrans", "diffuse", ""},
    Renamed{"bsdf", "roughdiffuse", "diffuse", ""},
    Renamed{"bsdf", "hk", "diffuse", ""},
    Renamed{"bsdf", "irawan", "diffuse", ""},
    Renamed{"bsdf", "mixturebsdf", "blendbsdf", ""},
    Renamed{"texture", "gridtexture", "checkerboard", ""},
    Renamed{"texture", "scale", "", "leave out the texture scale and scale the colours of the one in it"},
    Renamed{"texture", "wireframe", "", "leave out the texture wireframe: write <rgb> in its place"},
    Renamed{"texture", "curvature", "", "leave out the texture curvature: write <rgb> in its place"},
    Renamed{"texture", "vertexcolors", "",
            "write <texture type=\"mesh_attribute\"> with a <string name=\"name\" "
            "value=\"vertex_color\"/> in place of the texture vertexcolors"},
    Renamed{"emitter", "sun", "sunsky", ""},
    Renamed{"emitter", "sky", "sunsky", ""},
    Renamed{"emitter", "collimated", "directional", ""},
    Renamed{"shape", "heightfield", "", "write a mesh (ply, obj) in place of the shape heightfield"},
    Renamed{"shape", "hair", "bsplinecurve", ""},
    Renamed{"shape", "deformable", "ply", ""},
    Renamed{"phase", "hg_mixture", "blendphase", ""},
    Renamed{"phase", "mixturephase", "blendphase", ""},
    Renamed{"phase", "kkay", "hg", ""},
    Renamed{"phase", "microflake", "sggx", ""},
};

/// Values of <string>, by the property's name in both spellings.
constexpr std::array values{
    Renamed{"filterType", "trilinear", "bilinear", ""},
    Renamed{"filterType", "ewa", "bilinear", ""},
    Renamed{"filter_type", "trilinear", "bilinear", ""},
    Renamed{"filter_type", "ewa", "bilinear", ""},
    Renamed{"distribution", "phong", "beckmann", ""},
    Renamed{"distribution", "as", "ggx", ""},
    Renamed{"wrapMode", "zero", "clamp", ""},
    Renamed{"wrapMode", "one", "clamp", ""},
    Renamed{"fileFormat", "png", "openexr", ""},
    Renamed{"fileFormat", "jpeg", "openexr", ""},
    Renamed{"wrap_mode", "zero", "clamp", ""},
    Renamed{"wrap_mode", "one", "clamp", ""},
};

/// Properties without a successor of the same meaning.
constexpr std::array properties{
    Renamed{"integrator", "strictNormals", "", "leave out strictNormals"},
    Renamed{"film", "attachLog", "", "leave out attachLog"},
    Renamed{"film", "highQualityEdges", "", "leave out highQualityEdges"},
    Renamed{"film", "gamma", "", "leave out gamma: an hdrfilm is linear"},
    Renamed{"medium", "sigmaS", "", "write albedo, sigmaS / (sigmaS + sigmaA), in place of sigmaS"},
    Renamed{"medium", "sigmaA", "", "write sigma_t, sigmaS + sigmaA, in place of sigmaA"},
    Renamed{"bsdf", "exponent", "", "write alpha, sqrt(2 / (exponent + 2)), in place of exponent"},
    Renamed{"emitter", "sunRadiusScale", "", "leave out sunRadiusScale"},
    Renamed{"bsdf", "extEta", "", "leave out extEta: eta and k are relative to the outside"},
    Renamed{"shape", "maxSmoothAngle", "", "leave out maxSmoothAngle"},
    Renamed{"texture", "gamma", "", "write <boolean name=\"raw\"> in place of gamma: true where it is 1"},
};

template <std::size_t N>
const Renamed* find(const std::array<Renamed, N>& table, std::string_view of, std::string_view name) {
    const auto row = std::find_if(table.begin(), table.end(), [&](const Renamed& each) {
        return each.old_name == name && (each.of.empty() || each.of == of);
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

    void say(File& file, const pugi::xml_node& node, const Renamed& row, const std::string& kind) {
        say(file, node,
            row.advice.empty()
                ? "write " + kind + std::string(row.new_name) + " in place of " + std::string(row.old_name)
                : std::string(row.advice));
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
        if (const Renamed* row = find(elements, "", tag))
            say(file, node, *row, "the element ");
        if (const Renamed* row = find(plugins, tag, node.attribute("type").value()))
            say(file, node, *row, "the " + std::string(tag) + " ");
        if (tag == "include")
            include(file, node, version);
        if (tag == "string")
            if (const Renamed* row = find(values, name, value))
                say(file, node, *row, "the " + name + " ");
        if (tag == "spectrum" && is_list_of_colours(value))
            say(file, node, "write the element rgb in place of spectrum: its values are red, green, blue");
        if (tag == "rgb" && value.find('#') != value.npos)
            say(file, node, "write three numbers from 0 to 1 in place of #rrggbb");
        if (const Renamed* row = find(properties, node.parent().name(), name))
            say(file, node, *row, "");
        else if (const std::string now = underscored(name); version >= 2 && tag != "default" && !now.empty())
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
